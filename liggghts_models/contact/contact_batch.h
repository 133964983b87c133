// SPDX-License-Identifier: GPL-2.0-or-later
//
// Contacts of one rank in one step, evaluated several at once, as bond_batch.h does with bonds: the
// same operations for each, so the same bits at every width.
#ifndef FLOE_CONTACT_CONTACT_BATCH_H
#define FLOE_CONTACT_CONTACT_BATCH_H

#include "body.h"
#include "contact.h"
#include "lane_sums.h"

namespace floe {

struct Touching {
  double *history;
  int i, j;
};

// Losses in lanes of four.
struct ContactSums {
  LaneSums damping, friction;  // W, J
};

// What a batch needs to know; elements from nlocal on are ghosts, their pairs count by half.
struct ContactTask {
  const ContactMaterial material;
  const double step;   // s
  const bool advance;  // the history; or only evaluate
  const int nlocal;
  const Body *const bodies;
  Load *const loads;
};

// Adds forces to the loads and losses to the sums. `pairs` has room for three more than `count`.
template <bool Friction>
void evaluate_contacts(const ContactTask &task, Touching *pairs, int count, ContactSums &sums);

}  // namespace floe

#endif
