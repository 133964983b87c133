// SPDX-License-Identifier: GPL-2.0-or-later
//
// Linear contact: the force grows with the overlap, and with the thicknesses of the ice.
#ifndef FLOE_LAWS_LINEAR_CONTACT_H
#define FLOE_LAWS_LINEAR_CONTACT_H

#include "contact.h"

namespace floe {

// Normal stiffness N/m from the two thicknesses (m): springs of the two elements in series.
inline double contact_stiffness(double young, double h_one, double h_two) {
  const double sum = h_one + h_two;
  return sum > 0.0 ? young * (h_one * h_two) / sum : 0.0;
}

inline ContactConstants contact_constants(const ContactMaterial &m, double h_one, double h_two,
                                          double reduced_mass, double step = 0.0) {
  const double stiffness = contact_stiffness(m.young, h_one, h_two);
  return {stiffness, contact_damping(m, stiffness, reduced_mass, step)};
}

struct LinearContact {
  static constexpr const char *name = "linear";
  static constexpr LawKeywords keywords = {};
  static constexpr bool constant = true;

  static double stiffness(const ContactMaterial &m, ContactSide one, ContactSide two) {
    return contact_stiffness(m.young, one.thickness, two.thickness);
  }
  // All the spring is the element's ice.
  static double wall_stiffness(const ContactMaterial &m, ContactSide side) {
    return m.young * side.thickness;
  }
  template <typename T>
  FLOE_INLINE static ContactConstantsOf<T> at(const ContactConstantsOf<T> &c, T) {
    return c;
  }
  static double energy(double stiffness, double overlap, double shear) {
    return 0.5 * stiffness * (overlap * overlap + shear);
  }
};

}  // namespace floe

#endif
