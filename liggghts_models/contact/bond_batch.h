// SPDX-License-Identifier: GPL-2.0-or-later
//
// Bonds of one rank in one step, evaluated several at once.
//
// Bonds that hold get their forces here, two or four in one pass, as the processor can; those that
// crack or reach too far are few and are given back, to be looked at one by one. Either way each bond
// sees the same operations, so the result does not depend on the width to the bit.
#ifndef FLOE_CONTACT_BOND_BATCH_H
#define FLOE_CONTACT_BOND_BATCH_H

#include <vector>

#include "body.h"
#include "laws.h"
#include "losses.h"
#include "records.h"

namespace floe {

struct BondTask {
  const BondMaterial &material;
  const double limit2;  // square of distance over sum of radii up to which a bond may reach
  const bool check;     // look at cracks and reach, or only evaluate
  const Body *const bodies;
  Load *const loads;
  Load *const damped;  // what damping adds, with Damping::exact
};

// Adds the forces of the bonds that hold to the loads (in two rows each, where Exact), and returns the
// power (W) that their damping took where that is counted. The numbers of the others go to `odd`.
template <typename Law, Damping Damp, bool Exact>
double evaluate_bonds(const BondTask &task, const BondRecords &bonds, std::vector<int> &odd);

}  // namespace floe

#endif
