// SPDX-License-Identifier: GPL-2.0-or-later
#include "orientation.h"

#include "turn.h"

namespace floe {

namespace {

template <typename P, int Width>
FLOE_INLINE void write_all(const double *angle, int count, double *rows) {
  int i = 0;
  for (; i + Width <= count; i += Width) {
    P c, s;
    cos_sin(load_pack<P>(angle + i), c, s);
    for (int k = 0; k < Width; ++k) {
      rows[2 * (i + k)] = c[k];
      rows[2 * (i + k) + 1] = s[k];
    }
  }
  for (; i < count; ++i) cos_sin(angle[i], rows[2 * i], rows[2 * i + 1]);
}

#if defined(__x86_64__)
[[gnu::target("avx2")]] void write_wide(const double *angle, int count, double *rows) {
  write_all<Pack4, 4>(angle, count, rows);
}
#endif

}  // namespace

void write_turns(const double *angle, int count, double *rows) {
#if defined(__x86_64__)
  if (wide_packs()) return write_wide(angle, count, rows);
#endif
  write_all<Pack2, 2>(angle, count, rows);
}

}  // namespace floe
