// SPDX-License-Identifier: GPL-2.0-or-later
#include <doctest/doctest.h>

#include <cmath>

#include "forces.h"
#include "random.h"

using namespace floe;

namespace {

// A constant stress to the east, with two keywords, and a push along the current.
struct EastPush : PushForce {
  static constexpr const char *name = "east";
  static constexpr ForceKeywords keywords{{"east_stress", 0.5}, {"east_share", 1.0, true}};
  static Vec2 push(const ForceValues &v, const ForceInput &at) {
    return {v[0] * v[1] * at.drift.area, 0.0};
  }
};
struct DeepPush : PushForce {
  static constexpr const char *name = "deep";
  static constexpr bool reads_depth = true;
  static Vec2 push(const ForceValues &, const ForceInput &at) {
    return {at.depth * at.drift.ocean.x, at.depth * at.drift.ocean.y};
  }
};
using Three = ForceSet<LawList<SeabedFriction, EastPush, DeepPush>>;

constexpr DriftLaw everything{true, false, true, true, true, 1.56e-3, 5.643, 1.0, 0.0};

}  // namespace

TEST_CASE("forces: keywords, defaults and sums come from the list, in its order") {
  const Three forces;
  CHECK(!forces.any());
  CHECK(forces.value[0][0] == defaults::keel_ratio);
  CHECK(forces.value[1][0] == 0.5);
  CHECK(Three::find("east").force == 1);
  CHECK(Three::find("east").value == -1);
  CHECK(Three::find("east_share").value == 1);
  CHECK(Three::find("east_share").zero);
  CHECK(!Three::find("east_stress").zero);
  CHECK(Three::find("seabed_openness").value == 3);
  CHECK(Three::find("no_such_word").force == -1);
  CHECK(Three::find("").force == -1);
  CHECK(Three::sum_names() ==
        " impulse_seabed_x impulse_seabed_y dissipation_seabed impulse_east_x impulse_east_y "
        "work_east"
        " impulse_deep_x impulse_deep_y work_deep");
  // Numbers that input scripts know (docs/models/fix_floe_integrate.md).
  CHECK(Forces::sum_names().find(" impulse_seabed_x impulse_seabed_y dissipation_seabed") == 0);
}

TEST_CASE("forces: those that read the depth act where it is given") {
  Three forces;
  CHECK(forces.reads_depth() == nullptr);
  forces.use[1] = true;
  CHECK(forces.reads_depth() == nullptr);
  CHECK(forces.with_depth(false).any());
  forces.use[1] = false;
  forces.use[2] = true;
  CHECK(std::string(forces.reads_depth()) == "deep");
  CHECK(forces.with_depth(true).any());
  CHECK(!forces.with_depth(false).any());
}

TEST_CASE("forces: a push alone gives its impulse, what it names, and nothing where it is off") {
  Three forces;
  forces.use[1] = true;
  forces.value[1][1] = 2.0;
  const DriftLaw none{};
  const ForceInput at{{{0.1, 0.2}, {3.0, -1.0}, 50.0, 7.0, {}, {}, 0.0}, 1.0, 1.0, 0.0};
  Three::Impulses given;
  const DriftStep out = forces.step(none, at, 2.0, given);
  CHECK(given[1].x == doctest::Approx(2.0 * 0.5 * 2.0 * 7.0));
  CHECK(out.u_new.x == doctest::Approx(0.1 + 2.0 * (3.0 + 7.0) / 50.0));
  CHECK(out.u_new.y == doctest::Approx(0.2 - 2.0 / 50.0));
  CHECK(given[0].x == 0.0);
  CHECK(given[2].x == 0.0);
}

TEST_CASE("forces: impulses and works of any set add up, beside wind, drag and rotation") {
  Uniform r(21);
  for (int k = 0; k < 2000; ++k) {
    Three forces;
    for (int n = 0; n < 3; ++n) forces.use[n] = k & (1 << n);
    DriftLaw law = everything;
    law.relative_wind = k & 8;
    const double m = std::pow(10.0, r(2, 4)), step = std::pow(10.0, r(-1, 2));
    const ForceInput at{{{r(-1, 1), r(-1, 1)},
                         {r(-9, 9), r(-9, 9)},
                         m,
                         1.0,
                         {r(-20, 20), r(-20, 20)},
                         {r(-1, 1), r(-1, 1)},
                         1.4e-4},
                        r(0, 8),
                        r(0.5, 1),
                        r(0, 30)};
    Three::Impulses given;
    const DriftStep out = forces.step(law, at, step, given);
    const Vec2 u = at.drift.u, v = out.u_new, mean{0.5 * (u.x + v.x), 0.5 * (u.y + v.y)};
    const Vec2 known{
        step * at.drift.contact.x + out.wind.x + out.ocean.x + out.coriolis.x + out.tilt.x,
        step * at.drift.contact.y + out.wind.y + out.ocean.y + out.coriolis.y + out.tilt.y};
    Three::Ledger sums;
    Three::add(sums, given, mean);
    Vec2 added{};
    double work = 0.0, size = m * (std::hypot(u.x, u.y) + std::hypot(v.x, v.y)) +
                              std::hypot(out.wind.x, out.wind.y) +
                              std::hypot(out.ocean.x, out.ocean.y);
    for (int n = 0; n < 3; ++n) {
      added = {added.x + sums.of[n].impulse_x, added.y + sums.of[n].impulse_y};
      work += n == 0 ? -sums.of[n].energy : sums.of[n].energy;
      size += std::hypot(given[n].x, given[n].y);
    }
    CHECK(std::fabs(m * (v.x - u.x) - known.x - added.x) < 1e-11 * size);
    CHECK(std::fabs(m * (v.y - u.y) - known.y - added.y) < 1e-11 * size);
    const double kinetic = 0.5 * m * (v.x * v.x + v.y * v.y - u.x * u.x - u.y * u.y);
    const double others = known.x * mean.x + known.y * mean.y;
    CHECK(std::fabs(kinetic - others - work) <
          1e-11 * size * (std::hypot(u.x, u.y) + std::hypot(v.x, v.y)));
    if (!forces.any()) {  // to the last bit
      const DriftStep plain = drift_step(law, at.drift, step);
      CHECK(plain.u_new.x == v.x);
      CHECK(plain.u_new.y == v.y);
    }
  }
}
