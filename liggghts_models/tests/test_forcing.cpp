// SPDX-License-Identifier: GPL-2.0-or-later
#include <doctest/doctest.h>

#include "forcing.h"
#include "random.h"

using namespace floe;

namespace {

// A field linear in space and time, which sampling must meet exactly.
ForcingGrid linear_grid() {
  ForcingGrid g;
  g.time = {0.0, 100.0, 250.0};
  g.x0 = -3000.0;
  g.y0 = 500.0;
  g.dx = 700.0;
  g.dy = 400.0;
  g.nx = 6;
  g.ny = 4;
  for (const double t : g.time) {
    for (int j = 0; j < g.ny; ++j) {
      for (int i = 0; i < g.nx; ++i) {
        const double x = g.x0 + i * g.dx, y = g.y0 + j * g.dy;
        for (const double v : {1e-3 * x + t, 2e-3 * y - t, -3e-5 * y + 0.01 * t, 3e-5 * x}) {
          g.velocity.push_back(v);
        }
      }
    }
  }
  for (int k = 0; k < g.nx * g.ny; ++k) g.coriolis.push_back(1e-4 + 1e-6 * (k / g.nx));
  return g;
}

}  // namespace

TEST_CASE("forcing: bilinear in space, linear in time, with the vorticity of the current") {
  const ForcingGrid g = linear_grid();
  Uniform u(8);
  for (int k = 0; k < 500; ++k) {
    const double x = u(-3000, 500), y = u(500, 1700), t = u(0, 250);
    const ForcingSample s = sample_forcing(g, forcing_time(g, t), x, y);
    CHECK(s.wind.x == doctest::Approx(1e-3 * x + t).epsilon(1e-12));
    CHECK(s.wind.y == doctest::Approx(2e-3 * y - t).epsilon(1e-12).scale(100));
    CHECK(s.ocean.x == doctest::Approx(-3e-5 * y + 0.01 * t).epsilon(1e-12));
    CHECK(s.vorticity == doctest::Approx(6e-5).epsilon(1e-10));
    CHECK(s.coriolis == doctest::Approx(1e-4 + 1e-6 * (y - 500) / 400).epsilon(1e-12));
  }
}

TEST_CASE("forcing: outside of grid and axis the edge holds") {
  const ForcingGrid g = linear_grid();
  const ForcingSample far = sample_forcing(g, forcing_time(g, 1e9), 1e9, -1e9);
  CHECK(far.wind.x == doctest::Approx(1e-3 * 500 + 250));
  CHECK(far.wind.y == doctest::Approx(2e-3 * 500 - 250));
  const ForcingSample before = sample_forcing(g, forcing_time(g, -5.0), -1e9, 500);
  CHECK(before.wind.x == doctest::Approx(-3.0));
}

TEST_CASE("forcing: a single node and a single time hold everywhere") {
  ForcingGrid g;
  g.time = {0.0};
  g.velocity = {1, 2, 3, 4};
  g.coriolis = {5};
  const ForcingSample s = sample_forcing(g, forcing_time(g, 77.0), 1e6, -1e6);
  CHECK(s.wind.x == 1);
  CHECK(s.wind.y == 2);
  CHECK(s.ocean.x == 3);
  CHECK(s.ocean.y == 4);
  CHECK(s.coriolis == 5);
  CHECK(s.vorticity == 0);
}

TEST_CASE("forcing: means over discs are values at centres inside of a cell, and know the kinks") {
  ForcingGrid g = linear_grid();
  g.over_discs = true;
  // Straight over all lines of nodes: the mean is the value at the centre.
  const ForcingSample s = forcing_on(g, forcing_time(g, 30.0), -1000, 1100, 390);
  CHECK(s.wind.x == doctest::Approx(29.0).epsilon(1e-12));
  CHECK(s.wind.y == doctest::Approx(2.2 - 30).epsilon(1e-12));
  CHECK(s.vorticity == doctest::Approx(6e-5).epsilon(1e-10));
  // A roof: |x| has the mean 4 r / (3 pi) over a disc around 0, and 0 at its centre.
  ForcingGrid roof;
  roof.time = {0.0};
  roof.x0 = roof.y0 = -1000;
  roof.dx = roof.dy = 1000;
  roof.nx = roof.ny = 3;
  for (int k = 0; k < 9; ++k) {
    for (const double v : {k % 3 == 1 ? 0.0 : 1.0, 0.0, 0.0, 0.0}) roof.velocity.push_back(v);
  }
  const ForcingTime now = forcing_time(roof, 0.0);
  CHECK(forcing_on(roof, now, 0, 0, 500).wind.x == 0.0);
  roof.over_discs = true;
  CHECK(forcing_on(roof, now, 0, 0, 500).wind.x == doctest::Approx(2 / (3 * M_PI)).epsilon(0.01));
  // Inside of a cell there is no kink, and nothing but the centre counts.
  CHECK(forcing_on(roof, now, 500, 500, 400).wind.x ==
        doctest::Approx(sample_forcing(roof, now, 500, 500).wind.x).epsilon(1e-14));
}

TEST_CASE("forcing: a wind given as its stress keeps it between gusts") {
  ForcingGrid g;
  g.time = {0.0};
  g.dx = 1000;
  g.nx = 2;
  g.wind_stress = true;
  // 20 m/s and calm: |w| w is 400 and 0 m2/s2.
  g.velocity = {400, 0, 3, 4, 0, 0, 3, 4};
  const ForcingTime now = forcing_time(g, 0.0);
  CHECK(forcing_on(g, now, 0, 0, 1).wind.x == doctest::Approx(20));
  CHECK(forcing_on(g, now, 500, 0, 1).wind.x == doctest::Approx(std::sqrt(200.0)));
  CHECK(forcing_on(g, now, 1000, 0, 1).wind.x == 0.0);
  CHECK(forcing_on(g, now, 500, 0, 1).ocean.x == 3);
}
