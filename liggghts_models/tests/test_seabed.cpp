// SPDX-License-Identifier: GPL-2.0-or-later
#include <doctest/doctest.h>

#include <cmath>

#include "random.h"
#include "seabed.h"

using namespace floe;

namespace {

constexpr double air = 1.3 * 1.2e-3, water = 1026.0 * 5.5e-3, ice_density = 917.0;
constexpr SeabedLaw lemieux{8.0, 15.0, 5.0e-5, 20.0};

DriftLaw law(bool wind, bool ocean, bool coriolis = false, bool tilt = false, double angle = 0.0) {
  return {wind, false, ocean, coriolis, tilt, air, water, std::cos(angle), std::sin(angle)};
}

}  // namespace

TEST_CASE("seabed: ice is held from the critical thickness on") {
  // h_c = A D / k1: 2.5 m of solid ice in 20 m of water; 1 m more holds with 15 Pa.
  CHECK(seabed_limit(lemieux, 2.49, 1.0, 100.0, 20.0) == 0.0);
  CHECK(seabed_limit(lemieux, 3.5, 1.0, 100.0, 20.0) == doctest::Approx(1500.0));
  // The same volume in a tenth less of area: the keel reaches deeper, and the ice is looser.
  const double loose = 15.0 * (3.5 - 0.9 * 2.5) * std::exp(-2.0) * 100.0;
  CHECK(seabed_limit(lemieux, 3.5, 0.9, 90.0, 20.0) == doctest::Approx(loose));
  CHECK(seabed_limit(lemieux, 1.0, 0.0, 0.0, 0.0) == 0.0);
  CHECK(seabed_limit(lemieux, 0.0, 1.0, 100.0, 0.0) == 0.0);
}

TEST_CASE("seabed: under a wind that it withstands ice creeps, as the law says, at any step") {
  // tau = F u / (u + u0) has the root u = u0 tau / (F - tau).
  const double stress = air * 100.0, limit = 15.0, creep = 5.0e-5;
  for (double step : {1.0, 60.0, 3600.0, 1.0e6}) {
    Vec2 u{0.3, -0.2};
    for (int k = 0; k < 200; ++k) {
      const DriftInput in{u, {0, 0}, ice_density * 3.0, 1.0, {10.0, 0.0}, {}, 0.0};
      u = grounded_step(law(true, false), in, limit, creep, step).u_new;
    }
    CHECK(u.x == doctest::Approx(creep * stress / (limit - stress)).epsilon(1e-9));
    CHECK(std::fabs(u.y) < 1e-12 * creep);
  }
}

TEST_CASE("seabed: a wind that it does not withstand drives ice at the speed of the balance") {
  // tau_a - F u / (u + u0) = rho_w C_w u^2, solved by bisection.
  const double stress = air * 400.0, limit = 0.4 * stress, creep = 5.0e-5;
  double low = 0.0, high = 1.0;
  for (int k = 0; k < 200; ++k) {
    const double u = 0.5 * (low + high);
    (stress - limit * u / (u + creep) > water * u * u ? low : high) = u;
  }
  for (double step : {10.0, 600.0, 1.0e5}) {
    Vec2 u{0, 0};
    for (int k = 0; k < 20000; ++k) {
      const DriftInput in{u, {0, 0}, ice_density, 1.0, {20.0, 0.0}, {}, 0.0};
      const Vec2 next = grounded_step(law(true, true), in, limit, creep, step).u_new;
      const double change = std::fabs(next.x - u.x);
      u = next;
      if (change < 1e-14) break;
    }
    CHECK(u.x == doctest::Approx(low).epsilon(1e-8));
  }
}

TEST_CASE("seabed: the law holds at the new velocity, whatever else acts, and momentum adds up") {
  Uniform r(12);
  for (int k = 0; k < 3000; ++k) {
    DriftLaw some = law(k & 1, k & 2, k & 4, k & 8, r(-1, 1));
    some.relative_wind = k & 16;
    const double m = std::pow(10.0, r(0, 4)), step = std::pow(10.0, r(-2, 4));
    const double limit = std::pow(10.0, r(-6, 3)), creep = std::pow(10.0, r(-7, -2));
    const DriftInput in{
        {r(-1, 1), r(-1, 1)}, {r(-9, 9), r(-9, 9)}, m, 1.0, {r(-20, 20), r(-20, 20)},
        {r(-1, 1), r(-1, 1)}, r(-1.5e-4, 1.5e-4)};
    const DriftStep out = grounded_step(some, in, limit, creep, step);
    const double speed = std::hypot(out.u_new.x, out.u_new.y);
    const double wanted = step * limit / (speed + creep);
    CHECK(out.seabed.x == doctest::Approx(-wanted * out.u_new.x).epsilon(1e-8));
    CHECK(out.seabed.y == doctest::Approx(-wanted * out.u_new.y).epsilon(1e-8));
    const Vec2 sum{
        in.contact.x * step + out.wind.x + out.ocean.x + out.coriolis.x + out.tilt.x + out.seabed.x,
        in.contact.y * step + out.wind.y + out.ocean.y + out.coriolis.y + out.tilt.y +
            out.seabed.y};
    const double scale = m * (std::hypot(in.u.x, in.u.y) + speed) +
                         std::hypot(out.wind.x, out.wind.y) + std::hypot(out.ocean.x, out.ocean.y) +
                         step * std::hypot(in.contact.x, in.contact.y) + step * limit;
    CHECK(std::fabs(m * (out.u_new.x - in.u.x) - sum.x) < 1e-11 * scale);
    CHECK(std::fabs(m * (out.u_new.y - in.u.y) - sum.y) < 1e-11 * scale);
    // No friction leaves the step as it is, to the last bit.
    const DriftStep free = drift_step(some, in, step),
                    none = grounded_step(some, in, 0, creep, step);
    CHECK(free.u_new.x == none.u_new.x);
    CHECK(free.u_new.y == none.u_new.y);
  }
}

TEST_CASE("seabed: friction alone stops ice and never turns it back") {
  Uniform r(13);
  for (int k = 0; k < 500; ++k) {
    const double step = std::pow(10.0, r(-2, 6)), limit = std::pow(10.0, r(-6, 3));
    const Vec2 u{r(-1, 1), r(-1, 1)};
    const DriftInput in{u, {0, 0}, 2000.0, 1.0, {}, {}, 0.0};
    const Vec2 next = grounded_step(law(false, false), in, limit, 5e-5, step).u_new;
    CHECK(next.x * u.x + next.y * u.y >= 0.0);
    CHECK(std::hypot(next.x, next.y) <= std::hypot(u.x, u.y));
    CHECK(std::fabs(next.x * u.y - next.y * u.x) <= 1e-12 * (u.x * u.x + u.y * u.y));
  }
}
