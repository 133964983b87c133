// SPDX-License-Identifier: GPL-2.0-or-later
//
// What every law of bonds and of contacts keeps, whichever they are: those of laws.h, one after the
// other. What a law says of its own is tested elsewhere.
#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include "laws.h"
#include "random.h"

using namespace floe;

namespace {

constexpr double span = 5000.0, half_line = 1500.0, compressive = 1e6, reduced = 1e10;

struct Disc {
  double x, y, theta, u, v, spin;
};

template <typename Law>
BondMaterial bond_of(double damping) {
  BondMaterial m = bond_material(1e9, 0.3, damping, 0.1, 0.7);
  for (int k = 0; k < law_keywords; ++k) m.own[k] = Law::keywords[k].value;
  return m;
}

BondShape intact() {
  const double mid = 0.5 * span;
  return {{mid, -half_line},
          {mid, half_line},
          {-mid, -half_line},
          {-mid, half_line},
          span,
          1.5,
          0.0,
          0.0};
}

BondPose pose_of(const Disc &lo, const Disc &hi) {
  return {{hi.x - lo.x, hi.y - lo.y},
          {std::cos(lo.theta), std::sin(lo.theta)},
          {std::cos(hi.theta), std::sin(hi.theta)},
          {hi.u - lo.u, hi.v - lo.v},
          lo.spin,
          hi.spin};
}

Disc moved(Uniform &u, double x, double size) {
  return {x + size * u(-1, 1), size * u(-1, 1), 1e-3 * size * u(-1, 1), u(-1, 1), u(-1, 1),
          1e-4 * u(-1, 1)};
}

template <typename P>
VectorOf<P> pack(Vec2 a) {
  return {P{} + a.x, P{} + a.y};
}

}  // namespace

TEST_CASE("laws: each has a name of its own, and is found by it") {
  const auto check = [](auto laws) {
    int number = 0;
    laws.each([&](auto law) { CHECK(laws.number(law.name) == number++); });
    CHECK(number > 1);
    CHECK(laws.number("none of them") == -1);
  };
  check(BondLaws{});
  check(ContactLaws{});
}

TEST_CASE("laws of bonds: momentum and energy") {
  BondLaws::each([](auto law) {
    using Law = decltype(law);
    CAPTURE(std::string(Law::name));
    Uniform u(11);
    for (int k = 0; k < 40; ++k) {
      const BondMaterial m = bond_of<Law>(0.2);
      const BondShape b = intact();
      const BondConstants c = bond_constants(m, b, compressive, reduced);
      Disc e[2] = {moved(u, 0.0, 1.0), moved(u, span, 1.0)};
      const BondPose pose = pose_of(e[0], e[1]);
      const BondLine line = bond_line(b, pose);
      double watt, none;
      const PairForce all = Law::template force<true>(m, c, b, line, pose, watt);
      const PairForce elastic = Law::template force<false>(m, c, b, line, pose, none);
      const double scale = std::hypot(all.f.x, all.f.y) + 1.0;
      // Torques and the couple of the forces cancel.
      CHECK(std::fabs(all.torque_lo + all.torque_hi - cross(pose.d, all.f)) < 1e-12 * scale * span);
      // What damping takes is what its part of the force takes from the motion.
      CHECK(none == 0.0);
      CHECK(watt >= 0.0);
      const double taken = pair_power(elastic, pose) - pair_power(all, pose);
      CHECK(taken == doctest::Approx(watt).epsilon(1e-9));
      // The elastic force is the slope of the energy.
      const auto energy = [&] { return Law::energy(m, c, b, bond_line(b, pose_of(e[0], e[1]))); };
      const auto slope = [&](double &coordinate, double h) {
        const double old = coordinate;
        coordinate = old + h;
        const double up = energy();
        coordinate = old - h;
        const double down = energy();
        coordinate = old;
        return (up - down) / (2.0 * h);
      };
      CHECK(energy() >= 0.0);
      CHECK(std::fabs(elastic.f.x + slope(e[0].x, 1e-3)) < 1e-6 * scale);
      CHECK(std::fabs(elastic.f.y + slope(e[0].y, 1e-3)) < 1e-6 * scale);
      CHECK(std::fabs(elastic.torque_lo + slope(e[0].theta, 1e-7)) < 1e-6 * scale * span);
      CHECK(std::fabs(elastic.torque_hi + slope(e[1].theta, 1e-7)) < 1e-6 * scale * span);
      const double normal = elastic.f.x * line.n.x + elastic.f.y * line.n.y;
      CHECK(Law::normal_force(m, c, b, line) == doctest::Approx(normal).epsilon(1e-9));
    }
  });
}

