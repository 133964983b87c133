// SPDX-License-Identifier: GPL-2.0-or-later
//
// For the count of instructions (tests/unit/test_pair_loop_cost.py): runs the pair style's loop without
// friction and bonds some number of times, and beside it one written by hand that knows of neither, on the same lists.
#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "atom.h"
#include "contact_batch.h"
#include "force.h"
#include "history.h"
#include "input.h"
#include "lammps.h"
#include "neigh_list.h"
#include "pair_floe.h"
#include "pair_gran.h"
#include "plugin.h"
#include "update.h"

using namespace LAMMPS_NS;
using namespace floe;

namespace {

// Damped, elastic, never attractive, with the overlap at rest that broken bonds leave: no more.
template <typename P, int Width>
FLOE_INLINE void push(const ContactTask &t, const Touching *pairs, int first, int count,
                      LaneSums &lost) {
  const double *row[Width], *one[Width], *two[Width];
  double *load_one[Width], *load_two[Width];
  P share;
  for (int k = 0; k < Width; ++k) {
    row[k] = pairs[k].history;
    one[k] = &t.bodies[pairs[k].i].x;
    two[k] = &t.bodies[pairs[k].j].x;
    load_one[k] = &t.loads[pairs[k].i].fx;
    load_two[k] = &t.loads[pairs[k].j].fx;
    share[k] = pairs[k].j < t.nlocal ? 1.0 : 0.5;
  }
  P h[4], d[4], a[4], b[4];
  columns(row, slot::slip, h);
  differences(two, one, d);
  columns(one, 4, a);
  columns(two, 4, b);
  const P zero{}, distance = root(d[0] * d[0] + d[1] * d[1]);
  const P overlap = (a[3] + b[3]) - distance, rest = larger(zero, smaller(h[1], overlap));
  const P inv = 1.0 / distance, nx = d[0] * inv, ny = d[1] * inv, vn = d[2] * nx + d[3] * ny;
  const P elastic = h[2] * (overlap - rest), fn = larger(elastic - h[3] * vn, zero);
  P power = (elastic - fn) * vn;
  const auto idle = overlap - rest <= zero;
  Load nowhere{};
  if (any(idle) || count < Width) {
    for (int k = 0; k < Width; ++k) {
      if (k < count && !idle[k]) continue;
      load_one[k] = load_two[k] = &nowhere.fx;
      share[k] = power[k] = 0.0;
    }
  }
  if (t.advance) {
    for (int k = 0; k < Width; ++k) pairs[k].history[slot::rest_overlap] = rest[k];
  }
  lost.add(first, share * power);
  add_rows(load_one, {-fn * nx, -fn * ny, zero, zero});
  add_rows(load_two, {fn * nx, fn * ny, zero, zero});
}

template <typename P, int Width>
FLOE_INLINE void push_all(const ContactTask &t, Touching *pairs, int count, LaneSums &lost) {
  for (int k = count; k % 4; ++k) pairs[k] = pairs[k - 1];
  for (int first = 0; first < count; first += Width) {
    push<P, Width>(t, pairs + first, first % 4, count - first, lost);
  }
}

#if defined(__x86_64__)
[[gnu::target("avx2"), gnu::noinline]] void push_wide(const ContactTask &t, Touching *pairs,
                                                      int count, LaneSums &lost) {
  push_all<Pack4, 4>(t, pairs, count, lost);
}
#endif

[[gnu::noinline]] void push_some(const ContactTask &t, Touching *pairs, int count, LaneSums &lost) {
#if defined(__x86_64__)
  if (wide_packs()) return push_wide(t, pairs, count, lost);
#endif
  push_all<Pack2, 2>(t, pairs, count, lost);
}

}  // namespace

