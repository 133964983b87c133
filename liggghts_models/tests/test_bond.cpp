// SPDX-License-Identifier: GPL-2.0-or-later
//
// The bond's closed forms against independent quadrature, energy and limits.
#include <doctest/doctest.h>

#include <cmath>
#include <functional>

#include "glue_bond.h"
#include "random.h"

using namespace floe;

namespace {

const BondMaterial ice = bond_material(1.0e9, 0.3, 0.2, 0.1, std::tan(0.61));
constexpr double span = 5000.0, half_line = 1500.0;

BondShape intact(double thickness = 1.0) {
  // lo at the origin, hi at (span, 0): the line runs upwards between them
  const double mid = 0.5 * span;
  return {{mid, -half_line},
          {mid, half_line},
          {-mid, -half_line},
          {-mid, half_line},
          span,
          thickness,
          0.0,
          0.0};
}

struct Body {
  double x, y, theta, u, v, spin;
};

BondPose pose_of(const Body &lo, const Body &hi) {
  return {{hi.x - lo.x, hi.y - lo.y},
          {std::cos(lo.theta), std::sin(lo.theta)},
          {std::cos(hi.theta), std::sin(hi.theta)},
          {hi.u - lo.u, hi.v - lo.v},
          lo.spin,
          hi.spin};
}

Body random_body(Uniform &u, double x, double y, double size) {
  return {x + size * u(-1, 1), y + size * u(-1, 1), 0.05 * u(-1, 1), u(-1, 1), u(-1, 1),
          1e-4 * u(-1, 1)};
}

double simpson(const std::function<double(double)> &f, double a, double b, double whole,
               int depth) {
  const double m = 0.5 * (a + b);
  const auto rule = [&](double p, double q) {
    return (q - p) / 6.0 * (f(p) + 4.0 * f(0.5 * (p + q)) + f(q));
  };
  const double left = rule(a, m), right = rule(m, b);
  if (depth == 0 || std::fabs(left + right - whole) < 1e-14 * std::fabs(whole)) return left + right;
  return simpson(f, a, m, left, depth - 1) + simpson(f, m, b, right, depth - 1);
}

double integral(const std::function<double(double)> &f, double a, double b) {
  return simpson(f, a, b, (b - a) * f(0.5 * (a + b)), 8);
}

// A point of the line and what acts there, from positions alone, with none of the law's closed forms.
struct Point {
  Vec2 place, stress;  // relative to lo; N/m on lo
  double power;        // of the damping, W/m
};

Point at(const BondShape &b, const Body &lo, const Body &hi, double reduced, double xi) {
  const auto world = [](const Body &e, Vec2 a, Vec2 c, double s) {
    const Vec2 p{a.x + s * (c.x - a.x), a.y + s * (c.y - a.y)};
    return Vec2{std::cos(e.theta) * p.x - std::sin(e.theta) * p.y,
                std::sin(e.theta) * p.x + std::cos(e.theta) * p.y};
  };
  const auto on_lo = [&](double s) { return world(lo, b.lo_a, b.lo_b, s); };
  const auto on_hi = [&](double s) {
    const Vec2 p = world(hi, b.hi_a, b.hi_b, s);
    return Vec2{p.x + hi.x - lo.x, p.y + hi.y - lo.y};
  };
  const Vec2 a{0.5 * (on_lo(0).x + on_hi(0).x), 0.5 * (on_lo(0).y + on_hi(0).y)};
  const Vec2 c{0.5 * (on_lo(1).x + on_hi(1).x), 0.5 * (on_lo(1).y + on_hi(1).y)};
  const double mean = std::hypot(c.x - a.x, c.y - a.y);
  const Vec2 t{(c.x - a.x) / mean, (c.y - a.y) / mean}, n{t.y, -t.x};
  const Vec2 p = on_lo(xi), q = on_hi(xi), m{0.5 * (p.x + q.x), 0.5 * (p.y + q.y)};
  const Vec2 d{q.x - p.x, q.y - p.y};
  const Vec2 arm{m.x - (hi.x - lo.x), m.y - (hi.y - lo.y)};
  const Vec2 v{hi.u - hi.spin * arm.y - lo.u + lo.spin * m.y,
               hi.v + hi.spin * arm.x - lo.v - lo.spin * m.x};
  const double length = std::hypot(b.lo_b.x - b.lo_a.x, b.lo_b.y - b.lo_a.y);
  const double kn = ice.young * b.thickness / b.span, kt = ice.shear * b.thickness / b.span;
  // the share of critical damping of the pair on the whole line, spread over its length
  const double cn = 2.0 * ice.damping * std::sqrt(kn * length * reduced) / length;
  const double ct = 2.0 * ice.damping * std::sqrt(kt * length * reduced) / length;
  const double dn = d.x * n.x + d.y * n.y, dt = d.x * t.x + d.y * t.y;
  const double vn = v.x * n.x + v.y * n.y, vt = v.x * t.x + v.y * t.y;
  const double qn = kn * dn + cn * vn, qt = kt * dt + ct * vt;
  return {m, {qn * n.x + qt * t.x, qn * n.y + qt * t.y}, cn * vn * vn + ct * vt * vt};
}

}  // namespace

