// SPDX-License-Identifier: GPL-2.0-or-later
#include <doctest/doctest.h>

#include <cmath>

#include "drag.h"
#include "random.h"

using namespace floe;

namespace {

constexpr double air = 1.3 * 1.2e-3, water = 1026.0 * 5.5e-3, ice_density = 917.0;

DriftLaw law(bool wind, bool ocean, bool coriolis, bool tilt, double angle = 0.0) {
  return {wind, false, ocean, coriolis, tilt, air, water, std::cos(angle), std::sin(angle)};
}

}  // namespace

TEST_CASE("drift: from rest to the terminal velocity, any thickness at the same step") {
  const double step = 30.0, wind = 30.0;
  const double terminal = wind * std::sqrt(air / water);
  for (double h = 10.0; h > 0.9e-6; h *= 0.1) {
    Vec2 u{0, 0};
    double fastest = 0.0;
    for (int k = 0; k < 400000; ++k) {
      u = drift_step(law(true, true, false, false),
                     {u, {0, 0}, ice_density * h, 1.0, {wind, 0}, {}, 0}, step)
              .u_new;
      fastest = std::max(fastest, u.x);
      if (std::fabs(u.x / terminal - 1.0) < 1e-10) break;
    }
    CHECK(u.x == doctest::Approx(terminal).epsilon(1e-8));
    CHECK(fastest < 1.01 * terminal);
  }
}

TEST_CASE("drift: relative wind on thin ice neither overshoots nor swings") {
  DriftLaw relative = law(true, true, false, false);
  relative.relative_wind = true;
  const double n = std::sqrt(air / water), terminal = 30.0 * n / (1.0 + n);
  for (double h = 10.0; h > 0.9e-6; h *= 0.1) {
    Vec2 u{0, 0};
    double fastest = 0.0;
    for (int k = 0; k < 400000; ++k) {
      u = drift_step(relative, {u, {0, 0}, ice_density * h, 1.0, {30.0, 0}, {}, 0}, 30.0).u_new;
      fastest = std::max(fastest, u.x);
      if (std::fabs(u.x / terminal - 1.0) < 1e-10) break;
    }
    CHECK(u.x == doctest::Approx(terminal).epsilon(1e-8));
    CHECK(fastest < 1.03 * terminal);
  }
}

TEST_CASE("drift: the steady state of the step is that of the equations, all terms on") {
  const double f = 1.4e-4, angle = 0.4, m = ice_density * 2.0;
  const Vec2 wind{9, -4}, current{0.2, 0.1};
  Vec2 u{0, 0};
  for (int k = 0; k < 20000; ++k) {
    u = drift_step(law(true, true, true, true, angle), {u, {50, 20}, m, 1.0, wind, current, f}, 60)
            .u_new;
  }
  const double speed = std::hypot(wind.x, wind.y);
  const Vec2 w{current.x - u.x, current.y - u.y};
  const double s = water * std::hypot(w.x, w.y), c = std::cos(angle), n = std::sin(angle);
  const Vec2 sum{50 + air * speed * wind.x + s * (c * w.x - n * w.y) + m * f * (u.y - current.y),
                 20 + air * speed * wind.y + s * (n * w.x + c * w.y) - m * f * (u.x - current.x)};
  CHECK(std::hypot(sum.x, sum.y) < 1e-10 * 50);
}

TEST_CASE("drift: the southern hemisphere is the mirror image of the northern") {
  Uniform r(8);
  for (int k = 0; k < 2000; ++k) {
    DriftLaw some = law(k & 1, k & 2, k & 4, k & 8, r(-1, 1));
    some.relative_wind = k & 16;
    const double m = std::pow(10.0, r(0, 4)), step = std::pow(10.0, r(0, 3)), f = r(1e-6, 1.5e-4);
    const Vec2 u{r(-1, 1), r(-1, 1)}, push{r(-9, 9), r(-9, 9)};
    const Vec2 wind{r(-20, 20), r(-20, 20)}, current{r(-1, 1), r(-1, 1)};
    const auto mirrored = [](const Vec2 &v) { return Vec2{v.x, -v.y}; };
    const Vec2 north = drift_step(some, {u, push, m, 1.0, wind, current, f}, step).u_new;
    const Vec2 south =
        drift_step(some,
                   {mirrored(u), mirrored(push), m, 1.0, mirrored(wind), mirrored(current), -f},
                   step)
            .u_new;
    CHECK(south.x == doctest::Approx(north.x).epsilon(1e-13));
    CHECK(south.y == doctest::Approx(-north.y).epsilon(1e-13));
  }
}

