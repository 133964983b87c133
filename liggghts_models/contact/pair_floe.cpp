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
#include "neigh_list.h"
#include "neighbor.h"
#include "pair_gran.h"
#include "update.h"

using namespace LAMMPS_NS;

namespace floe {

namespace {

// Nothing remains of a contact that opened.
void forget(int &flag, double *h) {
  if (!flag) return;
  flag = 0;
  for (int k = 0; k < slot::contact_size; ++k) h[k] = 0.0;
}

// The bond gives way: overlap present at that moment makes no force from now on.
void break_bond(int &flag, double *h, int size, double overlap) {
  for (int k = 0; k < size; ++k) h[k] = 0.0;
  flag = overlap > 0.0;
  if (overlap > 0.0) h[slot::rest_overlap] = overlap;
}

}  // namespace

bool is_bond(int flag, const double *h) { return flag && h[slot::span] != 0.0; }

// Sums over the pairs of one rank in one step.
struct Losses {
  double bond = 0.0, contact = 0.0;       // W
  double friction = 0.0, fracture = 0.0;  // J
  double cracked = 0.0, broken = 0.0;

  void add_to(Ledger &total, double step) const {
    total.dissipation_bond += bond * step;
    total.dissipation_contact += contact * step;
    total.dissipation_friction += friction;
    total.dissipation_fracture += fracture;
    total.bonds_cracked += cracked;
    total.bonds_broken += broken;
  }
};

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

void PairFloe::list_bonds(PairGran *pg) {
  const NeighList *list = pg->list, *past = pg->listgranhistory;
  const int *tag = atom->tag;
  const int size = pg->dnum();
  batch_.clear();
  rims_.clear();
  for (int ii = 0; ii < list->inum; ++ii) {
    const int i = list->ilist[ii], count = list->numneigh[i];
    bool rim = false;
    for (int jj = 0; jj < count; ++jj) {
      const int j = list->firstneigh[i][jj] & NEIGHMASK;
      double *h = past->firstdouble[i] + static_cast<std::ptrdiff_t>(size) * jj;
      int *flag = past->firstneigh[i] + jj;
      if (is_bond(*flag, h)) {
        const bool i_low = tag[i] < tag[j];
        batch_.add({h, flag, i_low ? i : j, i_low ? j : i, j < atom->nlocal ? 1.0 : 0.5});
      } else {
        rim = true;
      }
    }
    if (rim) rims_.push_back(i);
  }
  stale_ = false;
}

// A bond that cracks or comes to the end of the neighbours' reach.
void PairFloe::bond_alone(const ListedBond &b, int size, bool advance, Losses &lost) {
  double *h = b.history;
  const Body &lo = bodies_[b.lo], &hi = bodies_[b.hi];
  BondShape shape = bond_shape(h);
  const BondConstants constants = bond_constants_at(h);
  const BondPose pose{{hi.x - lo.x, hi.y - lo.y}, {lo.cos, lo.sin}, {hi.cos, hi.sin},
                      {hi.u - lo.u, hi.v - lo.v}, lo.spin,          hi.spin};
  const BondLine line = bond_line(shape, pose);
  if (advance) {
    const double sum = lo.radius + hi.radius, square = pose.d.x * pose.d.x + pose.d.y * pose.d.y;
    if (square > limit2() * sum * sum) fix_->fault_at(b.lo, b.hi);
    const BondShape before = shape;
    if (bond_fracture(bond, constants, line, shape)) {
      const bool counted = b.share == 1.0 || b.lo < atom->nlocal;
      lost.fracture += b.share * (bond_energy(bond, constants, before, line) -
                                  bond_energy(bond, constants, shape, line));
      if (counted && before.crack_a == 0.0 && before.crack_b == 0.0) lost.cracked += 1.0;
      if (counted && shape.broken()) lost.broken += 1.0;
      h[slot::crack_a] = shape.crack_a;
      h[slot::crack_b] = shape.crack_b;
      if (shape.broken()) {
        stale_ = true;
        break_bond(*b.flag, h, size, sum - std::sqrt(square));
        return;
      }
    }
  }
  double watt;
  const PairForce force = bond_force(bond, constants, shape, line, pose, watt);
  lost.bond += b.share * watt;
  loads_[b.lo].fx += force.f.x;
  loads_[b.lo].fy += force.f.y;
  loads_[b.lo].torque += force.torque_lo;
  loads_[b.hi].fx -= force.f.x;
  loads_[b.hi].fy -= force.f.y;
  loads_[b.hi].torque += force.torque_hi;
}

template <bool Bonds, bool Friction>
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
    for (const ListedBond &odd : batch_.odd()) bond_alone(odd, size, advance, lost);
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
      if (square >= sum * sum) {
        forget(flags[jj], h);
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
      double rest = h[slot::rest_overlap], slip = h[slot::slip];
      const double overlap = effective_overlap(pose, rest);
      if (advance) h[slot::rest_overlap] = rest;
      if (overlap <= 0.0) {
        if (advance) h[slot::slip] = 0.0;
        continue;
      }
      ContactLoss loss;
      const ContactForce touch =
          contact_force<Friction>(contact, {h[slot::contact_stiffness], h[slot::contact_damping]},
                                  pose, overlap, step, slip, loss);
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
  }
  lost.add_to(fix_->ledger, step);
}

// The same where nothing is bonded: contacts are gathered and evaluated several at once.
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
        forget(flags[jj], h);
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

void PairFloe::compute_force(PairGran *pg, int, int, int) {
  pg->evflag = pg->vflag_fdotr = 0;  // energies and stresses are reported by sums() and the ledger
  gather();
  if (bonds) {
    friction ? loop<true, true>(pg) : loop<true, false>(pg);
  } else {
    friction ? loop_contacts<true>(pg) : loop_contacts<false>(pg);
  }
  if (pg->computeflag()) scatter();
}

}  // namespace floe
