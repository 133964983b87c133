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
  double young;        // Pa
  double shear_ratio;  // tangential over normal stiffness
  double damping;      // share of critical damping
  double friction;     // Coulomb coefficient
};

struct ContactPose {
  Vec2 d;           // centre of hi minus centre of lo, m
  double distance;  // |d|, m
  double radius_lo, radius_hi;
  Vec2 v;  // velocity of hi minus velocity of lo, m/s
  double spin_lo, spin_hi;
};

// History of a pair that is in touch, carried from step to step.
struct ContactHistory {
  double slip;          // elastic tangential displacement, m
  double rest_overlap;  // overlap that makes no force, m
};

struct ContactLoss {
  double damping;   // W
  double friction;  // J, over the step
};

// Normal stiffness N/m from the two thicknesses (m): springs of the two elements in series.
inline double contact_stiffness(double young, double h_lo, double h_hi) {
  const double sum = h_lo + h_hi;
  return sum > 0.0 ? young * h_lo * h_hi / sum : 0.0;
}

// Overlap that makes force, m. The rest overlap can only shrink, as the pair separates.
inline double effective_overlap(const ContactPose &p, double &rest_overlap) {
  const double overlap = p.radius_lo + p.radius_hi - p.distance;
  rest_overlap = std::max(0.0, std::min(rest_overlap, overlap));
  return overlap - rest_overlap;
}

// Force on lo and torques; step is the time over which the history advances (0: only evaluate).
template <bool Friction>
inline PairForce contact_force(const ContactMaterial &m, const ContactPose &p, double stiffness,
                               double reduced_mass, double overlap, double step,
                               ContactHistory &history, ContactLoss &loss) {
  const double inv = 1.0 / p.distance;
  const Vec2 n{p.d.x * inv, p.d.y * inv};
  const double vn = p.v.x * n.x + p.v.y * n.y;
  const double critical = 2.0 * m.damping * std::sqrt(stiffness * reduced_mass);
  const double elastic = stiffness * overlap;
  const double fn = std::max(0.0, elastic - critical * vn);
  loss.damping = (elastic - fn) * vn;
  loss.friction = 0.0;
  PairForce out;
  out.f = {-fn * n.x, -fn * n.y};
  out.torque_lo = out.torque_hi = 0.0;
  if constexpr (Friction) {
    // The levers add up to the distance of the centres, else angular momentum would be lost.
    const double share = p.distance / (p.radius_lo + p.radius_hi);
    const double arm_lo = p.radius_lo * share, arm_hi = p.radius_hi * share;
    const double vt = -p.v.x * n.y + p.v.y * n.x - p.spin_lo * arm_lo - p.spin_hi * arm_hi;
    const double kt = m.shear_ratio * stiffness;
    const double limit = m.friction * fn;
    const double cap = kt > 0.0 ? limit / kt : 0.0;
    const double trial = history.slip + vt * step;
    history.slip = std::max(-cap, std::min(trial, cap));
    const double spring = kt * history.slip;
    loss.friction = (trial - history.slip) * spring;
    const double viscous = critical * std::sqrt(m.shear_ratio) * vt;
    const double ft = std::max(-limit, std::min(spring + viscous, limit));
    loss.damping += (ft - spring) * vt;
    out.f.x -= ft * n.y;
    out.f.y += ft * n.x;
    out.torque_lo = arm_lo * ft;
    out.torque_hi = arm_hi * ft;
  }
  return out;
}

}  // namespace floe

#endif
