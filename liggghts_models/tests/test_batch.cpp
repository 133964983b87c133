// SPDX-License-Identifier: GPL-2.0-or-later
//
// The loops over several pairs at once against the laws taken one pair at a time: the same bits, for
// any number of pairs, so also where the last pack is not full.
#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "bond_batch.h"
#include "contact_batch.h"
#include "load_rows.h"
#include "random.h"

using namespace floe;

namespace {

constexpr double reduced = 1e10, step = 2.0;

// Pairs of discs, 2k and 2k + 1, each pair alone: an element's load is that of one pair.
std::vector<Body> bodies_of(Uniform &u, int pairs, double apart, double size) {
  std::vector<Body> out;
  for (int k = 0; k < 2 * pairs; ++k) {
    const double angle = 1e-3 * size * u(-1, 1), x = k % 2 ? apart + size * u(-1, 1) : 0.0;
    out.push_back({x, size * u(-1, 1), u(-1, 1), u(-1, 1), 1e-4 * u(-1, 1), std::cos(angle),
                   std::sin(angle), u(0.49, 0.55) * apart});
  }
  return out;
}

bool same(const Load &a, double fx, double fy, double torque) {
  return a.fx == fx && a.fy == fy && a.torque == torque && a.ridged == 0.0;
}

template <typename Law, bool Friction, Damping Damp, bool Exact>
void compare_contacts(int count, unsigned seed) {
  CAPTURE(count);
  Uniform u(seed);
  ContactMaterial m{1e8, 0.5, 0.3, std::sqrt(0.5), 0.3};
  for (int k = 0; k < law_keywords; ++k) m.own[k] = Law::keywords[k].value;
  std::vector<Body> bodies = bodies_of(u, count, 1000.0, 20.0);
  // The last element of all is a ghost: its pair counts by half.
  const int nlocal = 2 * count - 1;
  ContactRecords records;
  std::vector<int> touching;
  for (int k = 0; k < count; ++k) {
    records.ends.push_back({2 * k, (2 * k + 1) | Ends::mark});
    const double stiffness = Law::stiffness(m, {500.0, u(0.1, 3)}, {500.0, u(0.1, 3)});
    records.rows.push_back({u(-0.1, 0.1), k % 3 ? 0.0 : u(0, 100), stiffness,
                            contact_damping(m, stiffness, reduced, step)});
    touching.push_back(k);
  }
  touching.resize(count + 3);
  std::vector<Load> loads(2 * count * (Exact ? 2 : 1)), damped(2 * count);
  const LongArray<ContactRow> before = records.rows;
  const ContactTask task{m,
                         nullptr,
                         step,
                         true,
                         nlocal,
                         bodies.data(),
                         loads.data(),
                         damped.data(),
                         records.ends.data(),
                         records.rows.data(),
                         nullptr,
                         nullptr};
  ContactSums sums;
  evaluate_contacts<ContactTerms<Friction, false, Damp, Exact, Law>>(task, touching.data(), count,
                                                                     sums);
  double damping = 0.0, friction = 0.0;
  int idle = 0;
  for (int k = 0; k < count; ++k) {
    CAPTURE(k);
    const Body &one = bodies[2 * k], &two = bodies[2 * k + 1];
    const Vec2 d{two.x - one.x, two.y - one.y};
    const ContactPose pose{d,          std::sqrt(d.x * d.x + d.y * d.y), one.radius,
                           two.radius, {two.u - one.u, two.v - one.v},   one.spin,
                           two.spin};
    double slip = before[k].slip, rest = before[k].rest;
    const double overlap = effective_overlap(pose, rest);
    const double share = 2 * k + 1 < nlocal ? 1.0 : 0.5;
    ContactLoss loss;
    const ContactConstants c =
        Law::at(ContactConstants{before[k].stiffness, before[k].damping}, overlap);
    const ContactForce force = contact_force<Friction, false, Damp != Damping::none>(
        m, c, pose, overlap, step, slip, loss);
    const Load &a = *reinterpret_cast<Load *>(load_row<Exact>(loads.data(), 2 * k));
    const Load &b = *reinterpret_cast<Load *>(load_row<Exact>(loads.data(), 2 * k + 1));
    if (!(overlap > 0.0)) {
      ++idle;
      CHECK(same(a, 0.0, 0.0, 0.0));
      CHECK(same(b, 0.0, 0.0, 0.0));
      CHECK(records.rows[k].slip == (Friction ? 0.0 : before[k].slip));
      continue;
    }
    damping += share * loss.damping;
    friction += share * loss.friction;
    CHECK(records.rows[k].slip == (Friction ? slip : before[k].slip));
    CHECK(records.rows[k].rest == rest);
    if constexpr (Exact) {
      // Both rows together are the force, but for what lies below the fine grid.
      CHECK(std::fabs(a.fx + (&a)[1].fx - force.f.x) <= 0x1p-55);
      CHECK(std::fabs(b.fy + (&b)[1].fy + force.f.y) <= 0x1p-55);
    } else {
      CHECK(same(a, force.f.x, force.f.y, force.torque_one));
      CHECK(same(b, -force.f.x, -force.f.y, force.torque_two));
    }
  }
  if (count > 20) CHECK((idle > 0 && idle < count));
  if (Damp == Damping::counted) CHECK(sums.damping.total() == doctest::Approx(damping));
  if (Friction) CHECK(sums.friction.total() == doctest::Approx(friction));
}

template <typename Law, Damping Damp, bool Exact>
void compare_bonds(int count, unsigned seed) {
  CAPTURE(count);
  Uniform u(seed);
  constexpr double span = 5000.0, half = 1500.0;
  BondMaterial m = bond_material(1e9, 0.3, Damp == Damping::none ? 0.0 : 0.1, 0.1, 0.7);
  for (int k = 0; k < law_keywords; ++k) m.own[k] = Law::keywords[k].value;
  const std::vector<Body> bodies = bodies_of(u, count, span, 0.5);
  BondRecords records;
  std::vector<BondShape> shapes;
  for (int k = 0; k < count; ++k) {
    const double mid = 0.5 * span, crack = k % 4 == 3 ? u(0, 0.5) : 0.0;
    shapes.push_back(
        {{mid, -half}, {mid, half}, {-mid, -half}, {-mid, half}, span, u(0.5, 2), crack, 0.0});
    records.add(2 * k, 2 * k + 1, k % 5 == 4 ? 0.5 : 1.0, shapes[k],
                bond_constants(m, shapes[k], 1e6, reduced), {});
  }
  if (count > 2) records.remove(1);
  std::vector<Load> loads(2 * count * (Exact ? 2 : 1)), damped(2 * count);
  // The first pair is out of reach.
  std::vector<Body> placed = bodies;
  placed[0].radius = placed[1].radius = 0.4 * span;
  std::vector<int> odd;
  const BondTask task{m, 1.1 * 1.1, true, placed.data(), loads.data(), damped.data()};
  const double power = evaluate_bonds<Law, Damp, Exact>(task, records, odd);
  double lost = 0.0;
  std::vector<int> expected;
  for (int k = 0; k < count; ++k) {
    CAPTURE(k);
    if (k == 1 && count > 2) continue;
    const Body &lo = placed[2 * k], &hi = placed[2 * k + 1];
    const BondPose pose{{hi.x - lo.x, hi.y - lo.y}, {lo.cos, lo.sin}, {hi.cos, hi.sin},
                        {hi.u - lo.u, hi.v - lo.v}, lo.spin,          hi.spin};
    const BondConstants c = bond_constants(m, shapes[k], 1e6, reduced);
    const BondLine line = bond_line(shapes[k], pose);
    const double sum = lo.radius + hi.radius, square = pose.d.x * pose.d.x + pose.d.y * pose.d.y;
    const Load &a = *reinterpret_cast<Load *>(load_row<Exact>(loads.data(), 2 * k));
    const Load &b = *reinterpret_cast<Load *>(load_row<Exact>(loads.data(), 2 * k + 1));
    if (!Law::holds(m, c, line, shapes[k]) || square > task.limit2 * sum * sum) {
      expected.push_back(k);
      CHECK(same(a, 0.0, 0.0, 0.0));
      CHECK(same(b, 0.0, 0.0, 0.0));
      continue;
    }
    double watt = 0.0;
    const PairForce force =
        Law::template force<Damp != Damping::none>(m, c, shapes[k], line, pose, watt);
    lost += records.share(k) * watt;
    if constexpr (Exact) {
      CHECK(std::fabs(a.fx + (&a)[1].fx - force.f.x) <= 0x1p-55);
    } else {
      CHECK(same(a, force.f.x, force.f.y, force.torque_lo));
      CHECK(same(b, -force.f.x, -force.f.y, force.torque_hi));
    }
  }
  CHECK(odd == expected);
  CHECK(odd.front() == 0);
  if (count > 20) CHECK(static_cast<int>(odd.size()) < count - 5);
  if (Damp == Damping::counted) CHECK(power == doctest::Approx(lost));
}

}  // namespace

