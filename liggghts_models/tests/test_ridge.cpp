// SPDX-License-Identifier: GPL-2.0-or-later
#include "ridge.h"

#include <doctest/doctest.h>

#include <cmath>

#include "linear_contact.h"
#include "random.h"

using namespace floe;

namespace {

constexpr RidgeMaterial hopkins{26126.0, 928.0, 0.3};
constexpr double strength = 1e5;

}  // namespace

TEST_CASE("ridge: thin ice piles up, thick ice crushes") {
  const RidgeForce thin = ridge_force(hopkins, strength, {50.0, 0.2, 1.0});
  CHECK(thin.force == doctest::Approx(26126.0 * 0.2 + 928.0 * 0.04 * 50.0).epsilon(1e-14));
  CHECK(thin.slope == doctest::Approx(928.0 * 0.04).epsilon(1e-14));
  const RidgeForce thick = ridge_force(hopkins, strength, {50.0, 1.5, 1.0});
  CHECK(thick.force == doctest::Approx(1.5 * strength).epsilon(1e-14));
  CHECK(thick.slope == 0.0);
  // Far closed, thin ice crushes too: piling up would take more.
  CHECK(ridge_force(hopkins, strength, {1e5, 0.2, 1.0}).force == doctest::Approx(0.2 * strength));
}

TEST_CASE("ridge: the force is continuous and grows with thickness and with closing") {
  for (const double closing : {0.0, 30.0, 800.0}) {
    double last = 0.0;
    for (int k = 1; k <= 3000; ++k) {
      const double h = 1e-3 * k;
      const double force = ridge_force(hopkins, strength, {closing, h, 1.0}).force;
      CHECK(force >= last);
      CHECK(force - last < 800.0);  // a jump at 0.3 m would be 22,000 N/m
      CHECK(force <= h * strength * (1 + 1e-14));
      CHECK(ridge_force(hopkins, strength, {closing + 1.0, h, 1.0}).force >= force * (1 - 1e-14));
      last = force;
    }
  }
}

TEST_CASE("ridge: the slope is that of the force") {
  Uniform u(8);
  for (int k = 0; k < 300; ++k) {
    const Ridge r{u(0, 1000), u(0.01, 0.7), 1.0};
    const RidgeForce f = ridge_force(hopkins, strength, r);
    const RidgeForce g = ridge_force(hopkins, strength, {r.closing + 1e-3, r.thickness, 1.0});
    if (f.slope == 0.0 || g.slope == 0.0) continue;
    CHECK((g.force - f.force) / 1e-3 == doctest::Approx(f.slope).epsilon(1e-5));
  }
}

TEST_CASE("ridge: two discs pressed together follow the closed form") {
  const double h0 = 0.2, stiffness = 1e7, length = 1000.0, start = 2000.0;
  Ridge r{0.0, h0, length};
  double rest = 0.0;
  const double first = length * 26126.0 * h0 / stiffness;  // overlap at which ridging begins
  for (int k = 1; k <= 400; ++k) {
    const double pressed = 0.25 * k, before = r.closing;
    const RidgeForce limit = ridge_force(hopkins, strength, r);
    const double closed = ridge_closing(limit, stiffness, start - rest, pressed - rest, r);
    rest += closed;
    CHECK(r.closing == before + closed);
    if (pressed <= first) {
      CHECK(closed == 0.0);
      continue;
    }
    // The force lies on the limit, to the second order of the step.
    const double force = stiffness * (pressed - rest);
    const double now = length * ridge_force(hopkins, strength, r).force;
    CHECK(force <= now * (1 + 1e-12));
    CHECK(force == doctest::Approx(now).epsilon(2e-4));
    // The ice between the centres keeps its volume.
    CHECK(r.thickness * (start - rest) == doctest::Approx(h0 * start).epsilon(1e-13));
  }
  CHECK(r.closing == doctest::Approx(100.0 - first).epsilon(2e-2));
  // Unloading is elastic: the ridge stays.
  const Ridge built = r;
  CHECK(ridge_closing(ridge_force(hopkins, strength, r), stiffness, start - rest, 99.0 - rest, r) ==
        0.0);
  CHECK(r.closing == built.closing);
}

TEST_CASE("ridge: damping does not lift the force above the limit, nor hold the pair together") {
  const ContactMaterial m{1.0e8, 0.5, 0.3, std::sqrt(0.5), 0.3};
  const ContactConstants c = contact_constants(m, 1.0, 1.0, 1e9);
  double slip = 0.0;
  ContactLoss loss;
  ContactPose pose{{1998.0, 0.0}, 1998.0, 1000.0, 1000.0, {-5.0, 0.0}, 0.0, 0.0};
  const double elastic = 2.0 * c.stiffness, limit = 1.01 * elastic;
  const ContactForce f = contact_force<false, true>(m, c, pose, 2.0, 0.1, slip, loss, limit);
  CHECK(f.f.x == -limit);
  CHECK(loss.damping == doctest::Approx((limit - elastic) * 5.0));
  const ContactForce above =
      contact_force<false, true>(m, c, pose, 2.0, 0.1, slip, loss, 0.5 * elastic);
  CHECK(above.f.x == -elastic);  // evaluated from a history that has not closed yet
  pose.v.x = 100.0;
  CHECK(contact_force<false, true>(m, c, pose, 2.0, 0.1, slip, loss, limit).f.x == 0.0);
}

