// SPDX-License-Identifier: GPL-2.0-or-later
//
// Bonds of one rank in one step, evaluated several at once.
//
// The loop over pairs hands over the bonds it meets. Those that hold get their forces here, two or
// four in one pass, as the processor can; those that crack or reach too far are few and go back, to
// be looked at one by one. Either way each bond sees the same operations, so the result does not
// depend on the width to the bit.
#ifndef FLOE_CONTACT_BOND_BATCH_H
#define FLOE_CONTACT_BOND_BATCH_H

#include "body.h"
#include "bond.h"

namespace floe {

struct BatchBond {
  double *history;
  int *flag;
  int lo, hi;    // elements with the lower and the higher id
  double share;  // 1, or 1/2 for a pair that two ranks meet
};

class BondBatch {
 public:
  // limit2: square of the ratio of distance and sum of radii up to which a bond may reach;
  // `check` cracks and reach, or only evaluate.
  BondBatch(const BondMaterial &material, double limit2, bool check, const Body *bodies,
            Load *loads)
      : material_(material), limit2_(limit2), check_(check), bodies_(bodies), loads_(loads) {}

  void add(const BatchBond &bond) { bonds_[count_++] = bond; }
  bool full() const { return count_ == capacity; }

  // Adds the forces of all bonds that hold to the loads, then gives the others to `alone`.
  template <typename Alone>
  void finish(const Alone &alone) {
    const int given = evaluate();
    for (int k = 0; k < given; ++k) alone(bonds_[k]);
    count_ = 0;
  }

  double watt = 0.0;  // that damping took, each pair by its share

 private:
  static constexpr int capacity = 128;
  int evaluate();  // returns how many are left over, at the beginning of bonds_
  template <typename P, int Width>
  int evaluate_all();
  int evaluate_wide();

  const BondMaterial material_;
  const double limit2_;
  const bool check_;
  const Body *bodies_;
  Load *loads_;
  int count_ = 0;
  BatchBond bonds_[capacity + 3];  // room to fill up the last pack
};

}  // namespace floe

#endif