TEST_CASE("batches of contacts: the bits of one at a time") {
  ContactLaws::each([](auto law) {
    using Law = decltype(law);
    CAPTURE(std::string(Law::name));
    for (const int count : {1, 2, 3, 4, 5, 7, 8, 61}) {
      compare_contacts<Law, true, Damping::counted, false>(count, 21);
      compare_contacts<Law, false, Damping::none, false>(count, 22);
      compare_contacts<Law, true, Damping::exact, true>(count, 23);
    }
  });
}

TEST_CASE("batches of bonds: the bits of one at a time, and what does not hold given back") {
  BondLaws::each([](auto law) {
    using Law = decltype(law);
    CAPTURE(std::string(Law::name));
    for (const int count : {1, 2, 3, 4, 5, 7, 8, 61}) {
      compare_bonds<Law, Damping::counted, false>(count, 31);
      compare_bonds<Law, Damping::none, false>(count, 32);
      compare_bonds<Law, Damping::exact, true>(count, 33);
    }
  });
}

TEST_CASE("records of bonds: what goes in comes out, in every lane") {
  BondRecords records;
  for (int k = 0; k < 6; ++k) {
    const double a = 10.0 * k;
    const BondShape shape{
        {a, a + 1}, {a + 2, a + 3}, {a + 4, a + 5}, {a + 6, a + 7}, 100.0, 1.0, k == 4 ? 0.2 : 0.0,
        0.0};
    records.add(k, k + 10, k == 5 ? 0.5 : 1.0, shape, {a + 0.1, a + 0.2, a + 0.3, a + 0.4}, {});
  }
  using B = BondBlock;
  CHECK(records.count == 6);
  for (int k = 0; k < 6; ++k) {
    const double a = 10.0 * k;
    const double wanted[] = {a, a + 1, a + 2, a + 3, a + 4, a + 5, a + 6, a + 7};
    const B::Column columns[] = {B::lo_ax, B::lo_ay, B::lo_bx, B::lo_by,
                                 B::hi_ax, B::hi_ay, B::hi_bx, B::hi_by};
    for (int c = 0; c < 8; ++c) CHECK(records.at(columns[c], k) == wanted[c]);
    CHECK(records.at(B::length, k) == a + 0.1);
    CHECK(records.at(B::ratio, k) == a + 0.2);
    CHECK(records.at(B::damping, k) == a + 0.3);
    CHECK(records.at(B::squeeze, k) == a + 0.4);
    CHECK(records.share(k) == (k == 5 ? 0.5 : 1.0));
    CHECK(records.crack_a(k) == (k == 4 ? 0.2 : 0.0));
    CHECK((records.block(k).lo[k & 3] == k && records.block(k).hi[k & 3] == k + 10));
  }
  CHECK((records.plain[0] && !records.plain[1]));
  records.crack(2, 0.5, 0.1);
  CHECK((!records.plain[0] && records.crack_b(2) == 0.1 && records.crack_b(3) == 0.0));
}
