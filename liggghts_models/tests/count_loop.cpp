// SPDX-License-Identifier: GPL-2.0-or-later
//
// For the count of instructions (tests/unit/dynamics/test_pair_loop_cost.py): runs loops of the pair
// style some number of times, the argument, and beside each one written by hand (by_hand.h) on the
// same pairs.
#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "atom.h"
#include "by_hand.h"
#include "fix_floe_integrate.h"
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

struct Listed {
  ContactRecords contacts;
  BondRecords bonds;
};

// Contacts start without slip; constants are the same for all, the discs are equal.
[[gnu::noinline]] void start(ContactRecords &contacts, int k, const PairFloe &floe) {
  const Ends ends = contacts.ends[k];
  const ContactConstants c =
      contact_constants(floe.contact, 1.0, 1.0, floe.reduced_mass(ends.i, ends.j()));
  contacts.ends[k].marked_j |= Ends::mark;
  contacts.rows[k] = {0.0, 0.0, c.stiffness, c.damping};
}

[[gnu::noinline]] void forget(ContactRecords &contacts, int k) {
  contacts.ends[k].marked_j &= ~Ends::mark;
}

Listed read_lists(PairGran *pair, const PairFloe &floe) {
  Listed out;
  const NeighList *list = pair->list, *past = pair->listgranhistory;
  const int size = pair->dnum();
  for (int ii = 0; ii < list->inum; ++ii) {
    const int i = list->ilist[ii];
    for (int jj = 0; jj < list->numneigh[i]; ++jj) {
      const int j = list->firstneigh[i][jj] & NEIGHMASK;
      double *h = past->firstdouble[i] + static_cast<std::ptrdiff_t>(size) * jj;
      if (floe.bonds && is_bond(past->firstneigh[i][jj], h)) {
        const int lo = floe.lower(i, j), hi = i + j - lo;
        const BondShape shape = bond_shape(h);
        const double strength = floe.compressive_strength(shape.thickness);
        out.bonds.add(lo, hi, 1.0, shape,
                      bond_constants(floe.bond, shape, strength, floe.reduced_mass(i, j)), {});
      } else {
        out.contacts.ends.push_back({i, j});
        out.contacts.rows.push_back({});
      }
    }
  }
  return out;
}

}  // namespace

extern "C" [[gnu::noinline]] double push_by_hand(const ContactTask &task, ContactRecords &contacts,
                                                 const PairFloe &floe) {
  LaneSums lost;
  by_hand::loop_contacts<by_hand::Push>(
      task, static_cast<int>(contacts.ends.size()), &lost, [&](int k) { start(contacts, k, floe); },
      [&](int k) { forget(contacts, k); });
  return lost.total();
}

extern "C" [[gnu::noinline]] double rub_by_hand(const ContactTask &task, ContactRecords &contacts,
                                                const PairFloe &floe) {
  LaneSums lost;
  by_hand::loop_contacts<by_hand::Rub>(
      task, static_cast<int>(contacts.ends.size()), &lost, [&](int k) { start(contacts, k, floe); },
      [&](int k) { forget(contacts, k); });
  return lost.total();
}

extern "C" [[gnu::noinline]] double stretch_by_hand(const PairFloe &floe, const BondRecords &bonds,
                                                    const ContactTask &t, std::vector<int> &odd) {
  const double limit2 = 0.998 * floe.reach * floe.reach;
#if defined(__x86_64__)
  if (wide_packs()) {
    by_hand::stretch_wide(floe.bond, limit2, bonds, t.bodies, t.loads, odd);
    return 0.0;
  }
#endif
  by_hand::stretch_all<Pack2, 2>(floe.bond, limit2, bonds, t.bodies, t.loads, odd);
  return 0.0;
}

// Whether the two agree.
bool run(const std::string &which, int steps) {
  const char *quiet[] = {"count_loop", "-screen", "none", "-log", "none"};
  auto *lmp = new LAMMPS(5, const_cast<char **>(quiet), MPI_COMM_WORLD);
  register_models(lmp);
  const std::string terms = which == "push" ? "bonds no friction no contact_damping 0.3"
                            : which == "rub"
                                ? "bonds no friction yes contact_damping 0"
                                : "bonds yes bond_damping 0 contact_damping 0.1 reach 1.2";
  const std::string style = "pair_style gran model floe " + terms;
  // The discs overlap a little; the lists reach to the second neighbours, which do not touch, but not
  // where all neighbours are bonded.
  const bool bonds = which == "stretch";
  for (const char *line :
       {"units si", "dimension 2", "atom_style granular", "boundary m m p", "newton off",
        "communicate single vel yes", "lattice hex 1999",
        "region box block -3 33 -3 30 -2 2 units lattice", "create_box 2 box",
        "region ice block 0 30 0 16 -0.1 0.1 units lattice", "create_atoms 1 region ice",
        "set group all diameter 2000", "set group all density 917",
        bonds ? "neighbor 500 bin" : "neighbor 1600 bin", style.c_str(), "pair_coeff * *",
        "timestep 0.1", "fix motion all floe/integrate thickness 1 fused yes", "run 0"}) {
    lmp->input->one(line);
  }
  if (bonds) {
    for (const char *line : {"floe_bonds gap 10 thickness 1", "run 0"}) lmp->input->one(line);
  }
  const Parts parts = find_parts(lmp);
  Listed pairs = read_lists(parts.pair, *parts.floe);
  // Displacements and velocities that are not uniform, so that all terms have something to do.
  LongArray<Body> &bodies = parts.fix->bodies;
  const int n = lmp->atom->nlocal;
  for (int i = 0; i < n; ++i) {
    Body &body = bodies[i];
    body.x += 1e-5 * body.y;
    body.u = 1e-6 * body.y;
    body.v = -2e-6 * body.y;
  }
  std::vector<Load> loads(n);
  const ContactTask task{parts.floe->contact,
                         nullptr,
                         lmp->update->dt,
                         true,
                         n,
                         bodies.data(),
                         loads.data(),
                         nullptr,
                         pairs.contacts.ends.data(),
                         pairs.contacts.rows.data(),
                         nullptr};
  double lost = 0.0;
  std::vector<int> odd;
  for (int k = 0; k < steps; ++k) {
    loads.assign(n, Load{});
    lmp->force->pair->compute(0, 0);
    lost += which == "push"  ? push_by_hand(task, pairs.contacts, *parts.floe)
            : which == "rub" ? rub_by_hand(task, pairs.contacts, *parts.floe)
                             : stretch_by_hand(*parts.floe, pairs.bonds, task, odd);
  }
  // The two agree in the forces of the last step.
  double apart = 0.0, largest = 0.0;
  for (int i = 0; i < n; ++i) {
    const Load &own = parts.fix->loads[i];
    apart = std::max({apart, std::fabs(own.fx - loads[i].fx), std::fabs(own.fy - loads[i].fy)});
    largest = std::max(largest, std::fabs(own.fx));
  }
  std::printf("%s: %d elements, %zu contacts, %d bonds, %.3g of %.3g N apart, %.3g lost\n",
              which.c_str(), n, pairs.contacts.ends.size(), pairs.bonds.count, apart, largest,
              lost);
  const bool same = largest > 0.0 && apart <= 1e-9 * largest && odd.empty();
  delete lmp;
  return same;
}

int main(int argc, char **argv) {
  MPI_Init(&argc, &argv);
  const int steps = argc > 1 ? std::atoi(argv[1]) : 1;
  const bool same = run("push", steps) & run("rub", steps) & run("stretch", steps);
  MPI_Finalize();
  return same ? 0 : 1;
}
