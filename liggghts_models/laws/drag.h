// SPDX-License-Identifier: GPL-2.0-or-later
//
// One step of an element's velocity and spin under contact forces, wind, ocean drag, Coriolis force
// and sea-surface tilt.
//
// All terms share one implicit solve: ocean drag is taken fully at the new time (a scalar Newton for
// the new speed relative to the water), the Coriolis force at the mean of old and new velocity (a
// rotation that keeps the speed). The steady state of the step is the steady state of the equations,
// for any step and any thickness. Complex numbers stand for vectors: i u is u turned left.
// See docs/theory/forces.md.
#ifndef FLOE_LAWS_DRAG_H
#define FLOE_LAWS_DRAG_H

#include <cmath>

#include "bond.h"

namespace floe {

struct DriftInput {
  Vec2 u;            // velocity, m/s
  Vec2 contact;      // sum of contact forces, N
  double mass;       // kg
  double area;       // ice area that wind and ocean act on, m2
  Vec2 wind, ocean;  // velocities of air and water, m/s
  double coriolis;   // parameter f, 1/s
  double hold = 0;   // linear friction against rest, N s/m (seabed.h)
};

struct DriftLaw {
  bool use_wind, relative_wind, use_ocean, use_coriolis, use_tilt;
  double air;    // rho_a C_a, kg/m3
  double water;  // rho_w C_w, kg/m3
  // Turning angle of the ocean drag where f > 0; where f < 0 it turns the other way.
  double cos_turn, sin_turn;
};

// New velocity and the impulse (N s) of each term over the step; they add up to mass (u_new - u).
struct DriftStep {
  Vec2 u_new, wind, ocean, coriolis, tilt, seabed;
};

// Root s >= 0 of s |alpha + i q + gamma s e^{i turn}| = b: the speed relative to the water.
inline double drag_speed(double alpha, double q, double gamma, double cos_turn, double sin_turn,
                         double b) {
  if (b <= 0.0) return 0.0;
  const double a2 = alpha * alpha + q * q;
  const double a3 = 2.0 * gamma * (alpha * cos_turn + q * sin_turn), a4 = gamma * gamma;
  // Exact where the turning angle and the Coriolis parameter vanish.
  const double guess = std::sqrt(a2);
  double s = 2.0 * b / (guess + std::sqrt(a2 + 4.0 * gamma * b));
  for (int k = 0; k < 40; ++k) {
    const double value = s * s * (a2 + s * (a3 + s * a4)) - b * b;
    const double slope = s * (2.0 * a2 + s * (3.0 * a3 + s * 4.0 * a4));
    if (!(slope > 0.0)) {  // left of the minimum, possible only for turning angles above 90 degrees
      s *= 2.0;
      continue;
    }
    const double change = value / slope;
    s -= change;
    if (s <= 0.0) s = 0.5 * (s + change);
    if (std::fabs(change) <= 4e-16 * s) break;
  }
  return s;
}

inline DriftStep drift_step(const DriftLaw &law, const DriftInput &in, double step) {
  const double per_mass = step / in.mass;
  DriftStep out{};
  Vec2 rhs{per_mass * in.contact.x, per_mass * in.contact.y};  // step times acceleration
  double alpha = 1.0, wind_rate = 0.0;
  if (law.use_wind) {
    const Vec2 w{in.wind.x - (law.relative_wind ? in.u.x : 0.0),
                 in.wind.y - (law.relative_wind ? in.u.y : 0.0)};
    const double c = per_mass * in.area * law.air * std::sqrt(w.x * w.x + w.y * w.y);
    rhs.x += c * w.x;
    rhs.y += c * w.y;
    if (law.relative_wind) {  // linear in the new velocity, so that thin ice stays stable
      wind_rate = c;
      alpha += c;
    } else {
      out.wind = {in.mass * c * w.x, in.mass * c * w.y};
    }
  }
  const double held = per_mass * in.hold;
  const double q = law.use_coriolis || law.use_tilt ? 0.5 * step * in.coriolis : 0.0;
  const double q_coriolis = law.use_coriolis ? q : 0.0;
  if (law.use_tilt) {
    rhs.x -= 2.0 * q * in.ocean.y;
    rhs.y += 2.0 * q * in.ocean.x;
    out.tilt = {-2.0 * q * in.mass * in.ocean.y, 2.0 * q * in.mass * in.ocean.x};
  }
  rhs.x += 2.0 * q_coriolis * in.u.y;
  rhs.y -= 2.0 * q_coriolis * in.u.x;
  // Without friction against rest the change of velocity is rhs / (re + i im). With it the new
  // velocity is (still + drag ocean) / (re + i im): nothing large is subtracted where ice is held.
  double re = alpha + held, im = q_coriolis;
  const Vec2 still{rhs.x + alpha * in.u.x - q_coriolis * in.u.y,
                   rhs.y + alpha * in.u.y + q_coriolis * in.u.x};
  Vec2 w0{0.0, 0.0};
  double drag_re = 0.0, drag_im = 0.0;
  if (law.use_ocean) {
    w0 = {in.u.x - in.ocean.x, in.u.y - in.ocean.y};
    const double gamma = per_mass * in.area * law.water;
    const Vec2 b{rhs.x + w0.x * alpha - w0.y * q_coriolis - held * in.ocean.x,
                 rhs.y + w0.y * alpha + w0.x * q_coriolis - held * in.ocean.y};
    const double sin_turn = in.coriolis < 0.0 ? -law.sin_turn : law.sin_turn;
    const double s =
        drag_speed(re, q_coriolis, gamma, law.cos_turn, sin_turn, std::sqrt(b.x * b.x + b.y * b.y));
    drag_re = gamma * s * law.cos_turn;
    drag_im = gamma * s * sin_turn;
    rhs.x -= drag_re * w0.x - drag_im * w0.y;
    rhs.y -= drag_re * w0.y + drag_im * w0.x;
    re += drag_re;
    im += drag_im;
  }
  const double inv = 1.0 / (re * re + im * im);
  Vec2 du{(rhs.x * re + rhs.y * im) * inv, (rhs.y * re - rhs.x * im) * inv};
  out.u_new = {in.u.x + du.x, in.u.y + du.y};
  const double m = in.mass;
  if (held > 0.0) {
    const Vec2 sum{still.x + drag_re * in.ocean.x - drag_im * in.ocean.y,
                   still.y + drag_re * in.ocean.y + drag_im * in.ocean.x};
    out.u_new = {(sum.x * re + sum.y * im) * inv, (sum.y * re - sum.x * im) * inv};
    out.seabed = {-m * held * out.u_new.x, -m * held * out.u_new.y};
    du = {out.u_new.x - in.u.x, out.u_new.y - in.u.y};
  }
  if (law.use_wind && law.relative_wind) {
    out.wind = {m * wind_rate * (in.wind.x - in.u.x - du.x),
                m * wind_rate * (in.wind.y - in.u.y - du.y)};
  }
  if (law.use_coriolis) {
    const Vec2 mean{in.u.x + 0.5 * du.x, in.u.y + 0.5 * du.y};
    out.coriolis = {2.0 * q * m * mean.y, -2.0 * q * m * mean.x};
  }
  if (law.use_ocean) {
    const Vec2 w{w0.x + du.x, w0.y + du.y};  // of the new velocity against the water
    out.ocean = {-m * (drag_re * w.x - drag_im * w.y), -m * (drag_re * w.y + drag_im * w.x)};
  }
  return out;
}

// New spin of a disc (inertia m r^2 / 2) under a torque (N m) alone; per_mass is step / mass.
inline double free_spin_step(double spin, double torque, double per_mass, double radius) {
  return spin + per_mass * torque / (0.5 * radius * radius);
}

// The same with the rotational drag
// (2/5) A rho_w C_w r^3 |dw| dw against half the current's vorticity; drag at the new time.
inline double spin_step(bool use_ocean, double water, double spin, double torque, double mass,
                        double radius, double area, double vorticity, double step) {
  const double free_spin = free_spin_step(spin, torque, step / mass, radius);
  if (!use_ocean) return free_spin;
  const double gamma = 0.8 * step / mass * area * water * radius;
  const double y0 = 0.5 * vorticity - free_spin;
  // y (1 + gamma |y|) = y0, solved without cancellation
  return 0.5 * vorticity - 2.0 * y0 / (1.0 + std::sqrt(1.0 + 4.0 * gamma * std::fabs(y0)));
}

}  // namespace floe

#endif
