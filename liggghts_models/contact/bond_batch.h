// SPDX-License-Identifier: GPL-2.0-or-later
//
// Bonds of one rank in one step, evaluated several at once.
//
// The list of bonds is kept until the neighbour lists or the bonds in them change. Bonds that hold get
// their forces here, two or four in one pass, as the processor can; those that crack or reach too far
// are few and are given back, to be looked at one by one. Either way each bond sees the same
// operations, so the result does not depend on the width to the bit.
#ifndef FLOE_CONTACT_BOND_BATCH_H
#define FLOE_CONTACT_BOND_BATCH_H

#include <vector>

#include "body.h"
#include "bond.h"

namespace floe {

struct ListedBond {
  double *history;
  int *flag;
  int lo, hi;    // elements with the lower and the higher id
  double share;  // 1, or 1/2 for a pair that two ranks meet
};

class BondBatch {
 public:
  void clear() { bonds_.clear(); }
  void add(const ListedBond &bond) { bonds_.push_back(bond); }

  // Adds the forces of the bonds that hold to the loads, and returns the power (W) that their damping
  // took. The others are in odd() then. limit2: square of the ratio of distance and sum of radii up to
  // which a bond may reach; check: look at cracks and reach, or only evaluate.
  double evaluate(const BondMaterial &material, double limit2, bool check, const Body *bodies,
                  Load *loads);
  const std::vector<ListedBond> &odd() const { return odd_; }

 private:
  std::vector<ListedBond> bonds_, odd_;
};

}  // namespace floe

#endif
