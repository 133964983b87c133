// SPDX-License-Identifier: GPL-2.0-or-later
//
// Parallel bond: a beam of ice between two discs that breaks whole, by its largest edge stress.
//
// In the plane the beam of Potyondy & Cundall (2004, Int. J. Rock Mech. 41, 1329, doi
// 10.1016/j.ijrmms.2004.09.011) is a rectangle of length L and thickness h with stiffnesses E/d and
// G/d per area: its forces and moment are those of the uncracked glue line (bond.h). What differs is
// its end: edge tension F / (L h) + 6 |M| / (h L^2) above the tensile strength, or shear F_t / (L h)
// above the shear strength; compression does not break it.
#ifndef FLOE_LAWS_PARALLEL_BOND_H
#define FLOE_LAWS_PARALLEL_BOND_H

#include <cmath>

#include "bond.h"

namespace floe {

struct ParallelStrength {
  double tensile, shear;  // Pa
};

// span: distance of the centres at rest, m.
inline bool parallel_bond_breaks(const BondMaterial &m, const ParallelStrength &strength,
                                 const BondLine &line, double span) {
  const double edge = m.young * (line.dn + 0.5 * std::fabs(line.dn_slope)) / span;
  const double tau = m.shear * std::fabs(line.dt) / span;
  return !(edge <= strength.tensile && tau <= strength.shear);
}

// Loops that evaluate many bonds at once know the envelope of the glue line only: tension T, cut off
// at -T, and |tau| <= (T - sigma) tan(phi). With this tangent that lies within the beam's: what is
// inside holds, what is outside is looked at by the law.
inline double parallel_envelope(const ParallelStrength &strength) {
  return 0.5 * strength.shear / strength.tensile;
}

}  // namespace floe

#endif
