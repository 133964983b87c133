// SPDX-License-Identifier: GPL-2.0-or-later
//
// Adding forces to elements. Exactly, an element's sum is kept in two rows of fixed-point numbers, a
// coarse and a fine one: what is added is cut into a multiple of the coarse grid, a multiple of the
// fine grid and a rest below half of that, which is dropped. Sums of multiples have no round-off, so
// they do not depend on the order in which pairs are met, nor on the ranks that meet them.
#ifndef FLOE_CONTACT_LOAD_ROWS_H
#define FLOE_CONTACT_LOAD_ROWS_H

#include "body.h"
#include "pack.h"

namespace floe {

// Adding 1.5 x 2^52 grids to a number and taking it off again rounds it to the grid. Forces (N) and
// areas (m2) up to 2^43 (9e12) are kept to 2^-55 (3e-17), torques (N m) to 65,536 times that: what a
// force has on an arm of 65 km.
constexpr double coarse_grid = 0x1.8p44, fine_grid = 0x1.8p-3, torque_grid = 0x1p16;
constexpr double largest_force = 0x1p43;

template <typename P>
FLOE_INLINE void add_exactly(double *row, P value, P scale) {
  const P big = coarse_grid * scale, small = fine_grid * scale;
  const P coarse = (value + big) - big, fine = ((value - coarse) + small) - small;
  add_pack(row, coarse);
  add_pack(row + 4, fine);
}

// Columns fx, fy, torque and ridged of one pair per lane, to the rows of its element.
template <bool Exact>
FLOE_INLINE void add_loads(double *const (&row)[4], const Pack4 (&in)[4]) {
  if constexpr (!Exact) return add_rows(row, in);
  Pack4 m[4] = {in[0], in[1], in[2], in[3]};
  transpose(m);
  for (int k = 0; k < 4; ++k) add_exactly(row[k], m[k], Pack4{1.0, 1.0, torque_grid, 1.0});
}
template <bool Exact>
FLOE_INLINE void add_loads(double *const (&row)[2], const Pack2 (&in)[4]) {
  if constexpr (!Exact) return add_rows(row, in);
  const Pack2 force{1.0, 1.0}, rest{torque_grid, 1.0};
  add_exactly(row[0], __builtin_shuffle(in[0], in[1], Mask2{0, 2}), force);
  add_exactly(row[1], __builtin_shuffle(in[0], in[1], Mask2{1, 3}), force);
  add_exactly(row[0] + 2, __builtin_shuffle(in[2], in[3], Mask2{0, 2}), rest);
  add_exactly(row[1] + 2, __builtin_shuffle(in[2], in[3], Mask2{1, 3}), rest);
}

// Loads of elements in the order of their places. Exact ones take two rows each.
template <bool Exact>
FLOE_INLINE double *load_row(Load *loads, int i) {
  return &loads[Exact ? 2 * i : i].fx;
}

template <bool Exact>
inline void add_load(Load *loads, int i, const Load &add) {
  double *row = load_row<Exact>(loads, i);
  const double value[4] = {add.fx, add.fy, add.torque, add.ridged};
  for (int k = 0; k < 4; k += 2) {
    const Pack2 two = load_pack<Pack2>(value + k);
    if constexpr (Exact) {
      add_exactly(row + k, two, k ? Pack2{torque_grid, 1.0} : Pack2{1.0, 1.0});
    } else {
      add_pack(row + k, two);
    }
  }
}

}  // namespace floe

#endif
