// SPDX-License-Identifier: GPL-2.0-or-later
//
// Pairs one by one for what LIGGGHTS prints: energies, virials, local computes, breakages.
#include <algorithm>
#include <cmath>

#include "atom.h"
#include "compute_pair_gran_local.h"
#include "fix_floe_integrate.h"
#include "history.h"
#include "pair_floe.h"
#include "pair_gran.h"
#include "pair_state.h"
#include "update.h"

using namespace LAMMPS_NS;

namespace floe {

namespace {

// Evaluated without a step the law gives the force that its history holds.
template <bool Friction>
ContactForce contact_now(const PairFloe &laws, const ContactConstants &constants,
                         const ContactPose &pose, double overlap, double slip, double limit) {
  ContactLoss loss;
  return laws.ridging
             ? contact_force<Friction, true>(laws.contact, constants, pose, overlap, 0.0, slip,
                                             loss, limit)
             : contact_force<Friction>(laws.contact, constants, pose, overlap, 0.0, slip, loss);
}

}  // namespace

BondShape PairFloe::shape_of(int number) {
  using B = BondBlock;
  const auto at = [&](B::Column column) { return bonded_.at(column, number); };
  const double *h = bonded_.places[number].history;
  return {{at(B::lo_ax), at(B::lo_ay)}, {at(B::lo_bx), at(B::lo_by)},
          {at(B::hi_ax), at(B::hi_ay)}, {at(B::hi_bx), at(B::hi_by)},
          h ? h[slot::span] : 0.0,      h ? h[slot::bond_thickness] : 0.0,
          bonded_.crack_a(number),      bonded_.crack_b(number)};
}

BondConstants PairFloe::constants_at(int number) {
  using B = BondBlock;
  return {bonded_.at(B::length, number), bonded_.at(B::ratio, number),
          bonded_.at(B::damping, number), bonded_.at(B::squeeze, number)};
}

BondPose PairFloe::pose_of(int number) {
  const Body &lo = fix_->bodies[bonded_.block(number).lo[number & 3]];
  const Body &hi = fix_->bodies[bonded_.block(number).hi[number & 3]];
  return {{hi.x - lo.x, hi.y - lo.y}, {lo.cos, lo.sin}, {hi.cos, hi.sin},
          {hi.u - lo.u, hi.v - lo.v}, lo.spin,          hi.spin};
}

void PairFloe::each_pair(const std::function<void(const PairState &)> &visit) {
  make_current();
  write_history();
  const LongArray<Body> &bodies = fix_->bodies;
  for (int k = 0; k < bonded_.count; ++k) {
    if (!bonded_.places[k].history) continue;
    const int lo = bonded_.block(k).lo[k & 3], hi = bonded_.block(k).hi[k & 3];
    const BondShape shape = shape_of(k);
    const BondConstants constants = constants_at(k);
    const BondPose pose = pose_of(k);
    const BondLine line = bond_line(shape, pose);
    double watt, energy = 0.0;
    const PairForce force = BondLaws::with(bond.law, [&](auto law) {
      energy = law.energy(bond, constants, shape, line);
      return law.template force<true>(bond, constants, shape, line, pose, watt);
    });
    const bool own = lo < atom->nlocal;
    const double sign = own ? 1.0 : -1.0;
    visit({own ? lo : hi,
           own ? hi : lo,
           {sign * pose.d.x, sign * pose.d.y},
           {sign * force.f.x, sign * force.f.y},
           own ? force.torque_lo : force.torque_hi,
           own ? force.torque_hi : force.torque_lo,
           energy,
           bonded_.share(k),
           bonded_.places[k].history,
           k});
  }
  for (std::size_t k = 0; k < contacts_.ends.size(); ++k) {
    if (!contacts_.ends[k].touching()) continue;
    const int i = contacts_.ends[k].i, j = contacts_.ends[k].j();
    const Body &one = bodies[i], &two = bodies[j];
    const ContactRow &row = contacts_.rows[k];
    const Vec2 d{two.x - one.x, two.y - one.y};
    const ContactPose pose{d,          std::sqrt(d.x * d.x + d.y * d.y), one.radius,
                           two.radius, {two.u - one.u, two.v - one.v},   one.spin,
                           two.spin};
    double rest = row.rest;
    const double overlap = ridging ? ((one.radius + two.radius) - pose.distance) - rest
                                   : effective_overlap(pose, rest);
    PairState out{
        i, j, d, {}, 0.0, 0.0, 0.0, j < atom->nlocal ? 1.0 : 0.5, contacts_.places[k].history, -1};
    if (overlap > 0.0) {
      const ContactConstants constants =
          constants_now(contact, {row.stiffness, row.damping}, overlap);
      const double limit = ridging ? contacts_.ridges[k].limit : 0.0;
      const ContactForce force =
          friction ? contact_now<true>(*this, constants, pose, overlap, row.slip, limit)
                   : contact_now<false>(*this, constants, pose, overlap, row.slip, limit);
      out.f = force.f;
      out.torque_i = force.torque_one;
      out.torque_j = force.torque_two;
      out.energy = contact_energy(contact, row.stiffness, overlap, friction ? row.slip : 0.0);
    }
    visit(out);
  }
}

void PairFloe::tally(PairGran *pg) {
  each_pair([&](const PairState &p) {
    pg->ev_tally_xyz(p.i, p.j, atom->nlocal, 0, p.energy, 0.0, p.f.x, p.f.y, 0.0, -p.d.x, -p.d.y,
                     0.0);
  });
}

// compute pair/gran/local lists the pairs whose discs overlap, and counts on being given just those.
void PairFloe::list_pairs(PairGran *pg) {
  ComputePairGranLocal *out = pg->cpl();
  if (!out) return;
  each_pair([&](const PairState &p) {
    const double sum = atom->radius[p.i] + atom->radius[p.j];
    if (!(p.d.x * p.d.x + p.d.y * p.d.y < sum * sum)) return;
    out->add_pair(p.i, p.j, p.f.x, p.f.y, 0.0, 0.0, 0.0, p.torque_i, p.history, nullptr);
  });
  out->pair_finalize();
}

BondState PairFloe::bond_state(int number) {
  const BondShape shape = shape_of(number);
  const BondPose pose = pose_of(number);
  const BondLine line = bond_line(shape, pose);
  const auto [least, most] = bond_range(line, shape);
  const int lo = bonded_.block(number).lo[number & 3], hi = bonded_.block(number).hi[number & 3];
  const Body &body = fix_->bodies[lo];
  return {
      lo,
      hi,
      std::max(0.0, shape.xi_hi() - shape.xi_lo()),
      bond.young * least / shape.span,
      bond.young * most / shape.span,
      bond.shear * line.dt / shape.span,
      shape.thickness,
      shape.span,
      bonded_.at(BondBlock::length, number),
      BondLaws::with(bond.law,
                     [&](auto law) { return law.energy(bond, constants_at(number), shape, line); }),
      {body.x + line.arm_lo.x, body.y + line.arm_lo.y}};
}

void PairFloe::note_breakage(int number, BreakageMode mode, const BondShape &before,
                             const BondLine &line, double energy) {
  BondShape shape = shape_of(number);
  shape.crack_a = before.crack_a;
  shape.crack_b = before.crack_b;
  const auto [least, most] = bond_range(line, shape);
  const int lo = bonded_.block(number).lo[number & 3], hi = bonded_.block(number).hi[number & 3];
  const double failed = mode == BreakageMode::compression ? least : most;
  const double stress = bond.young * failed / shape.span;  // Pa
  const Body &body = fix_->bodies[lo];
  breakages.push_back({update->ntimestep, atom->tag[lo], atom->tag[hi], body.x + line.arm_lo.x,
                       body.y + line.arm_lo.y, fix_->elapsed(), mode, stress,
                       bond.shear * line.dt / shape.span, shape.thickness, energy});
}

}  // namespace floe
