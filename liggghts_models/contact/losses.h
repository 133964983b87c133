// SPDX-License-Identifier: GPL-2.0-or-later
#ifndef FLOE_CONTACT_LOSSES_H
#define FLOE_CONTACT_LOSSES_H

#include "ledger.h"

namespace floe {

// Damping of a kind of pairs: none; its losses counted from the velocities before the step that make
// its force (first order in the step); or its forces kept per element, so that the integrator finds
// their work over the step (second order).
enum class Damping { none, counted, exact };

// Sums over the pairs of one rank in one step.
struct Losses {
  double bond = 0.0, contact = 0.0;                      // W
  double friction = 0.0, fracture = 0.0, ridging = 0.0;  // J
  double cracked = 0.0, broken = 0.0;

  void add_to(Ledger &total, double step) const {
    total.dissipation_bond += bond * step;
    total.dissipation_contact += contact * step;
    total.dissipation_friction += friction;
    total.dissipation_fracture += fracture;
    total.dissipation_ridging += ridging;
    total.bonds_cracked += cracked;
    total.bonds_broken += broken;
  }
};

}  // namespace floe

#endif
