// SPDX-License-Identifier: GPL-2.0-or-later
//
// The loop over pairs.
#include "pair_floe.h"

#include <cmath>
#include <cstddef>

#include "atom.h"
#include "fix_floe_integrate.h"
#include "history.h"
#include "neigh_list.h"
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

// The bond gives way: overlap present at that moment makes no force from now on.
void break_bond(int &flag, double *h, int size, double overlap) {
  for (int k = 0; k < size; ++k) h[k] = 0.0;
  flag = overlap > 0.0;
  if (overlap > 0.0) h[slot::rest_overlap] = overlap;
}

// Sums over the pairs of one rank in one step.
struct Losses {
  double bond = 0.0, contact = 0.0;                      // W
  double friction = 0.0, fracture = 0.0, ridging = 0.0;  // J
  double cracked = 0.0, broken = 0.0;

  void add_to(Ledger &total, double step) const {
    total.dissipation_bond += bond * step;
    total.dissipation_contact += contact * step;
    total.dissipation_friction += friction;
    total.dissipation_fracture += fracture;
    total.dissipation_ridging += ridging;
    total.bonds_cracked += cracked;
    total.bonds_broken += broken;
  }
};

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
  const int *tag = atom->tag;
  const int nlocal = atom->nlocal;
  const NeighList *list = pg->list, *past = pg->listgranhistory;
  const int size = pg->dnum();
  const bool advance = pg->shearupdate() != 0;
  const double step = advance ? update->dt : 0.0;
  const double limit2 = 0.998 * reach * reach;
  Losses lost;

  for (int ii = 0; ii < list->inum; ++ii) {
    const int i = list->ilist[ii], tag_i = tag[i];
    const Body body = bodies[i];
    const int *neighbour = list->firstneigh[i];
    int *flags = past->firstneigh[i];
    double *history = past->firstdouble[i];
    const int count = list->numneigh[i];
    Load mine{};

    for (int jj = 0; jj < count; ++jj) {
      const int j = neighbour[jj] & NEIGHMASK;
      const Body &other = bodies[j];
      const double dx = other.x - body.x, dy = other.y - body.y, sum = body.radius + other.radius;
      const double square = dx * dx + dy * dy;
      double *h = history + static_cast<std::ptrdiff_t>(size) * jj;
      const bool bonded = Bonds && flags[jj] && h[slot::span] != 0.0;
      // With ridging a contact can reach across a gap, and a ridge stays where it was built.
      if (!bonded && square >= sum * sum && !(Ridging && flags[jj])) {
        forget<Ridging>(flags[jj], h);
        continue;
      }
      const double share = j < nlocal ? 1.0 : 0.5;  // a pair across ranks is met on both
      Vec2 force;                                   // on i
      double torque_i, torque_j;

      if (bonded) {
        const bool i_low = tag_i < tag[j];
        const Body &lo = i_low ? body : other, &hi = i_low ? other : body;
        const double sign = i_low ? 1.0 : -1.0;
        BondShape shape = bond_shape(h);
        const BondConstants constants = bond_constants_at(h);
        const BondPose pose{{sign * dx, sign * dy},     {lo.cos, lo.sin}, {hi.cos, hi.sin},
                            {hi.u - lo.u, hi.v - lo.v}, lo.spin,          hi.spin};
        const BondLine line = bond_line(shape, pose);
        if (advance) {
          if (square > limit2 * sum * sum) fix_->fault_at(i, j);
          const BondShape before = shape;
          if (bond_fracture(bond, constants, line, shape)) {
            const bool counted = j < nlocal || i_low;
            const double energy = bond_energy(bond, constants, before, line);
            lost.fracture += share * (energy - bond_energy(bond, constants, shape, line));
            if (counted && before.crack_a == 0.0 && before.crack_b == 0.0) lost.cracked += 1.0;
            if (counted && shape.broken()) lost.broken += 1.0;
            h[slot::crack_a] = shape.crack_a;
            h[slot::crack_b] = shape.crack_b;
            if (shape.broken()) {
              const double overlap = sum - std::sqrt(square);
              if constexpr (Ridging) {
                const double push = -bond_normal_force(bond, constants, before, line);
                lost.fracture -= share * take_over(flags[jj], h, i, j, overlap, push, energy);
                if (flags[jj]) --jj;  // again, now as a contact
              } else {
                break_bond(flags[jj], h, size, overlap);
              }
              continue;
            }
          }
        }
        double watt;
        const PairForce on_lo = bond_force(bond, constants, shape, line, pose, watt);
        lost.bond += share * watt;
        force = {sign * on_lo.f.x, sign * on_lo.f.y};
        torque_i = i_low ? on_lo.torque_lo : on_lo.torque_hi;
        torque_j = i_low ? on_lo.torque_hi : on_lo.torque_lo;
      } else {
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
          if (overlap <= 0.0 && square >= sum * sum && h[slot::ridge_closing] == 0.0) {
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
        const ContactForce touch = contact_force<Friction, Ridging>(
            contact, constants, pose, overlap, step, slip, loss, limit);
        if (advance) h[slot::slip] = slip;
        lost.contact += share * loss.damping;
        lost.friction += share * loss.friction;
        force = touch.f;
        torque_i = touch.torque_one;
        torque_j = touch.torque_two;
      }
      mine.fx += force.x;
      mine.fy += force.y;
      loads[j].fx -= force.x;
      loads[j].fy -= force.y;
      if (Bonds || Friction) {
        mine.torque += torque_i;
        loads[j].torque += torque_j;
      }
    }
    loads[i].fx += mine.fx;
    loads[i].fy += mine.fy;
    loads[i].torque += mine.torque;
    if constexpr (Ridging) loads[i].ridged += mine.ridged;
  }
  lost.add_to(fix_->ledger, step);
}

template <bool Bonds, bool Friction>
void PairFloe::choose_loop(PairGran *pg) {
  ridging ? loop<Bonds, Friction, true>(pg) : loop<Bonds, Friction, false>(pg);
}

void PairFloe::compute_force(PairGran *pg, int, int, int) {
  pg->evflag = pg->vflag_fdotr = 0;  // energies and stresses are reported by sums() and the ledger
  gather();
  if (bonds) {
    friction ? choose_loop<true, true>(pg) : choose_loop<true, false>(pg);
  } else {
    friction ? choose_loop<false, true>(pg) : choose_loop<false, false>(pg);
  }
  if (pg->computeflag()) scatter();
  if (ridging) scatter_ridged();
}

}  // namespace floe
