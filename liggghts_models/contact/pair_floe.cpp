// SPDX-License-Identifier: GPL-2.0-or-later
//
// The loop over pairs.
#include "pair_floe.h"

#include <cmath>
#include <cstddef>

#include "atom.h"
#include "contact_batch.h"
#include "fix_floe_integrate.h"
#include "history.h"
#include "losses.h"
#include "neigh_list.h"
#include "neighbor.h"
#include "pair_gran.h"
#include "update.h"

using namespace LAMMPS_NS;

namespace floe {

namespace {

// Nothing remains of a contact that opened.
template <bool Ridging>
void forget(int &flag, double *h) {
  if (!flag) return;
  flag = 0;
  constexpr int size = Ridging ? int{slot::ridge_size} : int{slot::contact_size};
  for (int k = 0; k < size; ++k) h[k] = 0.0;
}

}  // namespace

void PairFloe::gather() {
  const int all = atom->nlocal + atom->nghost;
  bodies_.resize(all);
  loads_.assign(all, Load{});
  const double *const *x = atom->x, *const *v = atom->v, *const *omega = atom->omega;
  const double *radius = atom->radius;
  for (int i = 0; i < all; ++i) {
    bodies_[i] = {x[i][0],     x[i][1],     v[i][0],     v[i][1],
                  omega[i][2], omega[i][0], omega[i][1], radius[i]};
  }
}

void PairFloe::scatter() {
  for (int i = 0; i < atom->nlocal; ++i) {
    atom->f[i][0] += loads_[i].fx;
    atom->f[i][1] += loads_[i].fy;
    atom->torque[i][2] += loads_[i].torque;
  }
}

void PairFloe::scatter_ridged() {
  for (int i = 0; i < atom->nlocal; ++i) fix_->ridged_area[i] += loads_[i].ridged;
}

template <bool Bonds, bool Friction, bool Ridging>
void PairFloe::loop(PairGran *pg) {
  const Body *bodies = bodies_.data();
  Load *loads = loads_.data();
  const int nlocal = atom->nlocal;
  const NeighList *list = pg->list, *past = pg->listgranhistory;
  const int size = pg->dnum();
  const bool advance = pg->shearupdate() != 0;
  const double step = advance ? update->dt : 0.0;
  Losses lost;

  if constexpr (Bonds) {
    if (stale_ || neighbor->ago == 0) list_bonds(pg);
    lost.bond += batch_.evaluate(bond, limit2(), advance, bodies, loads);
    for (const ListedBond &odd : batch_.odd()) bond_alone<Ridging>(odd, size, advance, lost);
    if (stale_) list_bonds(pg);  // what broke goes on as a contact, in this step
  }
  const int *rows = Bonds ? rims_.data() : list->ilist;
  const int row_count = Bonds ? static_cast<int>(rims_.size()) : list->inum;
  for (int ii = 0; ii < row_count; ++ii) {
    const int i = rows[ii];
    const Body body = bodies[i];
    const int *neighbour = list->firstneigh[i];
    int *flags = past->firstneigh[i];
    double *history = past->firstdouble[i];
    const int count = list->numneigh[i];
    Load mine{};

    for (int jj = 0; jj < count; ++jj) {
      const int j = neighbour[jj] & NEIGHMASK;
      double *h = history + static_cast<std::ptrdiff_t>(size) * jj;
      if (Bonds && is_bond(flags[jj], h)) continue;
      const Body &other = bodies[j];
      const double dx = other.x - body.x, dy = other.y - body.y, sum = body.radius + other.radius;
      const double square = dx * dx + dy * dy;
      // With ridging a contact can reach across a gap, and a ridge stays where it was built.
      if (square >= sum * sum && !(Ridging && flags[jj])) {
        forget<Ridging>(flags[jj], h);
        continue;
      }
      const double share = j < nlocal ? 1.0 : 0.5;  // a pair across ranks is met on both
      if (!flags[jj]) {
        flags[jj] = 1;
        for (int k = 0; k < size; ++k) h[k] = 0.0;
      }
      if (h[slot::contact_stiffness] == 0.0) finish_contact(h, i, j);
      const ContactPose pose{{dx, dy},
                             std::sqrt(square),
                             body.radius,
                             other.radius,
                             {other.u - body.u, other.v - body.v},
                             body.spin,
                             other.spin};
      const ContactConstants constants{h[slot::contact_stiffness], h[slot::contact_damping]};
      double rest = h[slot::rest_overlap], slip = h[slot::slip], overlap, limit = 0.0;
      if constexpr (Ridging) {
        overlap = (sum - pose.distance) - rest;
        if (overlap <= 0.0 && square >= sum * sum && h[slot::ridge_closing] == 0.0 &&
            rest >= 0.0) {  // below 0 ice reaches further than its disc
          if (advance) forget<true>(flags[jj], h);
          continue;
        }
      } else {
        overlap = effective_overlap(pose, rest);
        if (advance) h[slot::rest_overlap] = rest;
      }
      if (overlap <= 0.0) {
        if (advance) h[slot::slip] = 0.0;
        continue;
      }
      if constexpr (Ridging) {
        Ridge now = ridge_at(h);
        limit = ridging_limit(now);
        if (advance && constants.stiffness * overlap > limit) {
          const double closed = close_ridge(constants.stiffness, sum - rest, overlap, now);
          h[slot::rest_overlap] = rest + closed;
          h[slot::ridge_closing] = now.closing;
          h[slot::ridge_thickness] = now.thickness;
          overlap = (sum - pose.distance) - h[slot::rest_overlap];
          lost.ridging += share * constants.stiffness * overlap * closed;
          const double area = now.length * closed, mine_of_it = share_of(i, j);
          mine.ridged += mine_of_it * area;
          loads[j].ridged += (1.0 - mine_of_it) * area;
          limit = ridging_limit(now);
        }
      }
      ContactLoss loss;
      const ContactForce touch = contact_force<Friction, Ridging>(contact, constants, pose, overlap,
                                                                  step, slip, loss, limit);
      if (advance) h[slot::slip] = slip;
      lost.contact += share * loss.damping;
      lost.friction += share * loss.friction;
      mine.fx += touch.f.x;
      mine.fy += touch.f.y;
      loads[j].fx -= touch.f.x;
      loads[j].fy -= touch.f.y;
      if (Friction) {
        mine.torque += touch.torque_one;
        loads[j].torque += touch.torque_two;
      }
    }
    loads[i].fx += mine.fx;
    loads[i].fy += mine.fy;
    loads[i].torque += mine.torque;
    if constexpr (Ridging) loads[i].ridged += mine.ridged;
  }
  lost.add_to(fix_->ledger, step);
}

// The same where nothing is bonded and nothing ridges: contacts are gathered and evaluated several at once.
template <bool Friction>
void PairFloe::loop_contacts(PairGran *pg) {
  constexpr int room = 256;
  Touching touching[room + 3];
  int found = 0;
  const Body *bodies = bodies_.data();
  const NeighList *list = pg->list, *past = pg->listgranhistory;
  const int size = pg->dnum();
  const bool advance = pg->shearupdate() != 0;
  const double step = advance ? update->dt : 0.0;
  const ContactTask task{contact, step, advance, atom->nlocal, bodies, loads_.data()};
  ContactSums sums;
  const int *rows = list->ilist, *lengths = list->numneigh, row_count = list->inum;
  int *const *firstneigh = list->firstneigh, *const *first_flag = past->firstneigh;
  double *const *first_history = past->firstdouble;

  for (int ii = 0; ii < row_count; ++ii) {
    const int i = rows[ii], count = lengths[i];
    const double x = bodies[i].x, y = bodies[i].y, radius = bodies[i].radius;
    const int *neighbour = firstneigh[i];
    int *flags = first_flag[i];
    double *h = first_history[i];
    for (int jj = 0; jj < count; ++jj, h += size) {
      const int j = neighbour[jj] & NEIGHMASK;
      const Body &other = bodies[j];
      const double dx = other.x - x, dy = other.y - y, sum = radius + other.radius;
      if (dx * dx + dy * dy >= sum * sum) {
        forget<false>(flags[jj], h);
        continue;
      }
      flags[jj] = 1;  // what has no contact has no history
      if (h[slot::contact_stiffness] == 0.0) finish_contact(h, i, j);
      touching[found++] = {h, i, j};
      if (found < room) continue;
      evaluate_contacts<Friction>(task, touching, found, sums);
      found = 0;
    }
  }
  if (found) evaluate_contacts<Friction>(task, touching, found, sums);
  Losses lost;
  lost.contact = sums.damping.total();
  lost.friction = sums.friction.total();
  lost.add_to(fix_->ledger, step);
}

template <bool Friction>
void PairFloe::choose_loop(PairGran *pg) {
  if (bonds)
    ridging ? loop<true, Friction, true>(pg) : loop<true, Friction, false>(pg);
  else
    ridging ? loop<false, Friction, true>(pg) : loop_contacts<Friction>(pg);
}

void PairFloe::compute_force(PairGran *pg, int, int, int) {
  pg->evflag = pg->vflag_fdotr = 0;  // energies and stresses are reported by sums() and the ledger
  gather();
  friction ? choose_loop<true>(pg) : choose_loop<false>(pg);
  if (pg->computeflag()) scatter();
  if (ridging) scatter_ridged();
}

}  // namespace floe
