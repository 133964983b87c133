// SPDX-License-Identifier: GPL-2.0-or-later
//
// The forces that fix floe/integrate knows beside wind, water and the rotation of the earth. Another one
// is its header and its name here, after all others, because scripts name sums by their numbers:
// keywords, the step, sums of impulse and work, and restart files take it from this list.
#ifndef FLOE_LAWS_FORCES_H
#define FLOE_LAWS_FORCES_H

#include <string>

#include "law_list.h"
#include "seabed.h"

#define FLOE_FORCES(FORCE) FORCE(SeabedFriction)

namespace floe {

// Of one force, since the fix was made.
struct ForceSums {
  double impulse_x = 0.0, impulse_y = 0.0;  // N s
  double energy = 0.0;                      // J: work on the ice, or what friction takes from it
};

// Where a keyword belongs: to none, to a force as the one that turns it on, or to one of its values.
struct ForceKey {
  int force = -1, value = -1;
  bool zero = false;  // the value may be 0
};

// Switches, values and impulses of the forces of a list.
template <typename List>
struct ForceSet {
  static constexpr int count = List::count;
  using Impulses = Vec2[count];  // N s over a step
  struct Ledger {
    ForceSums of[count];
  };

  bool use[count] = {};
  ForceValues value[count] = {};

  ForceSet() {
    int k = 0;
    List::each([&](auto force) {
      for (int n = 0; n < force_keywords; ++n) value[k][n] = force.keywords[n].value;
      ++k;
    });
  }

  bool any() const {
    bool found = false;
    for (const bool used : use) found |= used;
    return found;
  }

  static ForceKey find(const std::string &key) {
    ForceKey found;
    int k = 0;
    List::each([&](auto force) {
      if (key == force.name) found = {k, -1, false};
      for (int n = 0; n < force_keywords; ++n) {
        const ForceKeyword &word = force.keywords[n];
        if (word.name && key == word.name) found = {k, n, word.zero};
      }
      ++k;
    });
    return found;
  }

  // Name of a force in use that reads the depth of the sea; null where there is none.
  const char *reads_depth() const {
    const char *found = nullptr;
    int k = 0;
    List::each([&](auto force) {
      if (use[k++] && force.reads_depth) found = force.name;
    });
    return found;
  }

  // Those that can act where the depth of the sea is given, or is not.
  ForceSet with_depth(bool given) const {
    ForceSet out = *this;
    int k = 0;
    List::each([&](auto force) { out.use[k++] &= given || !force.reads_depth; });
    return out;
  }

  // A step of drift_step with the forces in use, and what each of them gives.
  DriftStep step(const DriftLaw &law, const ForceInput &at, double step, Impulses &given) const {
    DriftInput in = at.drift;
    double limit = 0.0, creep = 0.0;
    int k = 0, holding = -1;
    List::each([&](auto force) {
      using Force = decltype(force);
      given[k] = {0.0, 0.0};
      if constexpr (Force::holds) {
        holding = k;
        if (use[k]) limit = Force::limit(value[k], at), creep = Force::creep(value[k]);
      } else if (use[k]) {
        const Vec2 push = Force::push(value[k], at);
        given[k] = {step * push.x, step * push.y};
        in.contact = {in.contact.x + push.x, in.contact.y + push.y};
      }
      ++k;
    });
    const bool held = limit > 0.0;
    const DriftStep out =
        held ? grounded_step(law, in, limit, creep, step) : drift_step(law, in, step);
    if (held) given[holding] = out.seabed;
    return out;
  }

  // mean: of the velocities before and after the step.
  static void add(Ledger &sums, const Impulses &given, Vec2 mean) {
    int k = 0;
    List::each([&](auto force) {
      const double work = given[k].x * mean.x + given[k].y * mean.y;
      sums.of[k].impulse_x += given[k].x;
      sums.of[k].impulse_y += given[k].y;
      sums.of[k].energy += force.holds ? -work : work;
      ++k;
    });
  }

  // Names of the numbers of a Ledger, in their order.
  static std::string sum_names() {
    std::string out;
    List::each([&](auto force) {
      const std::string name = force.name;
      out += " impulse_" + name + "_x impulse_" + name + "_y";
      out += (force.holds ? " dissipation_" : " work_") + name;
    });
    return out;
  }
};

using Forces = ForceSet<FLOE_LAW_LIST(FLOE_FORCES)>;

#define FLOE_HOLDS(Force) +Force::holds
static_assert(0 FLOE_FORCES(FLOE_HOLDS) <= 1, "grounded_step knows one friction against rest");
#undef FLOE_HOLDS

}  // namespace floe

#endif
