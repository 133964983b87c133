// SPDX-License-Identifier: GPL-2.0-or-later
//
// What all laws of bonds share: a line of frozen water between two discs of ice, its displacement and
// its elastic and damping forces. When and how a bond fails is its law's (glue_bond.h, parallel_bond.h).
//
// Why it looks like this: the displacement between the two sides of the line follows from the
// positions of the elements alone (the line's ends are stored in the body frame of either element),
// so nothing drifts, and a state read from a file continues exactly. Every integral has a closed
// form because the displacement is linear along the line. See docs/theory/contact.md.
#ifndef FLOE_LAWS_BOND_H
#define FLOE_LAWS_BOND_H

#include <cmath>

#include "law_list.h"
#include "pack.h"

namespace floe {

// T is double, or Pack for several bonds at once.
template <typename T>
struct VectorOf {
  T x, y;
};
using Vec2 = VectorOf<double>;

template <typename T>
FLOE_INLINE T cross(VectorOf<T> a, VectorOf<T> b) {
  return a.x * b.y - a.y * b.x;
}

// What both elements of a pair bring to a bond. "lo" is the element with the lower id.
template <typename T>
struct BondPoseOf {
  VectorOf<T> d;                 // centre of hi minus centre of lo, m
  VectorOf<T> turn_lo, turn_hi;  // cosine and sine of the orientations
  VectorOf<T> v;                 // velocity of hi minus velocity of lo, m/s
  T spin_lo, spin_hi;            // rad/s
};
using BondPose = BondPoseOf<double>;

// The bond as stored: ends a (xi = 0) and b (xi = 1) of the line in the body frames of lo and hi (m).
// Looking from a to b, lo lies on the left: the normal then points from lo to hi.
template <typename T>
struct BondShapeOf {
  VectorOf<T> lo_a, lo_b, hi_a, hi_b;
  T span;              // distance of the centres at rest, m
  T thickness;         // m
  T crack_a, crack_b;  // cracked share of the line, from end a and from end b
  FLOE_INLINE T xi_lo() const {
    return crack_a;
  }  // the uncracked part lies between xi_lo and xi_hi
  FLOE_INLINE T xi_hi() const { return 1.0 - crack_b; }
  // What is left of the line is compared with round-off of its ends, which are near 1.
  bool broken() const { return !(crack_a + crack_b < 1.0 - 1e-12); }
};
using BondShape = BondShapeOf<double>;

struct BondMaterial {
  double young;                   // Pa
  double shear;                   // shear modulus, Pa
  double damping;                 // share of critical damping
  double tensile_share;           // tensile over compressive strength
  double tan_phi;                 // tangent of the angle of internal friction
  double root_young, root_shear;  // roots of the moduli
  double shear_slope;             // shear / (young tan_phi)
  double own[law_keywords] = {};  // the law's own keywords, in their order
  int law = 0;                    // its place among BondLaws (laws.h)
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
template <typename T>
struct BondConstantsOf {
  T length;   // of the glue line, m
  T ratio;    // thickness over span; times a modulus: stiffness per length, Pa
  T damping;  // times the root of a modulus: damping per length, Pa s
  T squeeze;  // normal displacement at which the line crushes, m
};
using BondConstants = BondConstantsOf<double>;

// Where the line is now: frame, displacement along it, and arms of the midline's centre.
template <typename T>
struct BondLineOf {
  VectorOf<T> n, t;            // normal (lo to hi) and tangent (a to b)
  T mean_length;               // length of the midline, m
  T dn, dn_slope;              // normal displacement at xi = 1/2 and its change over the line, m
  T dt;                        // tangential displacement (the same along the line), m
  VectorOf<T> arm_lo, arm_hi;  // from the centres of lo and hi to the centre of the midline, m
};
using BondLine = BondLineOf<double>;

// Force and torque on lo; hi takes -force, and its own torque.
template <typename T>
struct PairForceOf {
  VectorOf<T> f;
  T torque_lo, torque_hi;
};
using PairForce = PairForceOf<double>;

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

template <typename T>
FLOE_INLINE BondLineOf<T> bond_line(const BondShapeOf<T> &b, const BondPoseOf<T> &p) {
  using V = VectorOf<T>;
  const auto turn = [](V q, V a) { return V{q.x * a.x - q.y * a.y, q.y * a.x + q.x * a.y}; };
  const V la = turn(p.turn_lo, b.lo_a), lb = turn(p.turn_lo, b.lo_b);
  const V ha = turn(p.turn_hi, b.hi_a), hb = turn(p.turn_hi, b.hi_b);
  const V line_lo{lb.x - la.x, lb.y - la.y}, line_hi{hb.x - ha.x, hb.y - ha.y};
  const V sum{line_lo.x + line_hi.x, line_lo.y + line_hi.y};
  const T norm = root(sum.x * sum.x + sum.y * sum.y);
  BondLineOf<T> out;
  const T inv = 1.0 / norm;
  out.t = {sum.x * inv, sum.y * inv};
  out.n = {out.t.y, -out.t.x};
  out.mean_length = 0.5 * norm;
  const V mid_lo{0.5 * (la.x + lb.x), 0.5 * (la.y + lb.y)};
  const V mid_hi{0.5 * (ha.x + hb.x), 0.5 * (ha.y + hb.y)};
  const V dm{p.d.x + (mid_hi.x - mid_lo.x), p.d.y + (mid_hi.y - mid_lo.y)};
  const V dd{line_hi.x - line_lo.x, line_hi.y - line_lo.y};
  out.dn = dm.x * out.n.x + dm.y * out.n.y;
  out.dt = dm.x * out.t.x + dm.y * out.t.y;
  // Both lines have the same length, so their difference is normal to their sum: dt has no slope.
  out.dn_slope = dd.x * out.n.x + dd.y * out.n.y;
  out.arm_lo = {mid_lo.x + 0.5 * dm.x, mid_lo.y + 0.5 * dm.y};
  out.arm_hi = {mid_hi.x - 0.5 * dm.x, mid_hi.y - 0.5 * dm.y};
  return out;
}

template <typename T>
struct BondLimitsOf {
  T least, most;
};

// Normal displacements at the ends of the uncracked part, in order.
template <typename T>
FLOE_INLINE BondLimitsOf<T> bond_range(const BondLineOf<T> &line, const BondShapeOf<T> &b) {
  const T end_a = line.dn + (b.xi_lo() - 0.5) * line.dn_slope;
  const T end_b = line.dn + (b.xi_hi() - 0.5) * line.dn_slope;
  return {smaller(end_a, end_b), larger(end_a, end_b)};
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
// part; dissipation (W) is what the damping takes. Not Damped: without its terms, in the code either.
template <bool Damped = true, typename T>
FLOE_INLINE PairForceOf<T> bond_force(const BondMaterial &m, const BondConstantsOf<T> &c,
                                      const BondShapeOf<T> &b, const BondLineOf<T> &line,
                                      const BondPoseOf<T> &p, T &dissipation) {
  const T kn = m.young * c.ratio, kt = m.shear * c.ratio;
  const T w = b.xi_hi() - b.xi_lo(), xm = 0.5 * (b.xi_lo() + b.xi_hi()) - 0.5;
  const T lw = c.length * w;
  T qn = kn * (line.dn + xm * line.dn_slope), qt = kt * line.dt, slope = kn * line.dn_slope;
  if constexpr (Damped) {
    const T cn = c.damping * m.root_young, ct = c.damping * m.root_shear;
    // Relative velocity of the two bodies at the midline: a rigid rotation of the pair has none.
    const VectorOf<T> v{p.v.x - p.spin_hi * line.arm_hi.y + p.spin_lo * line.arm_lo.y,
                        p.v.y + p.spin_hi * line.arm_hi.x - p.spin_lo * line.arm_lo.x};
    const T vn_slope = -(p.spin_hi - p.spin_lo) * line.mean_length;
    const T vn = v.x * line.n.x + v.y * line.n.y + xm * vn_slope;
    const T vt = v.x * line.t.x + v.y * line.t.y;
    qn += cn * vn;
    qt += ct * vt;
    slope += cn * vn_slope;
    dissipation = lw * (cn * (vn * vn + vn_slope * vn_slope * w * w / 12.0) + ct * vt * vt);
  } else {
    dissipation = T{};
  }
  const T fn = lw * qn, ft = lw * qt;
  const T moment = -line.mean_length * lw * (xm * qn + slope * w * w / 12.0);
  PairForceOf<T> out;
  out.f = {fn * line.n.x + ft * line.t.x, fn * line.n.y + ft * line.t.y};
  out.torque_lo = cross(line.arm_lo, out.f) + moment;
  out.torque_hi = -cross(line.arm_hi, out.f) - moment;
  return out;
}

// What a force does to the two bodies, W: below 0 where it takes energy from their motion.
template <typename T>
FLOE_INLINE T pair_power(const PairForceOf<T> &force, const BondPoseOf<T> &p) {
  return force.torque_lo * p.spin_lo + force.torque_hi * p.spin_hi -
         (force.f.x * p.v.x + force.f.y * p.v.y);
}

enum class BreakageMode { tension = 1, shear = 2, compression = 3 };

// Forces of the line as above. A law of bonds takes them from here, or has its own in their place, and
// adds (see laws.h):
//   name                            of the keyword bond_law
//   holds(m, c, line, shape)        whether nothing of it fails now; for double and packs
//   fracture(m, c, line, shape)     lets cracks grow, or the whole bond go; whether anything failed
//   mode(m, c, line, shape)         of a bond that broke from this shape
// and, where it needs them, keywords and fault(m).
// `fracture` fails what `holds` does not hold, and leaves what holds. Of the shape only the cracks count
// there: span, thickness and strength are in the constants.
struct ElasticLine {
  static constexpr LawKeywords keywords = {};
  // What is wrong with a material, null if nothing.
  static const char *fault(const BondMaterial &) { return nullptr; }

  template <bool Damped, typename T>
  FLOE_INLINE static PairForceOf<T> force(const BondMaterial &m, const BondConstantsOf<T> &c,
                                          const BondShapeOf<T> &b, const BondLineOf<T> &line,
                                          const BondPoseOf<T> &p, T &dissipation) {
    return bond_force<Damped>(m, c, b, line, p, dissipation);
  }
  static double energy(const BondMaterial &m, const BondConstants &c, const BondShape &b,
                       const BondLine &line) {
    return bond_energy(m, c, b, line);
  }
  static double normal_force(const BondMaterial &m, const BondConstants &c, const BondShape &b,
                             const BondLine &line) {
    return bond_normal_force(m, c, b, line);
  }
};

// Compressive strength of ice of thickness h (m) after Kovacs & Sodhi, Pa.
inline double kovacs_sodhi_strength(double thickness) {
  const double root = std::cbrt(thickness);
  return 1285.0e3 * root * root;
}

}  // namespace floe

#endif
