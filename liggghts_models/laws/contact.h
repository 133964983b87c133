// SPDX-License-Identifier: GPL-2.0-or-later
//
// Law of two unbonded elements in touch: elastic, damped, never attractive, with Coulomb friction.
//
// The history is the elastic slip, capped where the contact slides: it keeps its direction then, and
// evaluating the law again from the stored history gives the same bits (a restart does that).
// See docs/theory/contact.md.
#ifndef FLOE_LAWS_CONTACT_H
#define FLOE_LAWS_CONTACT_H

#include <algorithm>
#include <cmath>

#include "bond.h"

namespace floe {

struct ContactMaterial {
  double young;          // Pa
  double shear_ratio;    // tangential over normal stiffness
  double damping;        // share of critical damping
  double damping_ratio;  // tangential over normal damping: root of shear_ratio
  double friction;       // Coulomb coefficient
};

// Two elements in touch, "one" and "two". The law is symmetric to the bit: exchanging them negates
// the force and changes nothing else, so both sides of a rank boundary agree.
struct ContactPose {
  Vec2 d;           // centre of two minus centre of one, m
  double distance;  // |d|, m
  double radius_one, radius_two;
  Vec2 v;  // velocity of two minus velocity of one, m/s
  double spin_one, spin_two;
};

// What follows from material, thicknesses and masses and stays the same until the ice changes.
struct ContactConstants {
  double stiffness;  // normal, N/m
  double damping;    // normal, N s/m
};

struct ContactLoss {
  double damping;   // W
  double friction;  // J, over the step
};

// Force on one (two takes the opposite) and torques on both.
struct ContactForce {
  Vec2 f;
  double torque_one, torque_two;
};

// Normal stiffness N/m from the two thicknesses (m): springs of the two elements in series.
inline double contact_stiffness(double young, double h_one, double h_two) {
  const double sum = h_one + h_two;
  return sum > 0.0 ? young * (h_one * h_two) / sum : 0.0;
}

inline ContactConstants contact_constants(const ContactMaterial &m, double h_one, double h_two,
                                          double reduced_mass) {
  const double stiffness = contact_stiffness(m.young, h_one, h_two);
  return {stiffness, 2.0 * m.damping * std::sqrt(stiffness * reduced_mass)};
}

// Overlap that makes force, m. The rest overlap can only shrink, as the pair separates.
inline double effective_overlap(const ContactPose &p, double &rest_overlap) {
  const double overlap = (p.radius_one + p.radius_two) - p.distance;
  rest_overlap = std::max(0.0, std::min(rest_overlap, overlap));
  return overlap - rest_overlap;
}

// slip is the history: the elastic tangential displacement, m; step the time over which it advances
// (0: only evaluate). With Ridging the normal force, damping included, stays below the limit (N),
// or at the elastic force where that alone is above it.
template <bool Friction, bool Ridging = false>
inline ContactForce contact_force(const ContactMaterial &m, const ContactConstants &c,
                                  const ContactPose &p, double overlap, double step, double &slip,
                                  ContactLoss &loss, double ridging = 0.0) {
  const double inv = 1.0 / p.distance;
  const Vec2 n{p.d.x * inv, p.d.y * inv};
  const double vn = p.v.x * n.x + p.v.y * n.y;
  const double elastic = c.stiffness * overlap;
  double push = elastic - c.damping * vn;
  // What is not finite must come through: the order of the arguments keeps a NaN.
  if constexpr (Ridging) push = std::min(push, std::max(elastic, ridging));
  const double fn = std::max(push, 0.0);
  loss.damping = (elastic - fn) * vn;
  loss.friction = 0.0;
  if constexpr (!Friction) return {{-fn * n.x, -fn * n.y}, 0.0, 0.0};
  // The levers add up to the distance of the centres, else angular momentum would be lost.
  const double share = p.distance / (p.radius_one + p.radius_two);
  const double arm_one = p.radius_one * share, arm_two = p.radius_two * share;
  const double turning = p.spin_one * arm_one + p.spin_two * arm_two;
  const double vt = (p.v.y * n.x - p.v.x * n.y) - turning;
  const double kt = m.shear_ratio * c.stiffness, limit = m.friction * fn;
  const double trial = slip + vt * step;
  double spring = kt * trial;
  slip = trial;
  if (std::fabs(spring) > limit) {
    slip = std::copysign(limit / kt, trial);
    spring = kt * slip;
    loss.friction = (trial - slip) * spring;
  }
  const double viscous = m.damping_ratio * c.damping * vt;
  const double ft = std::max(std::min(spring + viscous, limit), -limit);
  loss.damping += (ft - spring) * vt;
  return {{-fn * n.x - ft * n.y, -fn * n.y + ft * n.x}, arm_one * ft, arm_two * ft};
}

}  // namespace floe

#endif
