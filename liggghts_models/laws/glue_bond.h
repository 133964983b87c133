// SPDX-License-Identifier: GPL-2.0-or-later
//
// Glue line: a bond that cracks from its ends, where the stress along it leaves the strength envelope.
// After Hopkins, Frankenstein & Thorndike (2004), doi 10.1029/2003JC001855.
#ifndef FLOE_LAWS_GLUE_BOND_H
#define FLOE_LAWS_GLUE_BOND_H

#include "bond.h"

namespace floe {

// Limits of the normal displacement: the strength envelope divided by the normal stiffness.
template <typename T>
FLOE_INLINE BondLimitsOf<T> bond_limits(const BondMaterial &m, const BondConstantsOf<T> &c,
                                        const BondLineOf<T> &line) {
  return {-c.squeeze, m.tensile_share * c.squeeze - m.shear_slope * magnitude(line.dt)};
}

// Lets the cracks run until the stress is admissible all along the rest of the line: tension
// cut-off, compression cut-off and Mohr-Coulomb |tau| <= cohesion - sigma tan(phi) (sigma > 0 is
// tension), whose tip lies at the tensile strength: cohesion = tensile tan(phi). The displacement
// does not depend on what has failed, the shear is uniform and the normal stress linear, so the
// admissible part is one interval and one pass finds the final state.
// Returns true if any of the line failed.
inline bool bond_fracture(const BondMaterial &m, const BondConstants &c, const BondLine &line,
                          BondShape &b) {
  const auto [dn_min, dn_max] = bond_limits(m, c, line);
  const auto [least, most] = bond_range(line, b);
  if (least >= dn_min && most <= dn_max) return false;
  if (dn_min > dn_max || least > dn_max || most < dn_min) {
    b.crack_b = 1.0 - b.crack_a;
    return true;
  }
  // Here dn varies along the line and crosses at least one limit.
  const double at_max = 0.5 + (dn_max - line.dn) / line.dn_slope;
  const double at_min = 0.5 + (dn_min - line.dn) / line.dn_slope;
  b.crack_a = larger(b.crack_a, smaller(at_max, at_min));
  b.crack_b = larger(b.crack_b, 1.0 - larger(at_max, at_min));
  if (b.broken()) b.crack_b = 1.0 - b.crack_a;
  return true;
}

struct GlueBond : ElasticLine {
  static constexpr const char *name = "glue";

  template <typename T>
  FLOE_INLINE static auto holds(const BondMaterial &m, const BondConstantsOf<T> &c,
                                const BondLineOf<T> &line, const BondShapeOf<T> &b) {
    const BondLimitsOf<T> limits = bond_limits(m, c, line), range = bond_range(line, b);
    return (range.least >= limits.least) & (range.most <= limits.most);
  }
  static bool fracture(const BondMaterial &m, const BondConstants &c, const BondLine &line,
                       BondShape &b) {
    return bond_fracture(m, c, line, b);
  }
  static BreakageMode mode(const BondMaterial &m, const BondConstants &c, const BondLine &line,
                           const BondShape &b) {
    const auto [least, most] = bond_range(line, b);
    if (least < bond_limits(m, c, line).least) return BreakageMode::compression;
    return most > 0.0 ? BreakageMode::tension : BreakageMode::shear;
  }
};

}  // namespace floe

#endif
