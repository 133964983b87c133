// SPDX-License-Identifier: GPL-2.0-or-later
//
// What a force on elements says of itself: its keywords, and what acts on an element.
//
// A force begins from PushForce or HoldForce and has a name, which is the keyword that turns it on and
// the name of its sums. It knows neither LIGGGHTS nor MPI. See docs/contributing/effect.md.
#ifndef FLOE_LAWS_ICE_FORCE_H
#define FLOE_LAWS_ICE_FORCE_H

#include "drag.h"

namespace floe {

// A keyword of fix floe/integrate that one force alone reads: a number, its default, and whether it may
// be 0; below 0 it may not be.
struct ForceKeyword {
  const char *name = nullptr;
  double value = 0.0;
  bool zero = false;
};
constexpr int force_keywords = 4;  // that a force may have
using ForceKeywords = ForceKeyword[force_keywords];
using ForceValues = double[force_keywords];  // in the order of the keywords

// An element at the beginning of a step.
struct ForceInput {
  DriftInput drift;  // with the contact forces alone
  double thickness;  // ice volume over the element's area, m
  double cover;      // share of the element under ice
  double depth;      // of the sea, m
};

// Forces that do not depend on the new velocity: static Vec2 push(values, input), in N.
struct PushForce {
  static constexpr bool holds = false, reads_depth = false;
  static constexpr ForceKeywords keywords{};
};

// Friction against rest: static double limit(values, input), the largest force (N), and
// static double creep(values), the speed (m/s) at which half of it acts.
struct HoldForce : PushForce {
  static constexpr bool holds = true;
};

}  // namespace floe

#endif
