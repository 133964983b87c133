// SPDX-License-Identifier: GPL-2.0-or-later
//
// The laws with what no scene should hold but some will: thicknesses over ten orders of magnitude,
// elements of 1 m beside such of 100 km, storms, strengths of nothing and of infinity. Built with
// the sanitizers too (test_laws_sanitized).
#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "drag.h"
#include "glue_bond.h"
#include "linear_contact.h"
#include "random.h"
#include "ridge.h"
#include "turn.h"

using namespace floe;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr int trials = 20000;

double decades(Uniform &random, double low, double high) {
  return std::exp(random(std::log(low), std::log(high)));
}

bool finite(Vec2 v) { return std::isfinite(v.x) && std::isfinite(v.y); }

}  // namespace

TEST_CASE("extremes: drift stays finite and below what drives it") {
  Uniform random(1);
  for (int k = 0; k < trials; ++k) {
    const double angle = random(-1.2, 1.2);
    DriftLaw law{true,          k % 2 == 0,      true,           true, false, 1.3 * 1.2e-3,
                 1026 * 5.5e-3, std::cos(angle), std::sin(angle)};
    const double h = decades(random, 1e-8, 30.0), speed = decades(random, 1e-6, 1e3);
    const double turn = random(0.0, 6.3), step = decades(random, 1e-3, 3600.0);
    const DriftInput in{{random(-3, 3), random(-3, 3)},
                        {0, 0},
                        917.0 * h,
                        1.0,
                        {speed * std::cos(turn), speed * std::sin(turn)},
                        {random(-2, 2), random(-2, 2)},
                        random(-1.5e-4, 1.5e-4)};
    const DriftStep out = drift_step(law, in, step);
    CHECK(finite(out.u_new));
    CHECK(finite(out.wind));
    CHECK(finite(out.ocean));
    // Neither wind nor water nor inertia pulls faster than all three together.
    const double bound = std::hypot(in.u.x, in.u.y) + 2.0 * std::hypot(in.ocean.x, in.ocean.y) +
                         speed * std::sqrt(law.air / law.water / std::cos(angle)) + 1.0;
    CHECK(std::hypot(out.u_new.x, out.u_new.y) < 3.0 * bound);
  }
}

TEST_CASE("extremes: spin never turns past what the water has") {
  Uniform random(2);
  for (int k = 0; k < trials; ++k) {
    const double radius = decades(random, 1.0, 1e5), area = M_PI * radius * radius;
    const double mass = 917.0 * area * decades(random, 1e-8, 30.0), spin = random(-1.0, 1.0);
    const double vorticity = random(-1e-3, 1e-3), step = decades(random, 1e-3, 3600.0);
    const double now =
        spin_step(true, 1026 * 5.5e-3, spin, 0.0, mass, radius, area, vorticity, step);
    const double rest = 0.5 * vorticity;
    CHECK(std::isfinite(now));
    CHECK((now - rest) * (spin - rest) >= 0.0);
    CHECK(std::fabs(now - rest) <= std::fabs(spin - rest) * (1 + 1e-12));
  }
}

TEST_CASE("extremes: contacts push within their law's bound") {
  Uniform random(3);
  const ContactMaterial m{1e8, 0.5, 0.3, std::sqrt(0.5), 0.3};
  for (int k = 0; k < trials; ++k) {
    const double one = decades(random, 1.0, 1e5), two = decades(random, 1.0, 1e5);
    const double h_one = decades(random, 1e-8, 30.0), h_two = decades(random, 1e-8, 30.0);
    const double reduced = 917.0 * decades(random, 1e-8, 1e12);
    const ContactConstants c = contact_constants(m, h_one, h_two, reduced);
    const double least = std::min(one, two), overlap = random(0.0, 0.99) * least;
    const double distance = one + two - overlap, turn = random(0.0, 6.3);
    const ContactPose p{{distance * std::cos(turn), distance * std::sin(turn)},
                        distance,
                        one,
                        two,
                        {random(-3, 3), random(-3, 3)},
                        random(-1e-2, 1e-2),
                        random(-1e-2, 1e-2)};
    const double before = random(-100, 100);
    double slip = before;
    ContactLoss loss;
    const ContactForce f = contact_force<true>(m, c, p, overlap, 0.1, slip, loss);
    CHECK(finite(f.f));
    CHECK(std::isfinite(slip));
    const Vec2 n{p.d.x / distance, p.d.y / distance};
    const double normal = -(f.f.x * n.x + f.f.y * n.y), side = cross(n, f.f);
    CHECK(normal >= -1e-9 * c.stiffness * overlap);
    CHECK(std::fabs(side) <= m.friction * normal * (1 + 1e-9) + 1e-9 * c.stiffness * overlap);
    // A spring that is turned round within the step gives back what it held.
    if (before * slip > 0.0) CHECK(loss.friction >= 0.0);
  }
}