TEST_CASE("bond: force and torques are the exact integrals, partly cracked and in mixed mode") {
  Uniform u(1);
  const double reduced = 1.0e10;
  for (int k = 0; k < 60; ++k) {
    BondShape b = intact(u(0.1, 3.0));
    const Body lo = random_body(u, 0, 0, 40), hi = random_body(u, span, 0, 40);
    b.crack_a = k % 3 ? u(0, 0.45) : 0.0;
    b.crack_b = k % 3 == 2 ? u(0, 0.45) : 0.0;
    const BondPose pose = pose_of(lo, hi);
    double watt;
    const PairForce f =
        bond_force(ice, bond_constants(ice, b, 1e6, reduced), b, bond_line(b, pose), pose, watt);
    const double length = 2.0 * half_line;
    const auto sum = [&](const std::function<double(const Point &)> &g) {
      return length * integral([&](double xi) { return g(at(b, lo, hi, reduced, xi)); }, b.xi_lo(),
                               b.xi_hi());
    };
    const double scale = std::hypot(f.f.x, f.f.y);
    CHECK(std::fabs(f.f.x - sum([](const Point &p) { return p.stress.x; })) < 1e-10 * scale);
    CHECK(std::fabs(f.f.y - sum([](const Point &p) { return p.stress.y; })) < 1e-10 * scale);
    const auto about = [](const Point &p, Vec2 c) {
      return cross({p.place.x - c.x, p.place.y - c.y}, p.stress);
    };
    const double lo_torque = sum([&](const Point &p) { return about(p, {0, 0}); });
    const double hi_torque = -sum([&](const Point &p) { return about(p, {pose.d.x, pose.d.y}); });
    CHECK(std::fabs(f.torque_lo - lo_torque) < 1e-10 * scale * span);
    CHECK(std::fabs(f.torque_hi - hi_torque) < 1e-10 * scale * span);
    CHECK(watt == doctest::Approx(sum([](const Point &p) { return p.power; })).epsilon(1e-10));
    // Angular momentum: torques and the couple of the forces cancel.
    const double couple = f.torque_lo + f.torque_hi - cross(pose.d, f.f);
    CHECK(std::fabs(couple) < 1e-14 * scale * span);
  }
}

TEST_CASE("bond: without damping the force is the gradient of the energy") {
  const BondMaterial elastic = bond_material(1.0e9, 0.3, 0.0, 0.1, 0.7);
  Uniform u(2);
  for (int k = 0; k < 20; ++k) {
    BondShape b = intact();
    b.crack_a = 0.3 * u(0, 1);
    Body e[2] = {random_body(u, 0, 0, 300), random_body(u, span, 0, 300)};
    const BondConstants c = bond_constants(elastic, b, 1e6, 1.0);
    const auto energy = [&] {
      return bond_energy(elastic, c, b, bond_line(b, pose_of(e[0], e[1])));
    };
    const BondPose pose = pose_of(e[0], e[1]);
    double watt;
    const PairForce f = bond_force(elastic, c, b, bond_line(b, pose), pose, watt);
    const double scale = std::hypot(f.f.x, f.f.y);
    const auto slope = [&](double &coordinate, double h) {
      const double old = coordinate;
      coordinate = old + h;
      const double up = energy();
      coordinate = old - h;
      const double down = energy();
      coordinate = old;
      return (up - down) / (2.0 * h);
    };
    CHECK(std::fabs(f.f.x + slope(e[0].x, 0.1)) < 1e-8 * scale);
    CHECK(std::fabs(f.f.y + slope(e[0].y, 0.1)) < 1e-8 * scale);
    CHECK(std::fabs(f.torque_lo + slope(e[0].theta, 1e-5)) < 1e-8 * scale * span);
    CHECK(std::fabs(f.torque_hi + slope(e[1].theta, 1e-5)) < 1e-8 * scale * span);
  }
}

TEST_CASE("bond: a rigid motion of the pair makes no force and loses no energy") {
  const BondShape b = intact();
  const double angle = 2.2, w = 3e-5;
  const Body lo{700, -300, angle, 0.3 + w * 300, 0.1 + w * 700, w};
  const Vec2 r{span * std::cos(angle), span * std::sin(angle)};
  const Body hi{lo.x + r.x, lo.y + r.y, angle, lo.u - w * r.y, lo.v + w * r.x, w};
  const BondPose pose = pose_of(lo, hi);
  double watt;
  const BondConstants c = bond_constants(ice, b, 1e6, 1e10);
  const PairForce f = bond_force(ice, c, b, bond_line(b, pose), pose, watt);
  // round-off of positions in the kilometres against a millimetre of stretch
  const double unit = ice.young * c.ratio * c.length * 1e-3;
  CHECK(std::hypot(f.f.x, f.f.y) < 1e-6 * unit);
  CHECK(std::fabs(f.torque_lo) < 1e-6 * unit * span);
  CHECK(watt < 1e-12);
}

