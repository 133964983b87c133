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

// A bond that breaks goes on as a contact, with a ridge, in the same slots.
static_assert(static_cast<int>(bond_size) >= static_cast<int>(ridge_size) &&
                  static_cast<int>(bond_size) >= static_cast<int>(contact_size),
              "the history of a bond must have room for the contact that it becomes");
// Ends of a line are written as pairs of numbers (fixes/bond_command.cpp).
static_assert(lo_ay == lo_ax + 1 && lo_by == lo_bx + 1 && hi_ay == hi_ax + 1 && hi_by == hi_bx + 1);

}  // namespace slot

// Columns of a pair in the tables that come in and go out, in their order, and where the history has
// them. This is the one place that says so: the C interface copies by these lists (capi/pairs.cpp),
// and Python compares their names with its own when it loads the plugin (floe_layout).
struct PairColumn {
  const char *name;
  int slot;
};
constexpr PairColumn bond_columns[] = {
    {"span", slot::span},       {"thickness", slot::bond_thickness},
    {"crack_a", slot::crack_a}, {"crack_b", slot::crack_b},
    {"lo_ax", slot::lo_ax},     {"lo_ay", slot::lo_ay},
    {"lo_bx", slot::lo_bx},     {"lo_by", slot::lo_by},
    {"hi_ax", slot::hi_ax},     {"hi_ay", slot::hi_ay},
    {"hi_bx", slot::hi_bx},     {"hi_by", slot::hi_by},
};
static_assert(sizeof bond_columns / sizeof *bond_columns == slot::bond_size);
constexpr PairColumn contact_columns[] = {
    {"slip", slot::slip},
    {"rest_overlap", slot::rest_overlap},
    {"ridge_closing", slot::ridge_closing},
    {"ridge_thickness", slot::ridge_thickness},
    {"ridge_length", slot::ridge_length},
};

template <int Count>
void take_columns(const PairColumn (&columns)[Count], const double *row, double *h) {
  for (int k = 0; k < Count; ++k) h[columns[k].slot] = row[k];
}

template <int Count>
void give_columns(const PairColumn (&columns)[Count], const double *h, double *row) {
  for (int k = 0; k < Count; ++k) row[k] = h[columns[k].slot];
}

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
