// SPDX-License-Identifier: GPL-2.0-or-later
//
// Columns of elements and of the faces of walls in the arrays of the C interface, each named once: the
// order of the names is that of the arrays, and Python compares it (floe_layout). Those of pairs are in
// contact/history.h.
#ifndef FLOE_CAPI_COLUMNS_H
#define FLOE_CAPI_COLUMNS_H

// clang-format off
#define FLOE_ELEMENT_COLUMNS(COLUMN)                                                           \
  COLUMN(x) COLUMN(y) COLUMN(theta) COLUMN(u) COLUMN(v) COLUMN(omega)                          \
  COLUMN(radius) COLUMN(mass) COLUMN(thickness) COLUMN(ice_area) COLUMN(cover)                 \
  COLUMN(ridged_area)                                                                          \
  COLUMN(wind_impulse_x) COLUMN(wind_impulse_y) COLUMN(ocean_impulse_x) COLUMN(ocean_impulse_y)
// clang-format on
#define FLOE_INTERNAL_COLUMNS(COLUMN) \
  COLUMN(force_x) COLUMN(force_y) COLUMN(moment_xx) COLUMN(moment_yy) COLUMN(moment_xy)
#define FLOE_FACE_NUMBERS(COLUMN) COLUMN(wall) COLUMN(plane) COLUMN(before) COLUMN(after)
#define FLOE_FACE_COLUMNS(COLUMN) COLUMN(ax) COLUMN(ay) COLUMN(bx) COLUMN(by) COLUMN(u) COLUMN(v)

#define FLOE_COLUMN(name) name,
#define FLOE_COLUMN_NAME(name) #name " "

#endif
