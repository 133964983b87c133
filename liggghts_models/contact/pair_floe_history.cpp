// SPDX-License-Identifier: GPL-2.0-or-later
//
// Between LIGGGHTS' history of the listed pairs and the records that the loops work on.
#include <algorithm>
#include <cstddef>

#include "atom.h"
#include "error.h"
#include "fix_floe_integrate.h"
#include "history.h"
#include "modify.h"
#include "neigh_list.h"
#include "neighbor.h"
#include "pair_floe.h"
#include "pair_gran.h"
#include "update.h"

using namespace LAMMPS_NS;

namespace floe {

int PairFloe::lower(int i, int j) const { return atom->tag[i] < atom->tag[j] ? i : j; }

bool PairFloe::touches(int i, int j) const {
  const int *type = atom->type, fixed = FixFloeIntegrate::fixed_type;
  return fixed_contacts || (type[i] != fixed && type[j] != fixed);
}

// An element that never moves takes part like an infinitely heavy one. In the order of the ids, so
// that both sides of a rank boundary find the same bits.
double PairFloe::reduced_mass(int i, int j) const {
  const double *mass = atom->rmass;
  if (atom->type[i] == FixFloeIntegrate::fixed_type) return mass[j];
  if (atom->type[j] == FixFloeIntegrate::fixed_type) return mass[i];
  const int lo = lower(i, j), hi = i + j - lo;
  return mass[lo] * mass[hi] / (mass[lo] + mass[hi]);
}

ContactSide PairFloe::side_of(int i) const { return {atom->radius[i], fix_->thickness[i]}; }

ContactConstants PairFloe::contact_of(int lo, int hi) const {
  return ContactLaws::with(contact.law, [&](auto law) {
    const double stiffness = law.stiffness(contact, side_of(lo), side_of(hi));
    const double bound = law.constant ? update->dt : 0.0;
    return ContactConstants{stiffness,
                            contact_damping(contact, stiffness, reduced_mass(lo, hi), bound)};
  });
}

BondConstants PairFloe::constants_of(const BondShape &shape, int i, int j) const {
  return bond_constants(bond, shape, compressive_strength(shape.thickness), reduced_mass(i, j));
}

void PairFloe::read_history() {
  const NeighList *list = pair_->list, *past = pair_->listgranhistory;
  const int size = pair_->dnum();
  bonded_.clear();
  contacts_.clear();
  for (int ii = 0; ii < list->inum; ++ii) {
    const int i = list->ilist[ii], count = list->numneigh[i];
    for (int jj = 0; jj < count; ++jj) {
      const int j = list->firstneigh[i][jj] & NEIGHMASK;
      double *h = past->firstdouble[i] + static_cast<std::ptrdiff_t>(size) * jj;
      int *flag = past->firstneigh[i] + jj;
      if (bonds && is_bond(*flag, h)) {
        const int lo = lower(i, j), hi = i + j - lo;
        const BondShape shape = bond_shape(h);
        const double share = j < atom->nlocal ? 1.0 : 0.5;
        bonded_.add(lo, hi, share, shape, constants_of(shape, lo, hi), {h, flag});
        continue;
      }
      if (!touches(i, j)) continue;
      const int number = static_cast<int>(contacts_.ends.size());
      contacts_.ends.push_back({i, j});
      contacts_.rows.push_back({});
      if (ridging) contacts_.add_ridge();
      contacts_.places.push_back({h, flag});
      if (!*flag) continue;
      start_contact(number);
      contacts_.rows[number].slip = h[slot::slip];
      contacts_.rows[number].rest = h[slot::rest_overlap];
      if (!ridging || h[slot::ridge_length] == 0.0) continue;
      const Ridge ridge = ridge_at(h);
      contacts_.ridges[number] = {ridge.closing, ridge.thickness, ridge.length,
                                  ridging_limit(ridge)};
      contacts_.covers[number] = ridge.cover;
    }
  }
  stale_ = false;
  read_from_ = lists_made();
}

std::pair<std::int64_t, std::int64_t> PairFloe::lists_made() const {
  return {neighbor->ncalls, neighbor->lastcall};
}

void PairFloe::check_lists() const {
  if (stale_ || read_from_ == lists_made()) return;
  error->one(FLERR,
             "new lists of neighbours were made while the pair style held records of the old ones: "
             "whoever makes them must call lists_change() before");
}

void PairFloe::write_history() {
  if (stale_) return;
  check_lists();
  for (int k = 0; k < bonded_.count; ++k) {
    double *h = bonded_.places[k].history;
    if (!h) continue;
    h[slot::crack_a] = bonded_.crack_a(k);
    h[slot::crack_b] = bonded_.crack_b(k);
  }
  for (std::size_t k = 0; k < contacts_.ends.size(); ++k) {
    double *h = contacts_.places[k].history;
    int &flag = *contacts_.places[k].flag;
    const bool touching = contacts_.ends[k].touching();
    if (!touching && !flag) continue;
    std::fill(h, h + history_size(), 0.0);
    flag = touching;
    if (!touching) continue;
    h[slot::slip] = contacts_.rows[k].slip;
    h[slot::rest_overlap] = contacts_.rows[k].rest;
    if (!ridging) continue;
    put_ridge(contacts_.ridge(static_cast<int>(k)), h);
  }
}

void PairFloe::lists_change() {
  keep_history();
  stale_ = true;
}

void PairFloe::keep_history() {
  if (stale_) return;
  write_history();
  copy_to_elements();
}

void PairFloe::history_changed() {
  stale_ = true;
  ++evaluations_;
  copy_to_elements();
}

void PairFloe::copy_to_elements() {
  modify->find_fix_style_strict("contacthistory", 0)->pre_exchange();
}

bool PairFloe::lists_hold() const {
  return listed_ == atom->nlocal && pair_ && pair_->list && pair_->list->inum == listed_;
}

}  // namespace floe
