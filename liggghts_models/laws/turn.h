// SPDX-License-Identifier: GPL-2.0-or-later
//
// Cosine and sine of an angle, for one element or several at once with the same bits. The angle is
// brought into -pi/4 to pi/4 by a multiple of pi/2 in three parts, of which the first two multiply
// without error up to some 10^5 turns; there the Taylor series end below half a unit in the last place.
#ifndef FLOE_LAWS_TURN_H
#define FLOE_LAWS_TURN_H

#include "pack.h"

namespace floe {

template <typename T>
FLOE_INLINE void cos_sin(T angle, T &cosine, T &sine) {
  constexpr double shift = 6755399441055744.0;  // 1.5 x 2^52: adding it rounds to a whole number
  constexpr double half_pi[3] = {0x1.921fb54400000p+0, 0x1.0b4611a600000p-34,
                                 0x1.3198a2e037073p-69};
  const T shifted = angle * (2.0 / 3.14159265358979323846) + shift;
  const T quarters = shifted - shift;
  const T r = ((angle - quarters * half_pi[0]) - quarters * half_pi[1]) - quarters * half_pi[2];
  const T s = r * r;
  const T c_even =
      (1.0 / 24) +
      s * (-(1.0 / 720) +
           s * ((1.0 / 40320) + s * (-(1.0 / 3628800) + s * ((1.0 / 479001600) +
                                                             s * (-(1.0 / 87178291200.0) +
                                                                  s * (1.0 / 20922789888000.0))))));
  const T s_odd =
      -(1.0 / 6) +
      s * ((1.0 / 120) +
           s * (-(1.0 / 5040) + s * ((1.0 / 362880) + s * (-(1.0 / 39916800) +
                                                           s * ((1.0 / 6227020800.0) +
                                                                s * -(1.0 / 1307674368000.0))))));
  const T c = 1.0 + (s * -0.5 + s * s * c_even), z = r + r * (s * s_odd);
  // Which quarter: 0, 1, 2 or 3, without whole numbers, which packs of doubles lack.
  const T floor4 = (quarters * 0.25 - 0.375 + shift) - shift;
  const T quarter = quarters - 4.0 * floor4;
  const auto odd = (quarter == 1.0) | (quarter == 3.0);
  cosine = odd ? z : c;
  sine = odd ? c : z;
  cosine = ((quarter == 1.0) | (quarter == 2.0)) ? -cosine : cosine;
  sine = quarter >= 2.0 ? -sine : sine;
}

}  // namespace floe

#endif
