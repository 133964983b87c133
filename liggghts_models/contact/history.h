// SPDX-License-Identifier: GPL-2.0-or-later
//
// Layout of the numbers that LIGGGHTS carries for each pair of elements, in the order of the ids
// (lower id first), so that both sides of a rank boundary hold and compute the same bits.
// A pair is either in (unbonded) contact or bonded; both uses share the slots after the first.
#ifndef FLOE_CONTACT_HISTORY_H
#define FLOE_CONTACT_HISTORY_H

#include "bond.h"

namespace floe {
namespace slot {

enum Common { kind = 0 };  // 0 contact, 1 bond
enum Contact { slip = 1, rest_overlap = 2, contact_size = 3 };
enum Bond {
  crack_a = 1,
  crack_b,
  span,
  bond_thickness,
  lo_ax,
  lo_ay,
  lo_bx,
  lo_by,
  hi_ax,
  hi_ay,
  hi_bx,
  hi_by,
  compressive,  // compressive strength, Pa: follows from the thickness, kept to save its root
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

}  // namespace floe

#endif
