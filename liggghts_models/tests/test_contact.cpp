// SPDX-License-Identifier: GPL-2.0-or-later
#include <doctest/doctest.h>

#include <cmath>

#include "linear_contact.h"
#include "random.h"

using namespace floe;

namespace {

ContactMaterial material(double damping = 0.3, double friction = 0.3) {
  return {1.0e8, 0.5, damping, std::sqrt(0.5), friction};
}

ContactPose head_on(double overlap, double closing, double sliding = 0.0) {
  // two lies to the right of one; sliding moves it upwards
  return {{2000.0 - overlap, 0.0}, 2000.0 - overlap, 800.0, 1200.0, {-closing, sliding}, 0.0, 0.0};
}

}  // namespace

TEST_CASE("contact: never attractive, and at rest the spring alone") {
  const ContactMaterial m = material();
  const ContactConstants c = contact_constants(m, 1.0, 2.0, 1e9);
  CHECK(c.stiffness == doctest::Approx(1e8 * 2.0 / 3.0));
  double slip = 0.0;
  ContactLoss loss;
  const ContactForce rest = contact_force<false>(m, c, head_on(2.0, 0.0), 2.0, 0.1, slip, loss);
  CHECK(rest.f.x == doctest::Approx(-2.0 * c.stiffness));
  const ContactForce fleeing = contact_force<false>(m, c, head_on(0.1, -9.0), 0.1, 0.1, slip, loss);
  CHECK(fleeing.f.x == 0.0);
  CHECK(loss.damping >= 0.0);
}

TEST_CASE("contact: seen from the other element, the same bits") {
  const ContactMaterial m = material();
  Uniform u(4);
  for (int k = 0; k < 500; ++k) {
    const double x = u(1, 1000), y = u(-1000, 1000), distance = std::sqrt(x * x + y * y);
    const ContactPose one{
        {x, y},         distance,      u(500, 1000), u(500, 1000), {u(-1, 1), u(-1, 1)},
        u(-1e-3, 1e-3), u(-1e-3, 1e-3)};
    const ContactPose two{
        {-x, -y},     distance,    one.radius_two, one.radius_one, {-one.v.x, -one.v.y},
        one.spin_two, one.spin_one};
    const ContactConstants a = contact_constants(m, 1.3, 0.4, 1e9);
    const ContactConstants b = contact_constants(m, 0.4, 1.3, 1e9);
    CHECK(a.stiffness == b.stiffness);
    double slip_one = u(-1, 1), slip_two = slip_one;
    ContactLoss loss_one, loss_two;
    const ContactForce f = contact_force<true>(m, a, one, 3.0, 0.1, slip_one, loss_one);
    const ContactForce g = contact_force<true>(m, b, two, 3.0, 0.1, slip_two, loss_two);
    CHECK(f.f.x == -g.f.x);
    CHECK(f.f.y == -g.f.y);
    CHECK(f.torque_one == g.torque_two);
    CHECK(f.torque_two == g.torque_one);
    CHECK(slip_one == slip_two);
    CHECK(loss_one.damping == loss_two.damping);
    CHECK(loss_one.friction == loss_two.friction);
  }
}

