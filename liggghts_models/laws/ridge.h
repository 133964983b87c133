// SPDX-License-Identifier: GPL-2.0-or-later
//
// Law of ridging: two unbonded elements push elastically until the ridging force of their contact is
// reached, then ice between them piles up while the force stays on that limit.
//
// Plastic closing moves the contact's rest overlap, so the force follows from the stored history and
// the positions alone. See docs/theory/contact.md. After Hopkins (1994, J. Geophys. Res. 99, 16351;
// 1996, J. Geophys. Res. 101, 18315) and Turner et al. (2022, GMD 15, 1953). Open water between the
// centres closes first: the force is Hibler's (1979, J. Phys. Oceanogr. 9, 815) share of that of ice
// without leads.
#ifndef FLOE_LAWS_RIDGE_H
#define FLOE_LAWS_RIDGE_H

#include <algorithm>
#include <cmath>

#include "defaults.h"

namespace floe {

using defaults::edge_share;

struct RidgeMaterial {
  double start;            // force per contact length over ridge thickness, N/m2
  double hardening;        // its growth with closing over squared ridge thickness, N/m4
  double thin;             // ridge thickness from which on ice crushes, m
  double softening = 0.0;  // the force falls by exp(-softening (1 - cover)) with open water
};

// The ridge between two elements. It ends with their contact.
struct Ridge {
  double closing;      // plastic closing since they touched, m
  double thickness;    // of the ice in the contact, m
  double length;       // contact length, m
  double cover = 1.0;  // share of the way between the centres that ice covers
};

// Ridging force per contact length, N/m, and its growth with closing, N/m2.
struct RidgeForce {
  double force, slope;
};

// Share of its strength that ice has of which so much is open water.
inline double lead_share(const RidgeMaterial &m, double cover) {
  return m.softening > 0.0 && cover < 1.0 ? std::exp(-m.softening * (1.0 - cover)) : 1.0;
}

// strength: compressive strength of ice of that thickness, Pa. Never above what crushes the ice;
// continuous, and growing with thickness, closing and cover.
inline RidgeForce ridge_force(const RidgeMaterial &m, double strength, const Ridge &r) {
  const double thin = std::min(r.thickness, m.thin), crush = thin * strength;
  RidgeForce out;
  out.slope = m.hardening * thin * thin;
  out.force = m.start * thin + out.slope * r.closing;
  if (out.force >= crush) out = {crush, 0.0};
  const double whole = lead_share(m, r.cover);
  if (r.thickness > m.thin) {
    // Piling up at the first thickness, crushing from twice that on.
    const double share = std::min(r.thickness / m.thin - 1.0, 1.0);
    out.force += share * (r.thickness * strength - out.force);
    out.slope *= 1.0 - share;
  }
  return {whole * out.force, whole * out.slope};
}

// Growth of a force (N/m) with closing, N/m2, as open water gives way: the ice between centres that
// are this far apart without stress (m) keeps its area.
inline double lead_slope(const RidgeMaterial &m, const Ridge &r, double span, double force) {
  return r.cover < 1.0 ? m.softening * force * r.cover / span : 0.0;
}

// Lets the contact close plastically where its elastic force (N) is above the ridging force. overlap
// (m) is the elastic one and shrinks by what is returned: the plastic closing, m. The ice between
// the centres, this far apart without stress (m), keeps its volume, and its area while there is open
// water.
inline double ridge_closing(const RidgeForce &limit, double stiffness, double span, double overlap,
                            Ridge &r) {
  const double excess = stiffness * overlap - r.length * limit.force;
  if (!(excess > 0.0)) return 0.0;
  const double closing = excess / (stiffness + r.length * limit.slope);
  r.closing += closing;
  r.thickness *= span / (span - closing);
  if (r.cover < 1.0) r.cover = std::min(r.cover * span / (span - closing), 1.0);
  return closing;
}

// Share of the closed area that the element of thickness h_one gives to the ridge: the thinner one
// gives more, in inverse proportion to the thicknesses. With leads these count by their lead_share.
inline double ridge_share(double h_one, double h_two) {
  const double sum = h_one + h_two;
  return sum > 0.0 ? h_two / sum : 0.5;
}

// Force (N) with which a contact goes on where a bond broke in compression: the smaller of the
// bond's last force and the ridging force, and never one that holds more elastic energy than the
// bond had (J): the contact is softer than the bond, and fracture must not make energy.
inline double ridge_takeover(double bond_force, double bond_energy, double limit,
                             double stiffness) {
  return std::max(0.0, std::min({bond_force, limit, std::sqrt(2.0 * stiffness * bond_energy)}));
}

}  // namespace floe

#endif
