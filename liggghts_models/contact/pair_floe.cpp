// SPDX-License-Identifier: GPL-2.0-or-later
#include "pair_floe.h"

#include <cmath>

#include "atom.h"
#include "fix_floe_integrate.h"
#include "history.h"
#include "neigh_list.h"
#include "pair_gran.h"
#include "update.h"

using namespace LAMMPS_NS;

namespace floe {

namespace {

// An element that never moves takes part like an infinitely heavy one.
double reduced_mass(double m_lo, double m_hi, bool fixed_lo, bool fixed_hi) {
  if (fixed_lo) return m_hi;
  if (fixed_hi) return m_lo;
  return m_lo * m_hi / (m_lo + m_hi);
}

// The pair in touch leaves its history behind: nothing remains of a contact that opened.
void forget(int &flag, double *h) {
  if (!flag) return;
  flag = 0;
  for (int k = 0; k < slot::contact_size; ++k) h[k] = 0.0;
}

}  // namespace

template <bool Bonds, bool Friction>
void PairFloe::loop(PairGran *pg) {
  double **x = atom->x, **v = atom->v, **f = atom->f, **omega = atom->omega;
  double **torque = atom->torque;
  const double *radius = atom->radius, *mass = atom->rmass, *thickness = fix_->thickness;
  const int *type = atom->type, *tag = atom->tag;
  const int nlocal = atom->nlocal;
  const NeighList *list = pg->list, *past = pg->listgranhistory;
  const int size = pg->dnum();
  const bool apply = pg->computeflag() != 0, advance = pg->shearupdate() != 0;
  const double dt = update->dt, step = advance ? dt : 0.0;
  const double limit2 = 0.998 * reach * reach;
  Ledger &total = fix_->ledger;
  double lost_bond = 0.0, lost_contact = 0.0, lost_friction = 0.0;

  for (int ii = 0; ii < list->inum; ++ii) {
    const int i = list->ilist[ii];
    const double xi = x[i][0], yi = x[i][1], ri = radius[i];
    const int *neighbour = list->firstneigh[i];
    int *flags = past->firstneigh[i];
    double *history = past->firstdouble[i];
    const int count = list->numneigh[i];
    double fx = 0.0, fy = 0.0, tz = 0.0;

    for (int jj = 0; jj < count; ++jj) {
      const int j = neighbour[jj] & NEIGHMASK;
      const double dx = x[j][0] - xi, dy = x[j][1] - yi, sum = ri + radius[j];
      const double square = dx * dx + dy * dy;
      double *h = history + size * jj;
      const bool bonded = Bonds && flags[jj] && h[slot::kind] != 0.0;
      if (!bonded && square >= sum * sum) {
        forget(flags[jj], h);
        continue;
      }
      const bool i_low = tag[i] < tag[j];
      const int lo = i_low ? i : j, hi = i_low ? j : i;
      const double sign = i_low ? 1.0 : -1.0;
      const Vec2 d{sign * dx, sign * dy};
      const Vec2 dv{v[hi][0] - v[lo][0], v[hi][1] - v[lo][1]};
      const double reduced =
          reduced_mass(mass[lo], mass[hi], type[lo] == FixFloeIntegrate::fixed_type,
                       type[hi] == FixFloeIntegrate::fixed_type);
      const double share = j < nlocal ? dt : 0.5 * dt;  // a pair across ranks is met on both
      PairForce force;

      if (bonded) {
        BondShape shape = bond_shape(h);
        const BondPose pose{d,  omega[lo][0], omega[lo][1], omega[hi][0], omega[hi][1],
                            dv, omega[lo][2], omega[hi][2]};
        const BondLine line = bond_line(shape, pose);
        if (advance) {
          if (square > limit2 * sum * sum) fix_->fault_at(i, j);
          const BondShape before = shape;
          if (bond_fracture(bond, h[slot::compressive], line, shape)) {
            const bool counted = j < nlocal || i_low, broken = shape.broken();
            total.dissipation_fracture +=
                (j < nlocal ? 1.0 : 0.5) *
                (bond_energy(bond, before, line) - bond_energy(bond, shape, line));
            if (counted && before.crack_a == 0.0 && before.crack_b == 0.0)
              total.bonds_cracked += 1.0;
            if (counted && broken) total.bonds_broken += 1.0;
            h[slot::crack_a] = shape.crack_a;
            h[slot::crack_b] = shape.crack_b;
            if (broken) {
              // Overlap present at the break makes no force from now on.
              for (int k = 0; k < size; ++k) h[k] = 0.0;
              const double overlap = sum - std::sqrt(square);
              flags[jj] = overlap > 0.0;
              if (overlap > 0.0) h[slot::rest_overlap] = overlap;
              continue;
            }
          }
        }
        double watt;
        force = bond_force(bond, shape, line, pose, reduced, watt);
        if (advance) lost_bond += share * watt;
      } else {
        if (!flags[jj]) {
          flags[jj] = 1;
          for (int k = 0; k < size; ++k) h[k] = 0.0;
        }
        const ContactPose pose{d,  std::sqrt(square), radius[lo],  radius[hi],
                               dv, omega[lo][2],      omega[hi][2]};
        double rest = h[slot::rest_overlap];
        const double overlap = effective_overlap(pose, rest);
        if (advance) h[slot::rest_overlap] = rest;
        if (overlap <= 0.0) {
          if (advance) h[slot::slip] = 0.0;
          continue;
        }
        const double stiffness = contact_stiffness(contact.young, thickness[lo], thickness[hi]);
        ContactHistory past_slip{h[slot::slip], rest};
        ContactLoss loss;
        force = contact_force<Friction>(contact, pose, stiffness, reduced, overlap, step, past_slip,
                                        loss);
        if (advance) {
          h[slot::slip] = past_slip.slip;
          lost_contact += share * loss.damping;
          lost_friction += (j < nlocal ? 1.0 : 0.5) * loss.friction;
        }
      }
      if (!apply) continue;
      fx += sign * force.f.x;
      fy += sign * force.f.y;
      tz += i_low ? force.torque_lo : force.torque_hi;
      if (j < nlocal) {
        f[j][0] -= sign * force.f.x;
        f[j][1] -= sign * force.f.y;
        torque[j][2] += i_low ? force.torque_hi : force.torque_lo;
      }
    }
    f[i][0] += fx;
    f[i][1] += fy;
    torque[i][2] += tz;
  }
  total.dissipation_bond += lost_bond;
  total.dissipation_contact += lost_contact;
  total.dissipation_friction += lost_friction;
}

void PairFloe::compute_force(PairGran *pg, int, int, int) {
  pg->evflag = pg->vflag_fdotr = 0;  // energies and stresses are reported by sums() and the ledger
  if (bonds) {
    if (friction)
      loop<true, true>(pg);
    else
      loop<true, false>(pg);
  } else {
    if (friction)
      loop<false, true>(pg);
    else
      loop<false, false>(pg);
  }
}

PairSums PairFloe::sums(PairGran *pg) const {
  PairSums out;
  double **x = atom->x, **omega = atom->omega;
  const NeighList *list = pg->list, *past = pg->listgranhistory;
  const int size = pg->dnum();
  for (int ii = 0; ii < list->inum; ++ii) {
    const int i = list->ilist[ii];
    for (int jj = 0; jj < list->numneigh[i]; ++jj) {
      if (!past->firstneigh[i][jj]) continue;
      const int j = list->firstneigh[i][jj] & NEIGHMASK;
      const double *h = past->firstdouble[i] + size * jj;
      const double weight = j < atom->nlocal ? 1.0 : 0.5;
      const bool i_low = atom->tag[i] < atom->tag[j];
      const int lo = i_low ? i : j, hi = i_low ? j : i;
      const Vec2 d{x[hi][0] - x[lo][0], x[hi][1] - x[lo][1]};
      const double distance = std::sqrt(d.x * d.x + d.y * d.y);
      if (bonds && h[slot::kind] != 0.0) {
        const BondShape shape = bond_shape(h);
        const BondPose pose{d,          omega[lo][0], omega[lo][1], omega[hi][0], omega[hi][1],
                            {0.0, 0.0}, 0.0,          0.0};
        out.elastic_bond += weight * bond_energy(bond, shape, bond_line(shape, pose));
        out.bonds += weight;
        continue;
      }
      const double overlap = atom->radius[lo] + atom->radius[hi] - distance - h[slot::rest_overlap];
      out.contacts += weight;
      if (overlap <= 0.0) continue;
      const double k = contact_stiffness(contact.young, fix_->thickness[lo], fix_->thickness[hi]);
      out.max_overlap = std::max(out.max_overlap, overlap);
      out.elastic_contact += weight * 0.5 * k * overlap * overlap;
      const double kt = contact.shear_ratio * k;
      if (friction) {
        out.elastic_contact += weight * 0.5 * kt * h[slot::slip] * h[slot::slip];
      }
    }
  }
  return out;
}

}  // namespace floe
