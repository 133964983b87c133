// SPDX-License-Identifier: GPL-2.0-or-later
//
// One evaluation of all pairs: which touch, and which code takes them.
#include "pair_floe.h"

#include <algorithm>
#include <cmath>

#include "atom.h"
#include "bond_batch.h"
#include "contact_batch.h"
#include "error.h"
#include "fix_floe_integrate.h"
#include "load_rows.h"
#include "pair_gran.h"
#include "update.h"

using namespace LAMMPS_NS;

namespace floe {

namespace {

// Calls with std::true_type or std::false_type.
template <typename Call>
void choose(bool value, Call call) {
  value ? call(std::true_type{}) : call(std::false_type{});
}

template <Damping Value>
using damping_constant = std::integral_constant<Damping, Value>;

template <typename Call>
void choose_damping(double ratio, bool exact, Call call) {
  if (ratio == 0.0) {
    call(damping_constant<Damping::none>{});
  } else {
    exact ? call(damping_constant<Damping::exact>{}) : call(damping_constant<Damping::counted>{});
  }
}

}  // namespace

// Whether the integrator wrote the bodies of this rank's own elements.
bool PairFloe::gather_bodies() {
  if (fix_->use_orientation) fix_->send_orientations();
  const int own = atom->nlocal, all = own + atom->nghost;
  LongArray<Body> &bodies = fix_->bodies;
  const bool current = fix_->fused && static_cast<int>(bodies.size()) >= own && !stale_;
  bodies.resize(all);
  const double *const *x = atom->x, *const *v = atom->v, *const *omega = atom->omega;
  const double *const *turn = fix_->turn;
  const double *radius = atom->radius;
  for (int i = current ? own : 0; i < all; ++i) {
    bodies[i] = {x[i][0],     x[i][1],    v[i][0],    v[i][1],
                 omega[i][2], turn[i][0], turn[i][1], radius[i]};
  }
  return current;
}

void PairFloe::clear_loads(bool current) {
  const int own = atom->nlocal, all = own + atom->nghost;
  LongArray<Load> &loads = fix_->loads;
  if (current && fix_->loads_cleared && !deterministic) {
    loads.resize(all);
    std::fill(loads.begin() + own, loads.end(), Load{});
  } else {
    loads.assign(deterministic ? 2 * all : all, Load{});
  }
  fix_->loads_cleared = false;
  if (exact_losses) {
    fix_->damped_bond.assign(bonds ? all : 0, Load{});
    fix_->damped_contact.assign(all, Load{});
  }
}

// All listed pairs that are not bonded: those that touch are collected and evaluated several at once.
template <typename Terms>
void PairFloe::loop_contacts(ContactSums &sums) {
  constexpr int room = 256;
  int touching[room + 3], found = 0;
  const bool advance = advance_;
  const ContactTask task{contact,
                         Terms::ridging ? this : nullptr,
                         advance ? update->dt : 0.0,
                         advance,
                         atom->nlocal,
                         fix_->bodies.data(),
                         fix_->loads.data(),
                         fix_->damped_contact.data(),
                         contacts_.ends.data(),
                         contacts_.rows.data(),
                         contacts_.ridges.data(),
                         contacts_.covers.data()};
  const Body *bodies = task.bodies;
  const Ends *ends = task.ends;
  const int count = static_cast<int>(contacts_.ends.size());
  for (int k = 0; k < count; ++k) {
    const Body &one = bodies[ends[k].i], &two = bodies[ends[k].j()];
    const double dx = two.x - one.x, dy = two.y - one.y, sum = one.radius + two.radius;
    const double square = dx * dx + dy * dy;
    if (square >= sum * sum) {
      if (!ends[k].touching()) continue;
      if constexpr (Terms::ridging) {
        if (!across_gap(k, std::sqrt(square), sum, advance)) continue;
      } else {
        forget_contact(k);
        continue;
      }
    } else if (!ends[k].touching()) {
      start_contact(k);
    }
    touching[found++] = k;
    if (found < room) continue;
    evaluate_contacts<Terms>(task, touching, found, sums);
    found = 0;
  }
  if (found) evaluate_contacts<Terms>(task, touching, found, sums);
}

template <typename Law, bool Exact>
void PairFloe::evaluate_bonds_of(Losses &lost) {
  odd_.clear();
  const BondTask task{
      bond, limit2(), advance_, fix_->bodies.data(), fix_->loads.data(), fix_->damped_bond.data()};
  choose_damping(bond.damping, exact_losses, [&](auto damping) {
    lost.bond = evaluate_bonds<Law, damping, Exact>(task, bonded_, odd_);
  });
  for (const int number : odd_) bond_alone<Law, Exact>(number, lost);
}

template <typename Law, bool Exact>
void PairFloe::evaluate_contacts_of(ContactSums &sums) {
  choose_damping(contact.damping, exact_losses, [&](auto damping) {
    choose(friction, [&](auto with_friction) {
      choose(ridging, [&](auto with_ridging) {
        // Without a constant stiffness there is no ridging: settings() refuses it.
        constexpr bool ridges = with_ridging && Law::constant;
        loop_contacts<ContactTerms<with_friction, ridges, damping, Exact, Law>>(sums);
      });
    });
  });
}

template <bool Exact>
void PairFloe::evaluate_exactly_or_not() {
  Losses lost;
  if (bonds) {
    BondLaws::with(bond.law, [&](auto law) { evaluate_bonds_of<decltype(law), Exact>(lost); });
  }
  ContactSums sums;
  ContactLaws::with(contact.law,
                    [&](auto law) { evaluate_contacts_of<decltype(law), Exact>(sums); });
  lost.contact += sums.damping.total();
  lost.friction += sums.friction.total();
  lost.ridging += sums.ridging;
  lost.add_to(fix_->ledger, advance_ ? update->dt : 0.0);
}

// Both rows of an element as one, in the first half of the array.
void PairFloe::fold_exact_sums() {
  Load *loads = fix_->loads.data();
  for (int i = 0; i < atom->nlocal; ++i) {
    const Load &a = loads[2 * i], &b = loads[2 * i + 1];
    const Load sum{a.fx + b.fx, a.fy + b.fy, a.torque + b.torque, a.ridged + b.ridged};
    if (std::fabs(sum.fx) > largest_force || std::fabs(sum.fy) > largest_force ||
        std::fabs(sum.torque) > largest_force * torque_grid) {
      error->one(FLERR, "deterministic: a force is beyond 8e12 N, up to which sums are exact");
    }
    loads[i] = sum;
  }
}

void PairFloe::make_current() {
  if (!stale_) return;
  gather_bodies();
  read_history();
}

void PairFloe::compute_force(PairGran *pg, int eflag, int vflag, int addflag) {
  pair_ = pg;
  if (addflag) return list_pairs(pg);  // compute pair/gran/local asks, between two evaluations
  if (eflag || vflag)
    pg->ev_setup(eflag, vflag);
  else
    pg->evflag = pg->vflag_fdotr = 0;
  listed_ = atom->nlocal;
  ++evaluations_;
  advance_ = pg->shearupdate() != 0;
  check_lists();
  clear_loads(gather_bodies());
  if (stale_) read_history();
  if (deterministic) {
    evaluate_exactly_or_not<true>();
    fold_exact_sums();
  } else {
    evaluate_exactly_or_not<false>();
  }
  if (pg->computeflag() && !fix_->fused) fix_->write_forces();
  if (ridging) {
    for (int i = 0; i < atom->nlocal; ++i) fix_->ridged_area[i] += fix_->loads[i].ridged;
  }
  if (pg->evflag) tally(pg);
}

}  // namespace floe
