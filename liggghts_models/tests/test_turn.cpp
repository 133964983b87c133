// SPDX-License-Identifier: GPL-2.0-or-later
#include <doctest/doctest.h>

#include <cmath>
#include <initializer_list>
#include <limits>

#include "turn.h"

using namespace floe;

TEST_CASE("cosine and sine are right to round-off, near and far") {
  for (const double range : {1e-9, 0.5, 1.0, 10.0, 1e3, 1e5}) {
    for (int k = -2000; k <= 2000; ++k) {
      const double angle = range * k / 2000.0;
      double c, s;
      cos_sin(angle, c, s);
      CHECK(std::fabs(c - std::cos(angle)) <= 2.3e-16);
      CHECK(std::fabs(s - std::sin(angle)) <= 2.3e-16);
      CHECK(std::fabs(c * c + s * s - 1.0) <= 4.5e-16);
    }
  }
}

TEST_CASE("cosine and sine of packs have the bits of single ones") {
  for (int k = -4000; k < 4000; k += 4) {
    const double a = 0.37 * k;
    const Pack4 angle{a, a + 0.37, a + 0.74, a + 1.11};
    Pack4 c, s;
    cos_sin(angle, c, s);
    Pack2 c2, s2;
    cos_sin(Pack2{angle[0], angle[1]}, c2, s2);
    for (int lane = 0; lane < 4; ++lane) {
      double one_c, one_s;
      cos_sin(angle[lane], one_c, one_s);
      CHECK(c[lane] == one_c);
      CHECK(s[lane] == one_s);
      if (lane < 2) CHECK((c2[lane] == one_c && s2[lane] == one_s));
    }
  }
}

TEST_CASE("what is not finite stays so") {
  double c, s;
  cos_sin(std::nan(""), c, s);
  CHECK(!std::isfinite(c + s));
  cos_sin(std::numeric_limits<double>::infinity(), c, s);
  CHECK(!std::isfinite(c + s));
}