TEST_CASE("ridge: open water closes first, and then the force is that of ice without leads") {
  RidgeMaterial leads = hopkins;
  leads.softening = 20.0;
  const double stiffness = 1e8, length = 1000.0, start = 4000.0, h0 = 0.9, cover = 0.9;
  Ridge r{0.0, h0, length, cover};
  double rest = 0.0;
  for (int k = 1; k <= 6000; ++k) {
    const double pressed = 0.1 * k, span = start - rest;
    RidgeForce limit = ridge_force(leads, strength, r);
    limit.slope += lead_slope(leads, r, span, limit.force);
    rest += ridge_closing(limit, stiffness, span, pressed - rest, r);
    // The ice between the centres keeps its volume, and its area while there is water.
    CHECK(r.thickness * (start - rest) == doctest::Approx(h0 * start).epsilon(1e-12));
    const double now = cover * start / (start - rest);
    CHECK(r.cover == doctest::Approx(std::min(now, 1.0)).epsilon(1e-12));
    // Hibler's strength per thickness, with what crushes ice for P*.
    const double whole = length * strength * r.thickness * std::exp(-20.0 * (1.0 - r.cover));
    CHECK(stiffness * (pressed - rest) <= whole * (1 + 1e-9));
    if (r.closing > 0.0 && k % 100 == 0) {
      CHECK(stiffness * (pressed - rest) == doctest::Approx(whole).epsilon(1e-3));
    }
  }
  CHECK(r.cover == 1.0);
  CHECK(r.closing > (1.0 - cover) * start);
  CHECK(ridge_force(leads, strength, r).force == ridge_force(hopkins, strength, r).force);
  // Half of the water gone: a third of the force.
  const Ridge half{0.0, h0, length, 0.95}, none{0.0, h0, length};
  const double share =
      ridge_force(leads, strength, half).force / ridge_force(leads, strength, none).force;
  CHECK(share == doctest::Approx(std::exp(-1.0)).epsilon(1e-14));
  CHECK(ridge_force(hopkins, strength, half).force == ridge_force(hopkins, strength, none).force);
}

TEST_CASE("ridge: the slope of the force with leads is that of the force") {
  RidgeMaterial leads = hopkins;
  leads.softening = 20.0;
  Uniform u(9);
  for (int k = 0; k < 300; ++k) {
    const double span = u(2e3, 5e4);
    const Ridge r{u(0, 1000), u(0.7, 3.0), 1.0, u(0.5, 0.99)};
    const double force = ridge_force(leads, strength, r).force, step = 1e-6 * span;
    // At the same thickness: its growth is not in the slope, nor was it without leads.
    const Ridge next{r.closing, r.thickness, 1.0, r.cover * span / (span - step)};
    const double grown = (ridge_force(leads, strength, next).force - force) / step;
    CHECK(lead_slope(leads, r, span, force) == doctest::Approx(grown).epsilon(1e-4));
  }
  CHECK(lead_slope(leads, {0.0, 1.0, 1.0, 1.0}, 1e4, 1e5) == 0.0);
}

TEST_CASE("ridge: the shares add up and the thinner element gives more") {
  CHECK(ridge_share(1.0, 1.0) == 0.5);
  CHECK(ridge_share(0.5, 1.5) == 0.75);
  CHECK(ridge_share(0.0, 0.0) == 0.5);
  Uniform u(3);
  for (int k = 0; k < 100; ++k) {
    const double a = u(0.01, 5), b = u(0.01, 5);
    CHECK(ridge_share(a, b) + ridge_share(b, a) == doctest::Approx(1.0).epsilon(1e-15));
    CHECK((ridge_share(a, b) > 0.5) == (a < b));
  }
}

TEST_CASE("ridge: a broken bond hands over the smallest of its force, ridging and its energy") {
  CHECK(ridge_takeover(5.0, 1e9, 7.0, 1.0) == 5.0);
  CHECK(ridge_takeover(9.0, 1e9, 7.0, 1.0) == 7.0);
  CHECK(ridge_takeover(9.0, 8.0, 7.0, 1.0) == 4.0);
  CHECK(ridge_takeover(-9.0, 8.0, 7.0, 1.0) == 0.0);  // it broke in tension
}

TEST_CASE("ridge: the bond's normal force is that of the force law at rest") {
  const BondMaterial m = bond_material(1e9, 0.3, 0.1, 0.2, 0.7);
  const BondShape b{{1000, -500}, {1000, 500}, {-1000, -500}, {-1000, 500}, 2000, 1.0, 0.1, 0.3};
  const BondConstants c = bond_constants(m, b, strength, 1e9);
  const BondPose pose{{1999.9, 0.05}, {1, 0}, {std::cos(1e-5), std::sin(1e-5)}, {0, 0}, 0.0, 0.0};
  const BondLine line = bond_line(b, pose);
  double watt;
  const PairForce f = bond_force(m, c, b, line, pose, watt);
  const double normal = f.f.x * line.n.x + f.f.y * line.n.y;
  CHECK(bond_normal_force(m, c, b, line) == doctest::Approx(normal).epsilon(1e-12));
  CHECK(normal < 0.0);
}
