// SPDX-License-Identifier: GPL-2.0-or-later
//
// The laws that the pair style knows. Another one is its header and its name here: keywords, loops over
// many pairs at once, breakage, logs, sums, history and restart files take it from these lists, and
// tests/test_laws.cpp holds it to what all laws keep. See docs/models/laws.md.
#ifndef FLOE_LAWS_LAWS_H
#define FLOE_LAWS_LAWS_H

#include "glue_bond.h"
#include "hertz_contact.h"
#include "law_list.h"
#include "linear_contact.h"
#include "parallel_bond.h"

// The first of each list is the default.
#define FLOE_BOND_LAWS(LAW) LAW(GlueBond) LAW(ParallelBond)
#define FLOE_CONTACT_LAWS(LAW) LAW(LinearContact) LAW(HertzContact)

namespace floe {

using BondLaws = FLOE_LAW_LIST(FLOE_BOND_LAWS);
using ContactLaws = FLOE_LAW_LIST(FLOE_CONTACT_LAWS);

// By the law that the material names.
inline ContactConstants constants_now(const ContactMaterial &m, const ContactConstants &c,
                                      double overlap) {
  return ContactLaws::with(m.law, [&](auto law) { return law.at(c, overlap); });
}

// Elastic energy, J; with slip 0 where there is no friction.
inline double contact_energy(const ContactMaterial &m, double stiffness, double overlap,
                             double slip) {
  if (!(overlap > 0.0)) return 0.0;
  const double shear = m.shear_ratio * slip * slip;
  return ContactLaws::with(m.law, [&](auto law) { return law.energy(stiffness, overlap, shear); });
}

}  // namespace floe

#endif
