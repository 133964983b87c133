// SPDX-License-Identifier: GPL-2.0-or-later
//
// Contact after Hertz (1882, J. reine angew. Math. 92, 156): two spheres of one material, as LIGGGHTS'
// own `model hertz` has it. Thickness has no part in it.
//
// The secant stiffness is 4/3 E* sqrt(R* overlap). A rigid wall has no radius and does not give: R* is
// the disc's and E* twice as large.
#ifndef FLOE_LAWS_HERTZ_CONTACT_H
#define FLOE_LAWS_HERTZ_CONTACT_H

#include "contact.h"

namespace floe {

struct HertzContact {
  static constexpr const char *name = "hertz";
  static constexpr LawKeywords keywords = {};
  static constexpr bool constant = false;

  static double stiffness(const ContactMaterial &m, ContactSide one, ContactSide two) {
    const double modulus = 0.5 * m.young / (1.0 - m.poisson * m.poisson);
    return 4.0 / 3.0 * modulus * std::sqrt(one.radius * two.radius / (one.radius + two.radius));
  }
  static double wall_stiffness(const ContactMaterial &m, ContactSide side) {
    return 4.0 / 3.0 * m.young / (1.0 - m.poisson * m.poisson) * std::sqrt(side.radius);
  }
  // Damping stays the same share of the critical one.
  template <typename T>
  FLOE_INLINE static ContactConstantsOf<T> at(const ContactConstantsOf<T> &c, T overlap) {
    const T half = root(larger(overlap, T{}));
    return {c.stiffness * half, c.damping * root(half)};
  }
  static double energy(double stiffness, double overlap, double shear) {
    return stiffness * std::sqrt(overlap) * (0.4 * overlap * overlap + 0.5 * shear);
  }
};

}  // namespace floe

#endif
