// SPDX-License-Identifier: GPL-2.0-or-later
//
// Contacts of one rank in one step, evaluated several at once, as bond_batch.h does with bonds: the
// same operations for each, so the same bits at every width.
#ifndef FLOE_CONTACT_CONTACT_BATCH_H
#define FLOE_CONTACT_CONTACT_BATCH_H

#include "body.h"
#include "contact.h"
#include "lane_sums.h"
#include "laws.h"
#include "losses.h"
#include "records.h"

namespace floe {

class PairFloe;

// Losses in lanes of four.
struct ContactSums {
  LaneSums damping, friction;  // W, J
  double ridging = 0.0;        // J
};

// What a batch needs to know; elements from nlocal on are ghosts, their pairs count by half.
struct ContactTask {
  const ContactMaterial &material;
  const PairFloe *const ridging;  // how a contact closes; null without ridging
  const double step;              // s
  const bool advance;             // the history; or only evaluate
  const int nlocal;
  const Body *const bodies;
  Load *const loads;
  Load *const damped;  // what damping adds, with Damping::exact
  Ends *const ends;
  ContactRow *const rows;
  RidgeRow *const ridges;
  double *const covers;
};

// The law and its terms: what is off is not in the code. Exact loads take two rows each.
template <bool WithFriction, bool WithRidging, Damping WithDamping, bool WithExactSums,
          typename WithLaw>
struct ContactTerms {
  using Law = WithLaw;
  static constexpr bool friction = WithFriction, ridging = WithRidging;
  static constexpr bool exact_sums = WithExactSums;
  static constexpr Damping damping = WithDamping;
};

// Adds forces of the contacts with these numbers to the loads and losses to the sums. `touching` has
// room for three more than `count`.
template <typename Terms>
void evaluate_contacts(const ContactTask &task, int *touching, int count, ContactSums &sums);

}  // namespace floe

#endif
