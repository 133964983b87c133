// SPDX-License-Identifier: GPL-2.0-or-later
//
// What computes, tallies and logs ask of a pair: its force as the last evaluation left it.
#ifndef FLOE_CONTACT_PAIR_STATE_H
#define FLOE_CONTACT_PAIR_STATE_H

#include "bond.h"

namespace floe {

struct PairState {
  int i, j;         // i is this rank's own
  Vec2 d;           // from i to j, m
  Vec2 f;           // on i, N; j takes the opposite
  double torque_i;  // N m
  double torque_j;
  double energy;    // elastic, J
  double share;     // 1, or 1/2 for a pair that two ranks meet
  double *history;  // in LIGGGHTS' lists
  int bond;         // number among the bonds of this rank, -1 for a contact
};

// A bond as it is now. Stresses (Pa) are those of the uncracked part: the normal ones at its two ends
// (above 0 in tension), the shear stress the same all along.
struct BondState {
  int lo, hi;
  double whole;        // uncracked share of the line
  double least, most;  // normal stress
  double shear;
  double thickness, span;  // m
  double length;           // of the line, m
  double energy;           // J
  Vec2 centre;             // of the line, m
};

struct Breakage {
  long long step;
  int lo, hi;  // ids
  double x, y, time;
  BreakageMode mode;
  double normal, shear;  // Pa, where the line failed
  double thickness;      // m
  double energy;         // J, that the bond held
};

}  // namespace floe

#endif
