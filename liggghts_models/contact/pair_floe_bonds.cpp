// SPDX-License-Identifier: GPL-2.0-or-later
//
// Pairs that are looked at one by one: bonds that crack, contacts that start and end.
#include <algorithm>
#include <cmath>

#include "atom.h"
#include "fix_floe_integrate.h"
#include "history.h"
#include "load_rows.h"
#include "pair_floe.h"
#include "update.h"

using namespace LAMMPS_NS;

namespace floe {

// Contact without history.
void PairFloe::start_contact(int number) {
  Ends &ends = contacts_.ends[number];
  const int i = ends.i, j = ends.j(), lo = lower(i, j), hi = i + j - lo;
  ends.marked_j |= Ends::mark;
  const ContactConstants c = contact_of(lo, hi);
  contacts_.rows[number] = {0.0, 0.0, c.stiffness, c.damping};
  if (!ridging) return;
  Ridge ridge{0.0, std::min(fix_->thickness[lo], fix_->thickness[hi]),
              edge_share * 2.0 * std::min(atom->radius[lo], atom->radius[hi]),
              cover_between(lo, hi)};
  contacts_.covers[number] = ridge.cover;
  contacts_.ridges[number] = {0.0, ridge.thickness, ridge.length, ridging_limit(ridge)};
}

// Of the way between two centres, the share that ice covers when they meet.
double PairFloe::cover_between(int lo, int hi) const {
  const double *radius = atom->radius, *cover = fix_->cover;
  return (radius[lo] * cover[lo] + radius[hi] * cover[hi]) / (radius[lo] + radius[hi]);
}

void PairFloe::forget_contact(int number) { contacts_.ends[number].marked_j &= ~Ends::mark; }

// With ridging a contact can reach across a gap, and a ridge stays where it was built. Whether this
// one, whose discs do not overlap, makes force.
bool PairFloe::across_gap(int number, double distance, double sum, bool advance) {
  ContactRow &row = contacts_.rows[number];
  if (!((sum - distance) - row.rest <= 0.0)) return true;
  if (!advance) return false;
  row.slip = 0.0;
  // With a rest overlap below 0 ice reaches further than its disc: it is remembered.
  if (contacts_.ridges[number].closing == 0.0 && row.rest >= 0.0) forget_contact(number);
  return false;
}

PairFloe::Taken PairFloe::take_over(int number, double overlap, double force, double energy) {
  const Place place = bonded_.places[number];
  const BondBlock &block = bonded_.block(number);
  const int lo = block.lo[number & 3], hi = block.hi[number & 3];
  const double length = bonded_.at(BondBlock::length, number);
  bonded_.remove(number);
  if (!touches(lo, hi)) {
    *place.flag = 0;
    std::fill(place.history, place.history + history_size(), 0.0);
    return {};
  }
  // This rank's own element first, as in the lists.
  const bool own = lo < atom->nlocal && (hi >= atom->nlocal || lo < hi);
  contacts_.ends.push_back({own ? lo : hi, own ? hi : lo});
  contacts_.rows.push_back({});
  if (ridging) contacts_.add_ridge();
  contacts_.places.push_back(place);
  const int contact_number = static_cast<int>(contacts_.ends.size()) - 1;
  if (!(overlap > 0.0) && !(ridging && force > 0.0)) return {};
  start_contact(contact_number);
  ContactRow &row = contacts_.rows[contact_number];
  row.rest = overlap;
  if (!ridging || !(row.stiffness > 0.0)) return {};
  RidgeRow &ridge = contacts_.ridges[contact_number];
  ridge.length = length;
  ridge.limit = ridging_limit(contacts_.ridge(contact_number));
  const double push = ridge_takeover(force, energy, ridge.limit, row.stiffness);
  row.rest -= push / row.stiffness;
  return {0.5 * push * push / row.stiffness, push};
}

// A bond that cracks or comes to the end of the neighbours' reach.
template <typename Law, bool Exact>
void PairFloe::bond_alone(int number, Losses &lost) {
  using B = BondBlock;
  const auto at = [&](B::Column column) { return bonded_.at(column, number); };
  const int lane = number & 3, i = bonded_.block(number).lo[lane],
            j = bonded_.block(number).hi[lane];
  const Body &lo = fix_->bodies[i], &hi = fix_->bodies[j];
  BondShape shape{{at(B::lo_ax), at(B::lo_ay)},
                  {at(B::lo_bx), at(B::lo_by)},
                  {at(B::hi_ax), at(B::hi_ay)},
                  {at(B::hi_bx), at(B::hi_by)},
                  0.0,
                  0.0,
                  bonded_.crack_a(number),
                  bonded_.crack_b(number)};
  const BondConstants constants{at(B::length), at(B::ratio), at(B::damping), at(B::squeeze)};
  const BondPose pose{{hi.x - lo.x, hi.y - lo.y}, {lo.cos, lo.sin}, {hi.cos, hi.sin},
                      {hi.u - lo.u, hi.v - lo.v}, lo.spin,          hi.spin};
  const BondLine line = bond_line(shape, pose);
  const double share = bonded_.share(number);
  const auto elastic_power = [&] {  // by which the bond's energy falls, W
    double none;
    return pair_power(Law::template force<false>(bond, constants, shape, line, pose, none), pose);
  };
  if (advance_) {
    const double sum = lo.radius + hi.radius, square = pose.d.x * pose.d.x + pose.d.y * pose.d.y;
    if (square > limit2() * sum * sum) fix_->fault_at(i, j);
    const BondShape before = shape;
    const double power = elastic_power(), energy = Law::energy(bond, constants, before, line);
    if (Law::fracture(bond, constants, line, shape)) {
      const bool counted = share == 1.0 || i < atom->nlocal;
      double kept = shape.broken() ? 0.0 : Law::energy(bond, constants, shape, line),
             power_kept = elastic_power();
      if (counted && before.crack_a == 0.0 && before.crack_b == 0.0) lost.cracked += 1.0;
      if (counted && shape.broken()) lost.broken += 1.0;
      if (counted && shape.broken() && log_breakages) {
        note_breakage(number, Law::mode(bond, constants, line, before), before, line, energy);
      }
      bonded_.crack(number, shape.crack_a, shape.crack_b);
      if (shape.broken()) {
        const double distance = std::sqrt(square);
        const double push = -Law::normal_force(bond, constants, before, line);
        const Taken taken = take_over(number, sum - distance, push, energy);
        kept = taken.energy;
        power_kept = taken.push * (pose.v.x * pose.d.x + pose.v.y * pose.d.y) / distance;
      }
      // The force fell at the end of the step: half of its fall did no work on the way there.
      const double late = 0.5 * update->dt * (power - power_kept);
      lost.fracture += share * (energy - kept + late);
      if (shape.broken()) return;
    }
  }
  double watt;
  const PairForce force = Law::template force<true>(bond, constants, shape, line, pose, watt);
  add_load<Exact>(fix_->loads.data(), i, {force.f.x, force.f.y, force.torque_lo, 0.0});
  add_load<Exact>(fix_->loads.data(), j, {-force.f.x, -force.f.y, force.torque_hi, 0.0});
  if (!exact_losses) {
    lost.bond += share * watt;
    return;
  }
  BondLine still = line;
  still.dn = still.dn_slope = still.dt = 0.0;
  const PairForce part = Law::template force<true>(bond, constants, shape, still, pose, watt);
  Load *damped = fix_->damped_bond.data();
  add_load<false>(damped, i, {part.f.x, part.f.y, part.torque_lo, 0.0});
  add_load<false>(damped, j, {-part.f.x, -part.f.y, part.torque_hi, 0.0});
}

#define FLOE_BOND_ALONE(Law)                                    \
  template void PairFloe::bond_alone<Law, true>(int, Losses &); \
  template void PairFloe::bond_alone<Law, false>(int, Losses &);
FLOE_BOND_LAWS(FLOE_BOND_ALONE)
#undef FLOE_BOND_ALONE

}  // namespace floe
