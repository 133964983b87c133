// SPDX-License-Identifier: GPL-2.0-or-later
//
// Friction of grounded ridges on the seabed (Lemieux et al. 2015, doi 10.1002/2014JC010678).
//
// Ice of mean thickness h (volume per area) and concentration A has keels that reach the seabed in
// water of depth D where h > h_c = A D / k1. They hold the ice with at most the stress
// k2 (h - h_c) exp(-C (1 - A)), of which ice that creeps at the speed |u| feels the part
// |u| / (|u| + u0), against its motion.
//
// The stress is taken at the new velocity, together with all other forces: no step is too long for
// it, and the steady state of a step is that of the equations. See docs/theory/forces.md.
#ifndef FLOE_LAWS_SEABED_H
#define FLOE_LAWS_SEABED_H

#include <algorithm>
#include <cmath>

#include "defaults.h"
#include "drag.h"
#include "ice_force.h"

namespace floe {

struct SeabedLaw {
  double keel_ratio;  // k1: depth that a keel reaches over thickness at full cover
  double strength;    // k2, N/m3
  double creep;       // u0, m/s
  double openness;    // C
};

// Largest force (N) with which the seabed can hold an element; 0 where it floats.
// thickness: ice volume over the element's area, m; cover: the share under ice; ice_area, m2; depth, m.
inline double seabed_limit(const SeabedLaw &law, double thickness, double cover, double ice_area,
                           double depth) {
  const double excess = thickness - cover * depth / law.keel_ratio;
  if (!(excess > 0.0) || !(cover > 0.0)) return 0.0;
  return law.strength * excess * std::exp(-law.openness * (1.0 - cover)) * ice_area / cover;
}

// A step of drift_step with that friction. The equations are those of a linear friction against rest
// with the coefficient limit / (|u| + u0); its speed |u| is the only root of a function that changes
// its sign between 0 and the speed without friction.
inline DriftStep grounded_step(const DriftLaw &law, DriftInput in, double limit, double creep,
                               double step) {
  const auto speed_of = [](const DriftStep &out) { return std::hypot(out.u_new.x, out.u_new.y); };
  in.hold = 0.0;
  DriftStep out = drift_step(law, in, step);
  double low = 0.0, high = speed_of(out);
  if (!(limit > 0.0) || !(high > 0.0) || !std::isfinite(high)) return out;
  const auto excess = [&](double speed) {
    in.hold = limit / (speed + creep);
    out = drift_step(law, in, step);
    return speed_of(out) - speed;
  };
  // First guess: the root where nothing else depends on the velocity.
  const double half = 0.5 * (high - creep - step * limit / in.mass);
  const double root = std::sqrt(half * half + high * creep);
  double speed = half > 0.0 ? half + root : high * creep / (root - half);
  double at_low = high, at_high = -high;
  int side = 0;
  for (int k = 0; k < 100; ++k) {
    const double value = excess(speed);
    if (std::fabs(value) <= 1e-13 * speed || high - low <= 1e-15 * high) break;
    // Regula falsi with the Illinois rule; bisection at every fourth step, whatever the curve is.
    if (value > 0.0) {
      low = speed;
      at_low = value;
      if (side > 0) at_high *= 0.5;
      side = 1;
    } else {
      high = speed;
      at_high = value;
      if (side < 0) at_low *= 0.5;
      side = -1;
    }
    speed = k % 4 == 3 ? 0.5 * (low + high) : (low * at_high - high * at_low) / (at_high - at_low);
    speed = std::min(std::max(speed, low), high);
  }
  return out;
}

struct SeabedFriction : HoldForce {
  static constexpr const char *name = "seabed";
  static constexpr bool reads_depth = true;
  static constexpr ForceKeywords keywords{{"keel_ratio", defaults::keel_ratio},
                                          {"seabed_strength", defaults::seabed_strength, true},
                                          {"seabed_creep", defaults::seabed_creep},
                                          {"seabed_openness", defaults::seabed_openness, true}};
  static double limit(const ForceValues &v, const ForceInput &at) {
    return seabed_limit({v[0], v[1], v[2], v[3]}, at.thickness, at.cover, at.drift.area, at.depth);
  }
  static double creep(const ForceValues &v) { return v[2]; }
};

}  // namespace floe

#endif