TEST_CASE("laws of bonds: what holds does not fail, what fails does so once") {
  BondLaws::each([](auto law) {
    using Law = decltype(law);
    CAPTURE(std::string(Law::name));
    Uniform u(12);
    const BondMaterial m = bond_of<Law>(0.1);
    int held = 0, failed = 0, gone = 0;
    for (int k = 0; k < 2000; ++k) {
      BondShape b = intact();
      const BondConstants c = bond_constants(m, b, compressive, reduced);
      const BondPose pose = pose_of(moved(u, 0.0, 0.5), moved(u, span, 0.5));
      const BondLine line = bond_line(b, pose);
      const bool holds = Law::holds(m, c, line, b);
      const BondShape before = b;
      CHECK(Law::fracture(m, c, line, b) == !holds);
      holds ? ++held : ++failed;
      CHECK(b.crack_a >= before.crack_a);
      CHECK(b.crack_b >= before.crack_b);
      if (b.broken()) {
        ++gone;
        const BreakageMode mode = Law::mode(m, c, line, before);
        CHECK(mode >= BreakageMode::tension);
        CHECK(mode <= BreakageMode::compression);
        continue;
      }
      CHECK(Law::energy(m, c, b, line) <= Law::energy(m, c, before, line) * (1 + 1e-12));
      // Once more, and it stays but for round-off.
      const BondShape once = b;
      Law::fracture(m, c, line, b);
      CHECK(b.crack_a - once.crack_a < 1e-9);
      CHECK(b.crack_b - once.crack_b < 1e-9);
    }
    CHECK(held > 20);
    CHECK(failed > 20);
    CHECK(gone > 20);
    // At rest nothing fails, and what is not a number does not hold.
    BondShape b = intact();
    const BondConstants c = bond_constants(m, b, compressive, reduced);
    BondLine line = bond_line(b, pose_of({0, 0, 0, 0, 0, 0}, {span, 0, 0, 0, 0, 0}));
    CHECK(Law::holds(m, c, line, b));
    line.dn = NAN;
    CHECK_FALSE(Law::holds(m, c, line, b));
  });
}

TEST_CASE("laws of bonds: the same bits in packs") {
  BondLaws::each([](auto law) {
    using Law = decltype(law);
    using P = Pack2;
    CAPTURE(std::string(Law::name));
    Uniform u(13);
    const BondMaterial m = bond_of<Law>(0.2);
    for (int k = 0; k < 300; ++k) {
      BondShape b = intact();
      b.crack_a = k % 2 ? 0.3 * u(0, 1) : 0.0;
      const BondConstants c = bond_constants(m, b, compressive, reduced);
      const BondPose p = pose_of(moved(u, 0.0, 0.5), moved(u, span, 0.5));
      const BondShapeOf<P> bs{
          pack<P>(b.lo_a), pack<P>(b.lo_b), pack<P>(b.hi_a), pack<P>(b.hi_b), P{}, P{},
          P{} + b.crack_a, P{} + b.crack_b};
      const BondConstantsOf<P> cs{P{} + c.length, P{} + c.ratio, P{} + c.damping, P{} + c.squeeze};
      const BondPoseOf<P> ps{pack<P>(p.d), pack<P>(p.turn_lo), pack<P>(p.turn_hi),
                             pack<P>(p.v), P{} + p.spin_lo,    P{} + p.spin_hi};
      const BondLine line = bond_line(b, p);
      const BondLineOf<P> lines = bond_line(bs, ps);
      double watt;
      P watts;
      const PairForce f = Law::template force<true>(m, c, b, line, p, watt);
      const PairForceOf<P> fs = Law::template force<true>(m, cs, bs, lines, ps, watts);
      const auto holds = Law::holds(m, cs, lines, bs);
      for (int lane = 0; lane < 2; ++lane) {
        CHECK(fs.f.x[lane] == f.f.x);
        CHECK(fs.f.y[lane] == f.f.y);
        CHECK(fs.torque_lo[lane] == f.torque_lo);
        CHECK(fs.torque_hi[lane] == f.torque_hi);
        CHECK(watts[lane] == watt);
        CHECK((holds[lane] != 0) == bool(Law::holds(m, c, line, b)));
      }
    }
  });
}

TEST_CASE("laws of contacts: stiffness, energy and force agree") {
  ContactLaws::each([](auto law) {
    using Law = decltype(law);
    CAPTURE(std::string(Law::name));
    ContactMaterial m{1e8, 0.5, 0.3, std::sqrt(0.5), 0.3};
    for (int k = 0; k < law_keywords; ++k) m.own[k] = Law::keywords[k].value;
    m.law = ContactLaws::number(Law::name);
    Uniform u(14);
    for (int k = 0; k < 200; ++k) {
      const ContactSide one{u(100, 1000), u(0.1, 3)}, two{u(100, 1000), u(0.1, 3)};
      const double stiffness = Law::stiffness(m, one, two), overlap = u(0.1, 5);
      CHECK(stiffness > 0.0);
      CHECK(stiffness == Law::stiffness(m, two, one));
      // A wall gives no way of its own.
      CHECK(Law::wall_stiffness(m, one) > Law::stiffness(m, one, one));
      const ContactConstants first{stiffness, 1e-3 * stiffness}, c = Law::at(first, overlap);
      CHECK((c.stiffness == first.stiffness || !Law::constant));
      CHECK(c.stiffness == constants_now(m, first, overlap).stiffness);
      CHECK(c.damping > 0.0);
      const auto energy = [&](double depth) { return contact_energy(m, stiffness, depth, 0.0); };
      const double slope = (energy(overlap + 1e-4) - energy(overlap - 1e-4)) / 2e-4;
      CHECK(c.stiffness * overlap == doctest::Approx(slope).epsilon(1e-5));
      CHECK(contact_energy(m, stiffness, overlap, 0.2) - energy(overlap) ==
            doctest::Approx(0.5 * m.shear_ratio * c.stiffness * 0.04).epsilon(1e-9));
      CHECK(contact_energy(m, stiffness, -overlap, 0.2) == 0.0);
      const Pack2 depth = Pack2{} + overlap;
      const auto cs = Law::at(
          ContactConstantsOf<Pack2>{Pack2{} + first.stiffness, Pack2{} + first.damping}, depth);
      for (int lane = 0; lane < 2; ++lane) {
        CHECK(cs.stiffness[lane] == c.stiffness);
        CHECK(cs.damping[lane] == c.damping);
      }
    }
  });
}
