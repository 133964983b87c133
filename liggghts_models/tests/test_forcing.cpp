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
