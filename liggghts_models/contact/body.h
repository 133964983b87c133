// SPDX-License-Identifier: GPL-2.0-or-later
//
// What the loop over pairs reads and adds up for an element.
#ifndef FLOE_CONTACT_BODY_H
#define FLOE_CONTACT_BODY_H

namespace floe {

// One cache line, gathered once per step.
struct alignas(64) Body {
  double x, y, u, v, spin, cos, sin, radius;
};

struct alignas(32) Load {
  double fx, fy, torque, ridged;  // N, N m; area turned into ridge, m2
};

struct DampingWork {
  double bond = 0.0, contact = 0.0;  // J
};

}  // namespace floe

#endif
