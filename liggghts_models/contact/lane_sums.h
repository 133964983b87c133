// SPDX-License-Identifier: GPL-2.0-or-later
//
// Sums in four lanes, whatever the width of the packs: the same bits on every processor.
#ifndef FLOE_CONTACT_LANE_SUMS_H
#define FLOE_CONTACT_LANE_SUMS_H

#include "pack.h"

namespace floe {

struct alignas(32) LaneSums {
  double lane[4] = {};
  template <typename P>
  FLOE_INLINE void add(int first, P value) {
    add_pack(lane + first, value);
  }
  double total() const { return (lane[0] + lane[1]) + (lane[2] + lane[3]); }
};

}  // namespace floe

#endif
