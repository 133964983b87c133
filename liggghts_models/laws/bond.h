// SPDX-License-Identifier: GPL-2.0-or-later
//
// Law of a bond: a line of frozen water ("glue line") between two discs of ice.
//
// Why it looks like this: the displacement between the two sides of the line follows from the
// positions of the elements alone (the line's ends are stored in the body frame of either element),
// so nothing drifts, and a state read from a file continues exactly. Every integral has a closed
// form because the displacement is linear along the line. See docs/theory/contact.md.
// After Hopkins, Frankenstein & Thorndike (2004), doi 10.1029/2003JC001855.
#ifndef FLOE_LAWS_BOND_H
#define FLOE_LAWS_BOND_H

#include <algorithm>
#include <cmath>

namespace floe {

struct Vec2 {
  double x, y;
};

inline double cross(Vec2 a, Vec2 b) { return a.x * b.y - a.y * b.x; }

// What both elements of a pair bring to a bond. "lo" is the element with the lower id.
struct BondPose {
  Vec2 d;                   // centre of hi minus centre of lo, m
  Vec2 turn_lo, turn_hi;    // cosine and sine of the orientations
  Vec2 v;                   // velocity of hi minus velocity of lo, m/s
  double spin_lo, spin_hi;  // rad/s
};

// The bond as stored: ends a (xi = 0) and b (xi = 1) of the line in the body frames of lo and hi (m).
// Looking from a to b, lo lies on the left: the normal then points from lo to hi.
struct BondShape {
  Vec2 lo_a, lo_b, hi_a, hi_b;
  double span;                              // distance of the centres at rest, m
  double thickness;                         // m
  double crack_a, crack_b;                  // cracked share of the line, from end a and from end b
  double xi_lo() const { return crack_a; }  // the uncracked part lies between xi_lo and xi_hi
  double xi_hi() const { return 1.0 - crack_b; }
  // What is left of the line is compared with round-off of its ends, which are near 1.
  bool broken() const { return !(crack_a + crack_b < 1.0 - 1e-12); }
};

struct BondMaterial {
  double young;                   // Pa
  double shear;                   // shear modulus, Pa
  double damping;                 // share of critical damping
  double tensile_share;           // tensile over compressive strength
  double tan_phi;                 // tangent of the angle of internal friction
  double root_young, root_shear;  // roots of the moduli
  double shear_slope;             // shear / (young tan_phi)
};

inline BondMaterial bond_material(double young, double poisson, double damping,
                                  double tensile_share, double tan_phi) {
  const double shear = young / (2.0 * (1.0 + poisson));
  return {young,
          shear,
          damping,
          tensile_share,
          tan_phi,
          std::sqrt(young),
          std::sqrt(shear),
          shear / (young * tan_phi)};
}

// What follows from shape, material and masses and stays the same until the ice changes.
struct BondConstants {
  double length;   // of the glue line, m
  double ratio;    // thickness over span; times a modulus: stiffness per length, Pa
  double damping;  // times the root of a modulus: damping per length, Pa s
  double squeeze;  // normal displacement at which the line crushes, m
};

// Where the line is now: frame, displacement along it, and arms of the midline's centre.
struct BondLine {
  Vec2 n, t;            // normal (lo to hi) and tangent (a to b)
  double length;        // length of the line in its body frame, m
  double mean_length;   // length of the midline, m
  double dn, dn_slope;  // normal displacement at xi = 1/2 and its change over the line, m
  double dt;            // tangential displacement (the same along the line), m
  Vec2 arm_lo, arm_hi;  // from the centres of lo and hi to the centre of the midline, m
};

// Force and torque on lo; hi takes -force, and its own torque.
struct PairForce {
  Vec2 f;
  double torque_lo, torque_hi;
};

// compressive: compressive strength, Pa; reduced_mass of the pair, kg.
inline BondConstants bond_constants(const BondMaterial &m, const BondShape &b, double compressive,
                                    double reduced_mass) {
  BondConstants out;
  out.length = std::hypot(b.lo_b.x - b.lo_a.x, b.lo_b.y - b.lo_a.y);
  out.ratio = b.thickness / b.span;
  out.damping = 2.0 * m.damping * std::sqrt(reduced_mass * out.ratio / out.length);
  out.squeeze = compressive / m.young * b.span;
  return out;
}

inline BondLine bond_line(const BondShape &b, const BondPose &p) {
  const auto turn = [](Vec2 q, Vec2 a) {
    return Vec2{q.x * a.x - q.y * a.y, q.y * a.x + q.x * a.y};
  };
  const Vec2 la = turn(p.turn_lo, b.lo_a), lb = turn(p.turn_lo, b.lo_b);
  const Vec2 ha = turn(p.turn_hi, b.hi_a), hb = turn(p.turn_hi, b.hi_b);
  const Vec2 line_lo{lb.x - la.x, lb.y - la.y}, line_hi{hb.x - ha.x, hb.y - ha.y};
  const Vec2 sum{line_lo.x + line_hi.x, line_lo.y + line_hi.y};
  const double norm = std::sqrt(sum.x * sum.x + sum.y * sum.y);
  BondLine out;
  const double inv = 1.0 / norm;
  out.t = {sum.x * inv, sum.y * inv};
  out.n = {out.t.y, -out.t.x};
  out.mean_length = 0.5 * norm;
  const Vec2 mid_lo{0.5 * (la.x + lb.x), 0.5 * (la.y + lb.y)};
  const Vec2 mid_hi{0.5 * (ha.x + hb.x), 0.5 * (ha.y + hb.y)};
  const Vec2 dm{p.d.x + (mid_hi.x - mid_lo.x), p.d.y + (mid_hi.y - mid_lo.y)};
  const Vec2 dd{line_hi.x - line_lo.x, line_hi.y - line_lo.y};
  out.dn = dm.x * out.n.x + dm.y * out.n.y;
  out.dt = dm.x * out.t.x + dm.y * out.t.y;
  // Both lines have the same length, so their difference is normal to their sum: dt has no slope.
  out.dn_slope = dd.x * out.n.x + dd.y * out.n.y;
  out.arm_lo = {mid_lo.x + 0.5 * dm.x, mid_lo.y + 0.5 * dm.y};
  out.arm_hi = {mid_hi.x - 0.5 * dm.x, mid_hi.y - 0.5 * dm.y};
  return out;
}

// Lets the cracks run until the stress is admissible all along the rest of the line: tension
// cut-off, compression cut-off and Mohr-Coulomb |tau| <= cohesion - sigma tan(phi) (sigma > 0 is
// tension), whose tip lies at the tensile strength: cohesion = tensile tan(phi). The displacement does not depend on what has failed, the shear is uniform and the normal
// stress linear, so the admissible part is one interval and one pass finds the final state.
// Returns true if any of the line failed.
inline bool bond_fracture(const BondMaterial &m, const BondConstants &c, const BondLine &line,
                          BondShape &b) {
  // The envelope divided by the normal stiffness: limits of the normal displacement.
  const double shear = m.shear_slope * std::fabs(line.dt);
  const double dn_max = m.tensile_share * c.squeeze - shear, dn_min = -c.squeeze;
  const double end_a = line.dn + (b.xi_lo() - 0.5) * line.dn_slope;
  const double end_b = line.dn + (b.xi_hi() - 0.5) * line.dn_slope;
  const double least = std::min(end_a, end_b), most = std::max(end_a, end_b);
  if (least >= dn_min && most <= dn_max) return false;
  if (dn_min > dn_max || least > dn_max || most < dn_min) {
    b.crack_b = 1.0 - b.crack_a;
    return true;
  }
  // Here dn varies along the line and crosses at least one limit.
  const double at_max = 0.5 + (dn_max - line.dn) / line.dn_slope;
  const double at_min = 0.5 + (dn_min - line.dn) / line.dn_slope;
  b.crack_a = std::max(b.crack_a, std::min(at_max, at_min));
  b.crack_b = std::max(b.crack_b, 1.0 - std::max(at_max, at_min));
  if (b.broken()) b.crack_b = 1.0 - b.crack_a;
  return true;
}

// Elastic energy stored in the uncracked part, J.
inline double bond_energy(const BondMaterial &m, const BondConstants &c, const BondShape &b,
                          const BondLine &line) {
  if (b.broken()) return 0.0;
  const double w = b.xi_hi() - b.xi_lo();
  const double mid = line.dn + (0.5 * (b.xi_lo() + b.xi_hi()) - 0.5) * line.dn_slope;
  const double square = mid * mid + line.dn_slope * line.dn_slope * w * w / 12.0;
  return 0.5 * c.ratio * c.length * w * (m.young * square + m.shear * line.dt * line.dt);
}

// Elastic normal force of the uncracked part, N: below 0 in compression.
inline double bond_normal_force(const BondMaterial &m, const BondConstants &c, const BondShape &b,
                                const BondLine &line) {
  const double mid = line.dn + (0.5 * (b.xi_lo() + b.xi_hi()) - 0.5) * line.dn_slope;
  return c.length * (b.xi_hi() - b.xi_lo()) * m.young * c.ratio * mid;
}

// Exact integrals of the line force and of its moment about the midline's centre over the uncracked
// part; dissipation (W) is what the damping takes.
inline PairForce bond_force(const BondMaterial &m, const BondConstants &c, const BondShape &b,
                            const BondLine &line, const BondPose &p, double &dissipation) {
  const double kn = m.young * c.ratio, kt = m.shear * c.ratio;
  const double cn = c.damping * m.root_young, ct = c.damping * m.root_shear;
  // Relative velocity of the two bodies at the midline: a rigid rotation of the pair has none.
  const Vec2 v{p.v.x - p.spin_hi * line.arm_hi.y + p.spin_lo * line.arm_lo.y,
               p.v.y + p.spin_hi * line.arm_hi.x - p.spin_lo * line.arm_lo.x};
  const double vn_slope = -(p.spin_hi - p.spin_lo) * line.mean_length;
  const double w = b.xi_hi() - b.xi_lo(), xm = 0.5 * (b.xi_lo() + b.xi_hi()) - 0.5;
  const double vn = v.x * line.n.x + v.y * line.n.y + xm * vn_slope;
  const double vt = v.x * line.t.x + v.y * line.t.y;
  const double qn = kn * (line.dn + xm * line.dn_slope) + cn * vn;
  const double qt = kt * line.dt + ct * vt;
  const double slope = kn * line.dn_slope + cn * vn_slope;
  const double lw = c.length * w;
  const double fn = lw * qn, ft = lw * qt;
  const double moment = -line.mean_length * lw * (xm * qn + slope * w * w / 12.0);
  dissipation = lw * (cn * (vn * vn + vn_slope * vn_slope * w * w / 12.0) + ct * vt * vt);
  PairForce out;
  out.f = {fn * line.n.x + ft * line.t.x, fn * line.n.y + ft * line.t.y};
  out.torque_lo = cross(line.arm_lo, out.f) + moment;
  out.torque_hi = -cross(line.arm_hi, out.f) - moment;
  return out;
}

// Compressive strength of ice of thickness h (m) after Kovacs & Sodhi, Pa.
inline double kovacs_sodhi_strength(double thickness) {
  const double root = std::cbrt(thickness);
  return 1285.0e3 * root * root;
}

}  // namespace floe

#endif
