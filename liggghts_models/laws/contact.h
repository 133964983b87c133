// SPDX-License-Identifier: GPL-2.0-or-later
//
// What all laws of contact share: two unbonded elements in touch, elastic, damped, never attractive,
// with Coulomb friction. How stiff they are is the law's (linear_contact.h, hertz_contact.h).
//
// The history is the elastic slip, capped where the contact slides: it keeps its direction then, and
// evaluating the law again from the stored history gives the same bits (a restart does that).
// See docs/theory/contact.md.
#ifndef FLOE_LAWS_CONTACT_H
#define FLOE_LAWS_CONTACT_H

#include <cmath>

#include "bond.h"

namespace floe {

struct ContactMaterial {
  double young;          // Pa
  double shear_ratio;    // tangential over normal stiffness
  double damping;        // share of critical damping
  double damping_ratio;  // tangential over normal damping: root of shear_ratio
  double friction;       // Coulomb coefficient
  double poisson = 0.3;
  double own[law_keywords] = {};  // the law's own keywords, in their order
  int law = 0;                    // its place among ContactLaws (laws.h)
};

// What an element brings to the stiffness of its contacts.
struct ContactSide {
  double radius, thickness;  // m
};

// Two elements in touch, "one" and "two". The law is symmetric to the bit: exchanging them negates
// the force and changes nothing else, so both sides of a rank boundary agree.
template <typename T>
struct ContactPoseOf {
  VectorOf<T> d;  // centre of two minus centre of one, m
  T distance;     // |d|, m
  T radius_one, radius_two;
  VectorOf<T> v;  // velocity of two minus velocity of one, m/s
  T spin_one, spin_two;
};
using ContactPose = ContactPoseOf<double>;

// What follows from material, thicknesses and masses and stays the same until the ice changes.
// Of a law whose stiffness is not constant: at an overlap of 1 m.
template <typename T>
struct ContactConstantsOf {
  T stiffness;  // normal, N/m
  T damping;    // normal, N s/m
};
using ContactConstants = ContactConstantsOf<double>;

template <typename T>
struct ContactLossOf {
  T damping;          // W
  T friction;         // J, over the step
  T normal, tangent;  // N, what damping adds to the push and to the tangential force
};
using ContactLoss = ContactLossOf<double>;

// Force on one (two takes the opposite) and torques on both.
template <typename T>
struct ContactForceOf {
  VectorOf<T> f;
  T torque_one, torque_two;
};
using ContactForce = ContactForceOf<double>;

// Damping takes at most this share of the relative velocity of a pair in a step: however many small
// neighbours an element has, what they take in a step then adds up to a share of its own momentum,
// and the stable step does not shrink with their number.
constexpr double damping_per_step = 0.1;

// Normal damping N s/m; step (s) bounds it, 0: no bound.
inline double contact_damping(const ContactMaterial &m, double stiffness, double reduced_mass,
                              double step) {
  const double wanted = 2.0 * m.damping * std::sqrt(stiffness * reduced_mass);
  return step > 0.0 ? std::fmin(wanted, damping_per_step * reduced_mass / step) : wanted;
}

// A law of contacts says how stiff two elements are to each other (see laws.h); friction, damping,
// ridging and losses are those below for all:
//   name                           of the keyword contact_law
//   constant                       whether stiffness is the same at every overlap: only then ridges can
//                                  close, and damping is bounded by the step
//   stiffness(m, one, two)         normal, N/m, at an overlap of 1 m
//   wall_stiffness(m, one)         against a rigid wall
//   at(constants, overlap)         constants at an elastic overlap (m); T is double or Pack
//   energy(stiffness, overlap, shear)  elastic, J; shear: shear_ratio slip^2, m2

// Overlap that makes force, m. The rest overlap can only shrink, as the pair separates.
template <typename T>
FLOE_INLINE T effective_overlap(const ContactPoseOf<T> &p, T &rest_overlap) {
  const T overlap = (p.radius_one + p.radius_two) - p.distance;
  rest_overlap = larger(T{}, smaller(rest_overlap, overlap));
  return overlap - rest_overlap;
}

// With Friction, Ridging or Damped off their terms are not there, in the code either.
// slip is the history: the elastic tangential displacement, m; step the time over which it advances
// (0: only evaluate). With Ridging the normal force, damping included, stays below the limit (N),
// or at the elastic force where that alone is above it.
template <bool Friction, bool Ridging = false, bool Damped = true, typename T>
FLOE_INLINE ContactForceOf<T> contact_force(const ContactMaterial &m,
                                            const ContactConstantsOf<T> &c,
                                            const ContactPoseOf<T> &p, T overlap, double step,
                                            T &slip, ContactLossOf<T> &loss, T ridging = T{}) {
  const T inv = 1.0 / p.distance, none{};
  const VectorOf<T> n{p.d.x * inv, p.d.y * inv};
  const T elastic = c.stiffness * overlap;
  T push = elastic, vn{};
  if constexpr (Damped) {
    vn = p.v.x * n.x + p.v.y * n.y;
    push = elastic - c.damping * vn;
  }
  // What is not finite must come through: the order of the arguments keeps a NaN.
  if constexpr (Ridging) push = smaller(push, larger(elastic, ridging));
  const T fn = larger(push, none);
  loss.normal = fn - elastic;
  loss.damping = Damped ? -loss.normal * vn : none;
  loss.friction = loss.tangent = none;
  if constexpr (!Friction) return {{-fn * n.x, -fn * n.y}, none, none};
  // The levers add up to the distance of the centres, else angular momentum would be lost.
  const T share = p.distance / (p.radius_one + p.radius_two);
  const T arm_one = p.radius_one * share, arm_two = p.radius_two * share;
  const T turning = p.spin_one * arm_one + p.spin_two * arm_two;
  const T vt = (p.v.y * n.x - p.v.x * n.y) - turning;
  const T kt = m.shear_ratio * c.stiffness, limit = m.friction * fn;
  const T before = slip, trial = slip + vt * step;
  slip = trial;
  if (any(magnitude(kt * trial) > limit)) {
    const auto slides = magnitude(kt * trial) > limit;
    const T cap = limit / kt;
    slip = slides ? (trial < none ? -cap : cap) : trial;
    // Force before and after: their mean over the way that was slid.
    loss.friction = slides ? (trial - slip) * (kt * 0.5 * (before + slip)) : none;
  }
  T ft = kt * slip;
  if constexpr (Damped) {
    const T viscous = m.damping_ratio * c.damping * vt, spring = ft;
    ft = larger(smaller(spring + viscous, limit), -limit);
    loss.tangent = ft - spring;
    loss.damping += loss.tangent * vt;
  }
  return {{-fn * n.x - ft * n.y, -fn * n.y + ft * n.x}, arm_one * ft, arm_two * ft};
}

}  // namespace floe

#endif