TEST_CASE("bond: breaks at the closed-form displacement whatever its thickness") {
  const double compressive = 1.0e6, tensile = 0.1 * compressive;
  // Direction of the displacement and the length at which the envelope is met.
  struct Mode {
    double dx, dy, limit;
  };
  const double shear_rate = ice.shear / ice.tan_phi;
  const Mode modes[] = {
      {1, 0, tensile * span / ice.young},
      {-1, 0, compressive * span / ice.young},
      {0, 1, tensile * span / shear_rate},
      {0, -1, tensile * span / shear_rate},
      {0.6, 0.8, tensile * span / (0.6 * ice.young + 0.8 * shear_rate)},
  };
  for (const Mode &mode : modes) {
    for (const double h : {0.2, 1.0, 3.0}) {
      for (const double share : {1.0 - 1e-9, 1.0 + 1e-9}) {
        BondShape b = intact(h);
        const Body lo{0, 0, 0, 0, 0, 0};
        const Body hi{
            span + mode.dx * mode.limit * share, mode.dy * mode.limit * share, 0, 0, 0, 0};
        const BondConstants c = bond_constants(ice, b, compressive, 1e10);
        const bool failed = bond_fracture(ice, c, bond_line(b, pose_of(lo, hi)), b);
        CHECK(failed == (share > 1.0));
        CHECK(b.broken() == (share > 1.0));
      }
    }
  }
}

TEST_CASE("bond: bending cracks it from the end under tension, to where the limit is met") {
  const double compressive = 1.0e6;
  BondShape b = intact();
  const double angle = 5e-4;  // hi turned: the line opens at one end, closes at the other
  const Body lo{0, 0, 0, 0, 0, 0}, hi{span, 0, angle, 0, 0, 0};
  const BondConstants c = bond_constants(ice, b, compressive, 1e10);
  const BondLine line = bond_line(b, pose_of(lo, hi));
  CHECK(bond_fracture(ice, c, line, b));
  // The shear that the turn about hi's centre brings is part of the envelope.
  const double limit = 0.1 * compressive * span / ice.young - ice.shear_slope * std::fabs(line.dt);
  const double at_limit = 0.5 + (limit - line.dn) / line.dn_slope;
  CHECK(line.dn_slope < 0.0);
  CHECK(b.crack_a == doctest::Approx(at_limit).epsilon(1e-12));
  CHECK(b.crack_b == 0.0);
  const BondShape once = b;
  CHECK_FALSE(bond_fracture(ice, c, line, b));
  CHECK(b.crack_a == once.crack_a);
}

TEST_CASE("bond: what is left is admissible everywhere and nothing admissible was lost") {
  Uniform u(3);
  int partly = 0;
  for (int k = 0; k < 2000; ++k) {
    const double compressive = 1.0e6;
    BondShape b = intact();
    b.crack_a = 0.2 * u(0, 1);
    b.crack_b = 0.2 * u(0, 1);
    const BondShape old = b;
    const Body lo{0, 0, 2e-3 * u(-1, 1), 0, 0, 0};
    const Body hi{span + 2 * u(-1, 1), u(-1, 1), 2e-3 * u(-1, 1), 0, 0, 0};
    const BondLine line = bond_line(b, pose_of(lo, hi));
    bond_fracture(ice, bond_constants(ice, b, compressive, 1e10), line, b);
    partly += !b.broken() && (b.crack_a > old.crack_a || b.crack_b > old.crack_b);
    for (int s = 1; s < 200; ++s) {
      const double xi = old.xi_lo() + (old.xi_hi() - old.xi_lo()) * s / 200.0;
      const double sigma = ice.young / span * (line.dn + (xi - 0.5) * line.dn_slope);
      const double tau = ice.shear / span * std::fabs(line.dt);
      const double tensile = 0.1 * compressive, slack = 1e-6 * compressive;
      const double room = std::min(sigma + compressive, (tensile - sigma) * ice.tan_phi - tau);
      const bool left = !b.broken() && xi >= b.xi_lo() && xi <= b.xi_hi();
      if (left) CHECK(room > -slack);
      if (!left) CHECK(room < slack);
    }
  }
  CHECK(partly > 100);
}

TEST_CASE("bond: Kovacs and Sodhi's strength") {
  CHECK(kovacs_sodhi_strength(1.0) == doctest::Approx(1.285e6));
  CHECK(kovacs_sodhi_strength(8.0) == doctest::Approx(4 * 1.285e6));
}
