// SPDX-License-Identifier: GPL-2.0-or-later
//
// Shares of a pair's elements, and sums over the present pairs.
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

double PairFloe::share_of(int i, int j) const {
  if (atom->type[i] == FixFloeIntegrate::fixed_type) return 0.0;
  if (atom->type[j] == FixFloeIntegrate::fixed_type) return 1.0;
  return ridge_share(fix_->thickness[i] * lead_share(ridge, fix_->cover[i]),
                     fix_->thickness[j] * lead_share(ridge, fix_->cover[j]));
}

PairSums PairFloe::sums(PairGran *pg) {
  PairSums out;
  if (!lists_hold()) return out;
  write_history();
  double **x = atom->x, **turn = fix_->turn;
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
            d, {turn[lo][0], turn[lo][1]}, {turn[hi][0], turn[hi][1]}, {0.0, 0.0}, 0.0, 0.0};
        const BondShape shape = bond_shape(h);
        const BondConstants constants = constants_of(shape, lo, hi);
        out.elastic_bond += weight * BondLaws::with(bond.law, [&](auto law) {
                              return law.energy(bond, constants, shape, bond_line(shape, pose));
                            });
        out.bonds += weight;
        continue;
      }
      out.contacts += weight;
      const double distance = std::sqrt(d.x * d.x + d.y * d.y);
      const double overlap = atom->radius[lo] + atom->radius[hi] - distance - h[slot::rest_overlap];
      if (overlap <= 0.0) continue;
      out.max_overlap = std::max(out.max_overlap, overlap);
      out.elastic_contact += weight * contact_energy(contact, contact_of(lo, hi).stiffness, overlap,
                                                     friction ? h[slot::slip] : 0.0);
    }
  }
  return out;
}

}  // namespace floe
