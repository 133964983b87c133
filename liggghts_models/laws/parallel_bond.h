// SPDX-License-Identifier: GPL-2.0-or-later
//
// Parallel bond: a beam of ice between two discs that breaks whole, by its largest edge stress.
//
// In the plane the beam of Potyondy & Cundall (2004, Int. J. Rock Mech. 41, 1329, doi
// 10.1016/j.ijrmms.2004.09.011) is a rectangle of length L and thickness h with stiffnesses E/d and
// G/d per area: its forces and moment are those of the uncracked line. What differs is its end: edge
// tension F / (L h) + 6 |M| / (h L^2) above the tensile strength, or shear F_t / (L h) above the shear
// strength; compression does not break it.
#ifndef FLOE_LAWS_PARALLEL_BOND_H
#define FLOE_LAWS_PARALLEL_BOND_H

#include "bond.h"
#include "defaults.h"

namespace floe {

struct ParallelBond : ElasticLine {
  static constexpr const char *name = "parallel";
  // Shear strength over compressive strength: as strong as in tension.
  static constexpr LawKeywords keywords = {{"shear_share", defaults::tensile_share}};

  static const char *fault(const BondMaterial &m) {
    return m.tensile_share > 0.0 ? nullptr : "needs a tensile_share above 0";
  }
  template <typename T>
  FLOE_INLINE static auto holds(const BondMaterial &m, const BondConstantsOf<T> &c,
                                const BondLineOf<T> &line, const BondShapeOf<T> &b) {
    // Strengths and stresses as displacements: both times span over Young's modulus.
    return (bond_range(line, b).most <= m.tensile_share * c.squeeze) &
           (m.shear * magnitude(line.dt) <= m.own[0] * m.young * c.squeeze);
  }
  static bool fracture(const BondMaterial &m, const BondConstants &c, const BondLine &line,
                       BondShape &b) {
    if (holds(m, c, line, b)) return false;
    b.crack_b = 1.0 - b.crack_a;
    return true;
  }
  static BreakageMode mode(const BondMaterial &m, const BondConstants &c, const BondLine &line,
                           const BondShape &b) {
    const bool pulled = bond_range(line, b).most > m.tensile_share * c.squeeze;
    return pulled ? BreakageMode::tension : BreakageMode::shear;
  }
};

}  // namespace floe

#endif
