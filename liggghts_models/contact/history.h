// SPDX-License-Identifier: GPL-2.0-or-later
//
// Layout of the numbers that LIGGGHTS carries for each pair of elements, in the order of the ids
// (lower id first), so that both sides of a rank boundary hold and compute the same bits.
// A pair is either in (unbonded) contact or bonded; both uses share the slots.
#ifndef FLOE_CONTACT_HISTORY_H
#define FLOE_CONTACT_HISTORY_H

#include "bond.h"
#include "ridge.h"

namespace floe {
namespace slot {

// A contact has span 0. Constants that follow from these and the elements are in records.h.
enum Common { span = 0 };
enum Contact { slip = 1, rest_overlap, contact_size };
// With ridging a contact carries these too.
enum Ridge { ridge_closing = contact_size, ridge_thickness, ridge_length, ridge_cover, ridge_size };
enum Bond {
  crack_a = 1,
  crack_b,
  lo_ax,
  lo_ay,
  lo_bx,
  lo_by,
  hi_ax,
  hi_ay,
  hi_bx,
  hi_by,
  bond_thickness,
  bond_size
};

}  // namespace slot

inline BondShape bond_shape(const double *h) {
  return {{h[slot::lo_ax], h[slot::lo_ay]},
          {h[slot::lo_bx], h[slot::lo_by]},
          {h[slot::hi_ax], h[slot::hi_ay]},
          {h[slot::hi_bx], h[slot::hi_by]},
          h[slot::span],
          h[slot::bond_thickness],
          h[slot::crack_a],
          h[slot::crack_b]};
}

inline Ridge ridge_at(const double *h) {
  return {h[slot::ridge_closing], h[slot::ridge_thickness], h[slot::ridge_length],
          h[slot::ridge_cover]};
}

inline void put_ridge(const Ridge &r, double *h) {
  h[slot::ridge_closing] = r.closing;
  h[slot::ridge_thickness] = r.thickness;
  h[slot::ridge_length] = r.length;
  h[slot::ridge_cover] = r.cover;
}

inline bool is_bond(int flag, const double *h) { return flag && h[slot::span] != 0.0; }

}  // namespace floe

#endif
