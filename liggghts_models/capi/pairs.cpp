// SPDX-License-Identifier: GPL-2.0-or-later
//
// C interface: bonds and contacts in and out of the history lists. A pair across two ranks is in the
// lists of both; both take it in, and the owner of the lower id gives it out.
#include <algorithm>
#include <cstdint>
#include <unordered_map>

#include "atom.h"
#include "capi.h"
#include "history.h"
#include "lammps.h"
#include "neigh_list.h"
#include "pair_floe.h"
#include "pair_gran.h"
#include "parts.h"

using namespace LAMMPS_NS;
namespace slot = floe::slot;

namespace {

constexpr int bond_width = sizeof floe::bond_columns / sizeof *floe::bond_columns;
constexpr int contact_width = sizeof floe::contact_columns / sizeof *floe::contact_columns;

struct Place {
  int i, j;
  int *flag;
  double *history;
};

// Throws where there are no lists of pairs yet.
floe::Parts parts_of(void *instance) {
  const floe::Parts parts = floe::find_parts(floe::instance_of(instance));
  if (!parts.floe) throw floe::LiggghtsError("there is no pair_style gran model floe");
  if (!parts.pair->list || !parts.pair->listgranhistory || !parts.floe->lists_hold()) {
    throw floe::LiggghtsError("there are no lists of the present pairs: give `run 0` before");
  }
  return parts;
}

// Numbers of a contact's history: without ridging there is no room for a ridge.
int kept_of(const floe::Parts &parts) {
  return parts.floe->ridging ? static_cast<int>(slot::ridge_size)
                             : static_cast<int>(slot::contact_size);
}

template <typename Visit>
void each_pair(const floe::Parts &parts, Visit visit) {
  const PairGran *pair = parts.pair;
  parts.floe->write_history();
  NeighList *list = pair->list, *past = pair->listgranhistory;
  const int size = const_cast<PairGran *>(pair)->dnum();
  for (int ii = 0; ii < list->inum; ++ii) {
    const int i = list->ilist[ii];
    for (int jj = 0; jj < list->numneigh[i]; ++jj) {
      visit(Place{i, list->firstneigh[i][jj] & NEIGHMASK, past->firstneigh[i] + jj,
                  past->firstdouble[i] + size * jj});
    }
  }
}

// Both sides of a rank boundary see the pair; the owner of the lower id speaks for it.
bool speaks(const Atom *atom, const Place &p) {
  return p.j < atom->nlocal || atom->tag[p.i] < atom->tag[p.j];
}

std::uint64_t key(std::uint64_t a, std::uint64_t b) { return a < b ? a << 32 | b : b << 32 | a; }

std::unordered_map<std::uint64_t, long long> rows(long long n, const long long *ids) {
  std::unordered_map<std::uint64_t, long long> out;
  out.reserve(2 * n);
  for (long long k = 0; k < n; ++k) out[key(ids[2 * k], ids[2 * k + 1])] = k;
  return out;
}

}  // namespace

extern "C" {

int floe_put_pairs(void *instance, long long bonds, const long long *bond_ids, const double *bond,
                   long long contacts, const long long *contact_ids, const double *contact) {
  return floe::guarded([&] {
    const floe::Parts parts = parts_of(instance);
    const Atom *atom = floe::instance_of(instance)->atom;
    const auto bond_row = rows(bonds, bond_ids), contact_row = rows(contacts, contact_ids);
    const int size = parts.pair->dnum();
    parts.floe->forget_records();
    each_pair(parts, [&](const Place &p) {
      const std::uint64_t pair_key = key(atom->tag[p.i], atom->tag[p.j]);
      *p.flag = 0;
      std::fill(p.history, p.history + size, 0.0);
      const auto b = bond_row.find(pair_key);
      if (b != bond_row.end()) {
        *p.flag = 1;
        floe::take_columns(floe::bond_columns, bond + bond_width * b->second, p.history);
        return;
      }
      const auto c = contact_row.find(pair_key);
      if (c == contact_row.end()) return;
      *p.flag = 1;
      double all[slot::ridge_size] = {};
      floe::take_columns(floe::contact_columns, contact + contact_width * c->second, all);
      all[slot::ridge_cover] = parts.floe->cover_between(p.i, p.j);
      std::copy(all, all + kept_of(parts), p.history);
    });
    parts.floe->history_changed();
  });
}

int floe_count_pairs(void *instance, long long *bonds, long long *contacts) {
  return floe::guarded([&] {
    const floe::Parts parts = parts_of(instance);
    const Atom *atom = floe::instance_of(instance)->atom;
    const bool with_bonds = parts.floe->bonds;
    *bonds = *contacts = 0;
    each_pair(parts, [&](const Place &p) {
      if (!*p.flag || !speaks(atom, p)) return;
      ++(with_bonds && p.history[slot::span] != 0.0 ? *bonds : *contacts);
    });
  });
}

int floe_get_pairs(void *instance, long long *bond_ids, double *bond, long long *contact_ids,
                   double *contact) {
  return floe::guarded([&] {
    const floe::Parts parts = parts_of(instance);
    const Atom *atom = floe::instance_of(instance)->atom;
    const bool with_bonds = parts.floe->bonds;
    each_pair(parts, [&](const Place &p) {
      if (!*p.flag || !speaks(atom, p)) return;
      const int a = atom->tag[p.i], b = atom->tag[p.j];
      if (with_bonds && p.history[slot::span] != 0.0) {
        *bond_ids++ = std::min(a, b);
        *bond_ids++ = std::max(a, b);
        floe::give_columns(floe::bond_columns, p.history, bond);
        bond += bond_width;
      } else {
        *contact_ids++ = std::min(a, b);
        *contact_ids++ = std::max(a, b);
        double all[slot::ridge_size] = {};
        std::copy(p.history, p.history + kept_of(parts), all);
        floe::give_columns(floe::contact_columns, all, contact);
        contact += contact_width;
      }
    });
  });
}

}  // extern "C"
