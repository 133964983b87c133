// SPDX-License-Identifier: GPL-2.0-or-later
#include "wall_law.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fix_floe_integrate.h"
#include "pair_floe.h"

using namespace LAMMPS_NS;

namespace floe {

namespace {

// Ice within this share of an element's radius is not taken by ridges against a wall.
constexpr double core_share = 0.3;

template <bool Friction, bool Ridging>
ContactForce evaluate(const WallLaw &wall, int i, double mass, const ContactPose &pose, double step,
                      WallHistory &h) {
  const PairFloe &laws = *wall.laws;
  // All the spring is the element's ice, all the mass its own.
  const double stiffness = wall.stiffness(i, pose.radius_one);
  const bool constant = ContactLaws::with(laws.contact.law, [](auto law) { return law.constant; });
  const double bound = constant ? wall.fix->step_length() : 0.0;
  const ContactConstants at_once{stiffness, contact_damping(laws.contact, stiffness, mass, bound)};
  const bool advance = step > 0.0;
  double rest = h.rest_overlap, slip = h.slip, limit = 0.0;
  double overlap =
      Ridging ? (pose.radius_one - pose.distance) - rest : effective_overlap(pose, rest);
  if (advance) h.rest_overlap = rest;
  if (!(overlap > 0.0) && !std::isnan(overlap)) {
    if (advance) h.slip = 0.0;
    return {};
  }
  Ledger &ledger = wall.fix->ledger;
  if constexpr (Ridging) {
    if (h.ridge.length == 0.0) {
      h.ridge.thickness = wall.fix->thickness[i];
      h.ridge.length = 2.0 * edge_share * pose.radius_one;
      h.ridge.cover = wall.fix->cover[i];
    }
    // A disc may begin with its centre right at the wall, where no ice is left between them.
    const double span = pose.radius_one - std::min(rest, 0.5 * pose.radius_one);
    // No ridge is built nearer to the centre: there the wall only resists, and is never passed.
    const double room = (1.0 - core_share) * pose.radius_one - rest;
    const bool builds = room > 0.0;
    const double closed =
        advance && builds ? laws.close_ridge(stiffness, span, overlap, h.ridge) : 0.0;
    if (closed > 0.0) {
      h.rest_overlap = rest + closed;
      overlap = (pose.radius_one - pose.distance) - h.rest_overlap;
      ledger.dissipation_ridging += stiffness * overlap * closed;
      wall.fix->ridged_area[i] += h.ridge.length * closed;
    }
    limit = builds ? laws.ridging_limit(h.ridge) : std::numeric_limits<double>::max();
  }
  ContactLoss loss;
  const ContactConstants constants = constants_now(laws.contact, at_once, overlap);
  const ContactForce out = contact_force<Friction, Ridging>(laws.contact, constants, pose, overlap,
                                                            step, slip, loss, limit);
  if (advance) {
    h.slip = slip;
    ledger.dissipation_contact += loss.damping * step;
    ledger.dissipation_friction += loss.friction;
  }
  return out;
}

}  // namespace

double WallLaw::stiffness(int i, double radius) const {
  return ContactLaws::with(laws->contact.law, [&](auto law) {
    return law.wall_stiffness(laws->contact, {radius, fix->thickness[i]});
  });
}

double WallLaw::overlap(const ContactPose &pose, const WallHistory &h) const {
  double rest = h.rest_overlap;
  return laws->ridging ? (pose.radius_one - pose.distance) - rest : effective_overlap(pose, rest);
}

double WallLaw::energy(int i, const ContactPose &pose, const WallHistory &h) const {
  return contact_energy(laws->contact, stiffness(i, pose.radius_one), overlap(pose, h),
                        laws->friction ? h.slip : 0.0);
}

ContactForce WallLaw::force(int i, double mass, const ContactPose &pose, double step,
                            WallHistory &h) const {
  if (laws->friction) {
    return laws->ridging ? evaluate<true, true>(*this, i, mass, pose, step, h)
                         : evaluate<true, false>(*this, i, mass, pose, step, h);
  }
  return laws->ridging ? evaluate<false, true>(*this, i, mass, pose, step, h)
                       : evaluate<false, false>(*this, i, mass, pose, step, h);
}

}  // namespace floe