extern "C" [[gnu::noinline]] double loop_by_hand(const ContactTask &task, PairGran *pg,
                                                 const PairFloe *floe) {
  constexpr int room = 256;
  Touching touching[room + 3];
  int found = 0;
  LaneSums lost;
  const NeighList *list = pg->list, *past = pg->listgranhistory;
  const int size = pg->dnum();
  const Body *bodies = task.bodies;
  for (int ii = 0; ii < list->inum; ++ii) {
    const int i = list->ilist[ii], count = list->numneigh[i];
    const double x = bodies[i].x, y = bodies[i].y, radius = bodies[i].radius;
    const int *neighbour = list->firstneigh[i];
    int *flags = past->firstneigh[i];
    double *h = past->firstdouble[i];
    for (int jj = 0; jj < count; ++jj, h += size) {
      const int j = neighbour[jj] & NEIGHMASK;
      const double dx = bodies[j].x - x, dy = bodies[j].y - y, sum = radius + bodies[j].radius;
      if (dx * dx + dy * dy >= sum * sum) {
        if (!flags[jj]) continue;
        flags[jj] = 0;
        for (int k = 0; k < slot::contact_size; ++k) h[k] = 0.0;
        continue;
      }
      flags[jj] = 1;
      if (h[slot::contact_stiffness] == 0.0) floe->finish_contact(h, i, j);
      touching[found++] = {h, i, j};
      if (found < room) continue;
      push_some(task, touching, found, lost);
      found = 0;
    }
  }
  if (found) push_some(task, touching, found, lost);
  return lost.total();
}

int main(int argc, char **argv) {
  MPI_Init(&argc, &argv);
  const char *quiet[] = {"count_loop", "-screen", "none", "-log", "none"};
  auto *lmp = new LAMMPS(5, const_cast<char **>(quiet), MPI_COMM_WORLD);
  register_models(lmp);
  // The discs overlap a little; the lists reach to the second neighbours, which do not touch.
  for (const char *line :
       {"units si", "dimension 2", "atom_style granular", "boundary m m p", "newton off",
        "communicate single vel yes", "lattice hex 1999",
        "region box block -3 33 -3 30 -2 2 units lattice", "create_box 2 box",
        "region ice block 0 30 0 16 -0.1 0.1 units lattice", "create_atoms 1 region ice",
        "set group all diameter 2000", "set group all density 917", "neighbor 1600 bin",
        "pair_style gran model floe bonds no friction no", "pair_coeff * *", "timestep 0.1",
        "fix motion all floe/integrate thickness 1", "run 0"}) {
    lmp->input->one(line);
  }
  const Parts parts = find_parts(lmp);
  const int n = lmp->atom->nlocal, steps = argc > 1 ? std::atoi(argv[1]) : 1;
  std::vector<Body> bodies(n);
  std::vector<Load> loads(n);
  for (int i = 0; i < n; ++i) {
    bodies[i] = {lmp->atom->x[i][0],  lmp->atom->x[i][1], 0.0, 0.0, 0.0, 1.0, 0.0,
                 lmp->atom->radius[i]};
  }
  const ContactTask task{parts.floe->contact, lmp->update->dt, true, n,
                         bodies.data(),       loads.data()};
  double lost = 0.0;
  for (int k = 0; k < steps; ++k) {
    loads.assign(n, Load{});
    lmp->force->pair->compute(0, 0);
    lost += loop_by_hand(task, parts.pair, parts.floe);
  }
  // The two agree: the forces of the last step, which compute() adds up in LIGGGHTS' array.
  double apart = 0.0, largest = 0.0;
  for (int i = 0; i < n; ++i) {
    const double f = lmp->atom->f[i][0] / (steps + 1);
    apart = std::max(apart, std::fabs(f - loads[i].fx));
    largest = std::max(largest, std::fabs(f));
  }
  std::printf("%d elements, %.3g of %.3g N apart, %.3g W lost\n", n, apart, largest, lost);
  const bool same = largest > 0.0 && apart <= 1e-9 * largest;
  delete lmp;
  MPI_Finalize();
  return same ? 0 : 1;
}