TEST_CASE("extremes: ridges give way at their force, whatever the ice") {
  Uniform random(4);
  for (int k = 0; k < trials; ++k) {
    const RidgeMaterial m{26126.0, 928.0, 0.3, k % 2 ? 0.0 : 20.0};
    Ridge r{random(0, 1) * decades(random, 1e-3, 1e5), decades(random, 1e-8, 50.0),
            decades(random, 1.0, 1e5), k % 3 ? 1.0 : random(0.0, 1.0)};
    const double strength = k % 10 == 0 ? 0.0 : decades(random, 1.0, 1e9);
    const double span = decades(random, 2.0, 2e5), overlap = random(0.0, 0.9) * span;
    const double stiffness = contact_stiffness(1e8, r.thickness, decades(random, 1e-8, 30.0));
    RidgeForce limit = ridge_force(m, strength, r);
    limit.slope += lead_slope(m, r, span, limit.force);
    CHECK(std::isfinite(limit.force));
    CHECK(limit.force >= 0.0);
    CHECK(limit.slope >= 0.0);
    const Ridge before = r;
    const double closing = ridge_closing(limit, stiffness, span, overlap, r);
    CHECK(closing >= 0.0);
    CHECK(closing <= overlap * (1 + 1e-12));
    CHECK(r.thickness >= before.thickness);
    CHECK(std::isfinite(r.thickness));
    CHECK(r.cover >= before.cover);
    CHECK(r.cover <= 1.0);
    // What is left of the overlap pushes with no more than the ridge bears.
    const double bears = r.length * (limit.force + limit.slope * closing);
    CHECK(stiffness * (overlap - closing) <= bears * (1 + 1e-9) + 1e-9 * stiffness * overlap);
  }
}

TEST_CASE("extremes: bonds of any length crack to an admissible state, or go") {
  Uniform random(5);
  for (int k = 0; k < trials; ++k) {
    const double radius = decades(random, 0.5, 1e5), share = random(0.01, 1.0);
    const double half = share * radius, h = decades(random, 1e-8, 30.0);
    const double strength = k % 7 == 0 ? 0.0 : k % 7 == 1 ? infinity : decades(random, 1.0, 1e12);
    const double crack_a = random(0.0, 0.5), crack_b = random(0.0, 0.49);
    BondShape b{{radius, -half}, {radius, half}, {-radius, -half}, {-radius, half}, 2 * radius, h,
                crack_a,         crack_b};
    const BondMaterial m = bond_material(1e9, 0.3, 0.1, random(0.01, 1.0), 0.7);
    const BondConstants c = bond_constants(m, b, strength, 917.0 * h * M_PI * radius * radius);
    double co_lo, si_lo, co_hi, si_hi;
    cos_sin(random(-4, 4), co_lo, si_lo);
    cos_sin(random(-4, 4), co_hi, si_hi);
    const double stretch = decades(random, 1e-9, 0.5) * (k % 2 ? 1 : -1);
    // Every third pair only turns as one: no crack may come of that.
    const bool rigid = k % 3 == 0;
    if (rigid) co_hi = co_lo, si_hi = si_lo;
    const double span = 2 * radius * (rigid ? 1.0 : 1.0 + stretch);
    const BondPose p{{span * co_lo, span * si_lo},   {co_lo, si_lo}, {co_hi, si_hi},
                     {random(-3, 3), random(-3, 3)}, random(-1, 1),  random(-1, 1)};
    const BondLine line = bond_line(b, p);
    const bool cracked = bond_fracture(m, c, line, b);
    if (rigid && strength > 1e3) CHECK(!cracked);
    CHECK(b.crack_a >= crack_a);
    CHECK(b.crack_b >= crack_b);
    CHECK(std::isfinite(b.crack_a));
    CHECK(std::isfinite(b.crack_b));
    if (b.broken()) continue;
    const auto [least, most] = bond_range(line, b);
    const auto [low, high] = bond_limits(m, c, line);
    const double slack = 1e-9 * (std::fabs(line.dn) + std::fabs(line.dn_slope) + 1e-12 * radius);
    CHECK(least >= low - slack);
    CHECK(most <= high + slack);
    double loss;
    const PairForce f = bond_force(m, c, b, line, p, loss);
    CHECK(finite(f.f));
    CHECK(std::isfinite(f.torque_lo));
    CHECK(std::isfinite(f.torque_hi));
    CHECK(loss >= 0.0);
  }
}
