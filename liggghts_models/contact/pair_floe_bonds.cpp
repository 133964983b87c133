// SPDX-License-Identifier: GPL-2.0-or-later
//
// The list of bonds, and the bonds that are looked at one by one.
#include <cmath>
#include <cstddef>

#include "atom.h"
#include "fix_floe_integrate.h"
#include "history.h"
#include "losses.h"
#include "neigh_list.h"
#include "pair_floe.h"
#include "pair_gran.h"

using namespace LAMMPS_NS;

namespace floe {

namespace {

// The bond gives way: overlap present at that moment makes no force from now on.
void break_bond(int &flag, double *h, int size, double overlap) {
  for (int k = 0; k < size; ++k) h[k] = 0.0;
  flag = overlap > 0.0;
  if (overlap > 0.0) h[slot::rest_overlap] = overlap;
}

}  // namespace

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
template <bool Ridging>
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
      const double energy = bond_energy(bond, constants, before, line);
      lost.fracture += b.share * (energy - bond_energy(bond, constants, shape, line));
      if (counted && before.crack_a == 0.0 && before.crack_b == 0.0) lost.cracked += 1.0;
      if (counted && shape.broken()) lost.broken += 1.0;
      h[slot::crack_a] = shape.crack_a;
      h[slot::crack_b] = shape.crack_b;
      if (shape.broken()) {
        stale_ = true;
        const double overlap = sum - std::sqrt(square);
        if constexpr (Ridging) {
          const double push = -bond_normal_force(bond, constants, before, line);
          lost.fracture -= b.share * take_over(*b.flag, h, b.lo, b.hi, overlap, push, energy);
        } else {
          break_bond(*b.flag, h, size, overlap);
        }
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

template void PairFloe::bond_alone<true>(const ListedBond &, int, bool, Losses &);
template void PairFloe::bond_alone<false>(const ListedBond &, int, bool, Losses &);

}  // namespace floe