TEST_CASE("contact: friction is capped, keeps its direction and conserves angular momentum") {
  const ContactMaterial m = material(0.0);
  const ContactConstants c = contact_constants(m, 1.0, 1.0, 1e9);
  double slip = 0.0;
  ContactLoss loss;
  const ContactPose pose = head_on(2.0, 0.0, 0.7);
  ContactForce f{};
  double sum = 0.0, work = 0.0;
  for (int k = 0; k < 400; ++k) {
    const double before = f.f.y;
    f = contact_force<true>(m, c, pose, 2.0, 0.1, slip, loss);
    sum += loss.friction;
    work += 0.07 * 0.5 * (before + f.f.y);
    // two slides upwards and drags one with it, never more than Coulomb's share
    CHECK(f.f.y > 0.0);
    CHECK(f.f.y <= m.friction * -f.f.x * (1 + 1e-15));
  }
  CHECK(f.f.y == doctest::Approx(m.friction * 2.0 * c.stiffness));
  const double stick = m.friction * 2.0 / m.shear_ratio;
  // friction took the work of the force over the whole way but for what the spring holds
  const double spring = 0.5 * m.shear_ratio * c.stiffness * slip * slip;
  CHECK(sum == doctest::Approx(work - spring).epsilon(1e-12));
  CHECK(f.torque_one + f.torque_two - cross(pose.d, f.f) ==
        doctest::Approx(0.0).epsilon(1e-12).scale(f.torque_one));
  // Reversal: the spring unloads from the cap, it does not jump.
  const ContactPose back = head_on(2.0, 0.0, -0.7);
  const ContactForce g = contact_force<true>(m, c, back, 2.0, 0.1, slip, loss);
  CHECK(g.f.y == doctest::Approx(f.f.y - m.shear_ratio * c.stiffness * 0.07));
  for (int k = 0; k < 400; ++k) contact_force<true>(m, c, back, 2.0, 0.1, slip, loss);
  CHECK(slip == doctest::Approx(-stick));
}

TEST_CASE("contact: evaluating again from the stored history gives the same bits") {
  const ContactMaterial m = material();
  Uniform u(5);
  for (int k = 0; k < 500; ++k) {
    const ContactConstants c = contact_constants(m, u(0.1, 3), u(0.1, 3), u(1e8, 1e10));
    const ContactPose pose = head_on(u(0.1, 3), u(-0.1, 0.1), u(-2, 2));
    double slip = u(-3, 3);
    ContactLoss loss;
    const double overlap = 2000.0 - pose.distance;
    const ContactForce f = contact_force<true>(m, c, pose, overlap, 0.1, slip, loss);
    const double stored = slip;
    const ContactForce g = contact_force<true>(m, c, pose, overlap, 0.0, slip, loss);
    CHECK(slip == stored);
    CHECK(f.f.x == g.f.x);
    CHECK(f.f.y == g.f.y);
    CHECK(f.torque_one == g.torque_one);
  }
}

TEST_CASE("contact: rest overlap makes no force and goes as the pair separates") {
  double rest = 3.0;
  CHECK(effective_overlap(head_on(3.0, 0.0), rest) == 0.0);
  CHECK(effective_overlap(head_on(5.0, 0.0), rest) == 2.0);
  CHECK(rest == 3.0);
  CHECK(effective_overlap(head_on(1.0, 0.0), rest) == 0.0);
  CHECK(rest == 1.0);
  CHECK(effective_overlap(head_on(3.0, 0.0), rest) == 2.0);
  CHECK(effective_overlap(head_on(-2.0, 0.0), rest) < 0.0);
  CHECK(rest == 0.0);
}

TEST_CASE("contact: restitution of the tension-free damped spring") {
  // Schwager & Poeschel 2007, doi 10.1007/s10035-007-0065-z
  for (const double damping : {0.05, 0.2, 0.5}) {
    const ContactMaterial m = material(damping);
    const double mass = 1e9;
    const ContactConstants c = contact_constants(m, 1.0, 1.0, mass);
    const double w0 = std::sqrt(c.stiffness / mass), beta = damping * w0;
    const double w = std::sqrt(w0 * w0 - beta * beta);
    const double angle = std::atan2(2.0 * beta * w, w * w - beta * beta);
    const double expected = std::exp(-beta / w * (M_PI - angle));
    const double step = 1e-5 / w0;
    double gap = 0.0, speed = -1.0, slip = 0.0;  // of the pair's distance
    ContactLoss loss;
    do {
      const ContactPose pose = head_on(-gap, -speed);
      const ContactForce f = contact_force<false>(m, c, pose, -gap, step, slip, loss);
      speed -= step * f.f.x / mass;
      gap += step * speed;
    } while (gap < 0.0 && !(speed > 0.0 && c.stiffness * -gap <= c.damping * speed));
    CHECK(speed == doctest::Approx(expected).epsilon(1e-4));
  }
}