TEST_CASE("drift: Coriolis force alone keeps the speed and closes the circle") {
  Vec2 u{0.3, 0.4}, place{0, 0};
  const double f = 1.4e-4;
  const int steps = 100000;
  const double step = 2.0 * M_PI / f / steps;
  for (int k = 0; k < steps; ++k) {
    u = drift_step(law(false, false, true, false), {u, {0, 0}, 900.0, 1.0, {}, {}, f}, step).u_new;
    place = {place.x + step * u.x, place.y + step * u.y};
  }
  CHECK(std::fabs(std::hypot(u.x, u.y) / 0.5 - 1.0) < 1e-12);
  CHECK(std::hypot(place.x, place.y) < 1e-6 * 0.5 / f);
}

TEST_CASE("drift: the impulses add up to the change of momentum, for any set of terms") {
  Uniform r(6);
  for (int k = 0; k < 2000; ++k) {
    DriftLaw some = law(k & 1, k & 2, k & 4, k & 8, r(-1, 1));
    some.relative_wind = k & 16;
    const double m = std::pow(10.0, r(-3, 4)), step = std::pow(10.0, r(-2, 3));
    const DriftInput in{
        {r(-1, 1), r(-1, 1)}, {r(-9, 9), r(-9, 9)}, m, 1.0, {r(-20, 20), r(-20, 20)},
        {r(-1, 1), r(-1, 1)}, r(-1.5e-4, 1.5e-4)};
    const DriftStep out = drift_step(some, in, step);
    const Vec2 sum{in.contact.x * step + out.wind.x + out.ocean.x + out.coriolis.x + out.tilt.x,
                   in.contact.y * step + out.wind.y + out.ocean.y + out.coriolis.y + out.tilt.y};
    const double scale = m * (std::hypot(in.u.x, in.u.y) + std::hypot(out.u_new.x, out.u_new.y)) +
                         std::hypot(out.wind.x, out.wind.y) + std::hypot(out.ocean.x, out.ocean.y) +
                         step * std::hypot(in.contact.x, in.contact.y);
    CHECK(std::fabs(m * (out.u_new.x - in.u.x) - sum.x) < 1e-12 * scale);
    CHECK(std::fabs(m * (out.u_new.y - in.u.y) - sum.y) < 1e-12 * scale);
    // the Coriolis force does no work
    const double work =
        out.coriolis.x * (in.u.x + out.u_new.x) + out.coriolis.y * (in.u.y + out.u_new.y);
    const double speed = std::hypot(in.u.x + out.u_new.x, in.u.y + out.u_new.y);
    CHECK(std::fabs(work) <= 1e-14 * std::hypot(out.coriolis.x, out.coriolis.y) * speed);
  }
}

TEST_CASE("drag: the scalar root") {
  Uniform r(7);
  for (int k = 0; k < 5000; ++k) {
    const double alpha = r(1, 3), q = r(-0.5, 0.5), gamma = std::pow(10.0, r(-8, 8));
    const double angle = r(-1, 1), b = std::pow(10.0, r(-8, 8));
    const double s = drag_speed(alpha, q, gamma, std::cos(angle), std::sin(angle), b);
    const double re = alpha + gamma * s * std::cos(angle), im = q + gamma * s * std::sin(angle);
    CHECK(s * std::hypot(re, im) == doctest::Approx(b).epsilon(1e-13));
  }
  CHECK(drag_speed(1, 0, 1, 1, 0, 0.0) == 0.0);
}

TEST_CASE("spin: decays as the quadratic law says and tends to half the vorticity") {
  const double h = 1.0, r = 1000.0, area = M_PI * r * r, mass = ice_density * h * area;
  // w' = -k w^2 with k = (2/5) A rho C r^3 / (m r^2 / 2)
  const double k = 0.8 * area * water * r / mass, w0 = 1e-3, end = 3.0 / (k * w0);
  const double exact = w0 / (1.0 + k * w0 * end);
  double error[2];
  for (int half = 0; half < 2; ++half) {
    const int steps = 1000 << half;
    double w = w0;
    for (int n = 0; n < steps; ++n) {
      w = spin_step(true, water, w, 0.0, mass, r, area, 0.0, end / steps);
    }
    error[half] = std::fabs(w / exact - 1.0);
  }
  CHECK(error[0] < 2e-3);
  CHECK(error[1] < 0.55 * error[0]);
  double w = w0;
  for (int n = 0; n < 1000000; ++n) w = spin_step(true, water, w, 0.0, mass, r, area, 4e-5, 1e4);
  CHECK(w == doctest::Approx(2e-5).epsilon(1e-6));
}
