// SPDX-License-Identifier: GPL-2.0-or-later
//
// Constants of a pair that follow from its elements, and sums over the present pairs.
#include <algorithm>
#include <cmath>

#include "atom.h"
#include "fix_floe_integrate.h"
#include "history.h"
#include "neigh_list.h"
#include "pair_floe.h"
#include "pair_gran.h"

using namespace LAMMPS_NS;

namespace floe {

// An element that never moves takes part like an infinitely heavy one. In the order of the ids, so
// that both sides of a rank boundary find the same bits.
double PairFloe::reduced_mass(int i, int j) const {
  const double *mass = atom->rmass;
  if (atom->type[i] == FixFloeIntegrate::fixed_type) return mass[j];
  if (atom->type[j] == FixFloeIntegrate::fixed_type) return mass[i];
  const int lo = atom->tag[i] < atom->tag[j] ? i : j, hi = i + j - lo;
  return mass[lo] * mass[hi] / (mass[lo] + mass[hi]);
}

void PairFloe::finish_bond(double *h, int i, int j) const {
  const double strength = compressive_strength(h[slot::bond_thickness]);
  const BondConstants c = bond_constants(bond, bond_shape(h), strength, reduced_mass(i, j));
  h[slot::bond_length] = c.length;
  h[slot::bond_ratio] = c.ratio;
  h[slot::bond_damping] = c.damping;
  h[slot::bond_squeeze] = c.squeeze;
}

void PairFloe::finish_contact(double *h, int i, int j) const {
  const int lo = atom->tag[i] < atom->tag[j] ? i : j, hi = i + j - lo;
  const ContactConstants c =
      contact_constants(contact, fix_->thickness[lo], fix_->thickness[hi], reduced_mass(i, j));
  h[slot::contact_stiffness] = c.stiffness;
  h[slot::contact_damping] = c.damping;
  if (!ridging || h[slot::ridge_length] != 0.0) return;
  h[slot::ridge_thickness] = std::min(fix_->thickness[lo], fix_->thickness[hi]);
  h[slot::ridge_length] = edge_share * 2.0 * std::min(atom->radius[lo], atom->radius[hi]);
}

double PairFloe::share_of(int i, int j) const {
  if (atom->type[i] == FixFloeIntegrate::fixed_type) return 0.0;
  if (atom->type[j] == FixFloeIntegrate::fixed_type) return 1.0;
  return ridge_share(fix_->thickness[i], fix_->thickness[j]);
}

double PairFloe::take_over(int &flag, double *h, int i, int j, double overlap, double force,
                           double energy) const {
  const double length = h[slot::bond_length];
  std::fill(h, h + history_size(), 0.0);
  flag = force > 0.0 || overlap > 0.0;
  if (!flag) return 0.0;
  finish_contact(h, i, j);
  h[slot::ridge_length] = length;
  const double stiffness = h[slot::contact_stiffness];
  double push = 0.0;
  if (stiffness > 0.0) {
    push = ridge_takeover(force, energy, ridging_limit(ridge_at(h)), stiffness);
    overlap -= push / stiffness;
  }
  h[slot::rest_overlap] = overlap;
  return stiffness > 0.0 ? 0.5 * push * push / stiffness : 0.0;
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
      const double *h = past->firstdouble[i] + static_cast<std::ptrdiff_t>(size) * jj;
      const double weight = j < atom->nlocal ? 1.0 : 0.5;  // a pair across ranks is met on both
      const int lo = atom->tag[i] < atom->tag[j] ? i : j, hi = i + j - lo;
      const Vec2 d{x[hi][0] - x[lo][0], x[hi][1] - x[lo][1]};
      if (bonds && h[slot::span] != 0.0) {
        const BondPose pose{
            d, {omega[lo][0], omega[lo][1]}, {omega[hi][0], omega[hi][1]}, {0.0, 0.0}, 0.0, 0.0};
        const BondShape shape = bond_shape(h);
        out.elastic_bond +=
            weight * bond_energy(bond, bond_constants_at(h), shape, bond_line(shape, pose));
        out.bonds += weight;
        continue;
      }
      out.contacts += weight;
      const double distance = std::sqrt(d.x * d.x + d.y * d.y);
      const double overlap = atom->radius[lo] + atom->radius[hi] - distance - h[slot::rest_overlap];
      if (overlap <= 0.0) continue;
      const double k = h[slot::contact_stiffness];
      out.max_overlap = std::max(out.max_overlap, overlap);
      out.elastic_contact += weight * 0.5 * k * overlap * overlap;
      if (friction) {
        out.elastic_contact +=
            weight * 0.5 * contact.shear_ratio * k * h[slot::slip] * h[slot::slip];
      }
    }
  }
  return out;
}

}  // namespace floe
