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
#include "liggghts_error.h"
#include "neigh_list.h"
#include "pair_floe.h"
#include "pair_gran.h"
#include "plugin.h"

using namespace LAMMPS_NS;
namespace slot = floe::slot;

namespace {

constexpr int bond_columns = 12, contact_columns = 5, ridge_columns = 3;

struct Place {
  int i, j;
  int *flag;
  double *history;
};

template <typename Visit>
void each_pair(LAMMPS *lmp, Visit visit) {
  const floe::Parts parts = floe::find_parts(lmp);
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

void put_bond(const double *row, double *h) {
  h[slot::span] = row[0];
  h[slot::bond_thickness] = row[1];
  h[slot::crack_a] = row[2];
  h[slot::crack_b] = row[3];
  std::copy(row + 4, row + bond_columns, h + slot::lo_ax);
}

void get_bond(const double *h, double *row) {
  row[0] = h[slot::span];
  row[1] = h[slot::bond_thickness];
  row[2] = h[slot::crack_a];
  row[3] = h[slot::crack_b];
  std::copy(h + slot::lo_ax, h + slot::lo_ax + 8, row + 4);
}

}  // namespace

extern "C" {

int floe_put_pairs(void *instance, long long bonds, const long long *bond_ids, const double *bond,
                   long long contacts, const long long *contact_ids, const double *contact) {
  return floe::guarded([&] {
    auto *lmp = static_cast<LAMMPS *>(instance);
    const floe::Parts parts = floe::find_parts(lmp);
    const auto bond_row = rows(bonds, bond_ids), contact_row = rows(contacts, contact_ids);
    const int size = parts.pair->dnum();
    parts.floe->forget_records();
    each_pair(lmp, [&](const Place &p) {
      const std::uint64_t pair_key = key(lmp->atom->tag[p.i], lmp->atom->tag[p.j]);
      *p.flag = 0;
      std::fill(p.history, p.history + size, 0.0);
      const auto b = bond_row.find(pair_key);
      if (b != bond_row.end()) {
        *p.flag = 1;
        put_bond(bond + bond_columns * b->second, p.history);
        return;
      }
      const auto c = contact_row.find(pair_key);
      if (c == contact_row.end()) return;
      *p.flag = 1;
      const double *row = contact + contact_columns * c->second;
      p.history[slot::slip] = row[0];
      p.history[slot::rest_overlap] = row[1];
      if (parts.floe->ridging) {
        std::copy(row + 2, row + contact_columns, p.history + slot::ridge_closing);
        p.history[slot::ridge_cover] = parts.floe->cover_between(p.i, p.j);
      }
    });
    parts.floe->history_changed();
  });
}

int floe_count_pairs(void *instance, long long *bonds, long long *contacts) {
  return floe::guarded([&] {
    auto *lmp = static_cast<LAMMPS *>(instance);
    const bool with_bonds = floe::find_parts(lmp).floe->bonds;
    *bonds = *contacts = 0;
    each_pair(lmp, [&](const Place &p) {
      if (!*p.flag || !speaks(lmp->atom, p)) return;
      ++(with_bonds && p.history[slot::span] != 0.0 ? *bonds : *contacts);
    });
  });
}

int floe_get_pairs(void *instance, long long *bond_ids, double *bond, long long *contact_ids,
                   double *contact) {
  return floe::guarded([&] {
    auto *lmp = static_cast<LAMMPS *>(instance);
    const bool with_bonds = floe::find_parts(lmp).floe->bonds;
    const bool with_ridges = floe::find_parts(lmp).floe->ridging;
    each_pair(lmp, [&](const Place &p) {
      if (!*p.flag || !speaks(lmp->atom, p)) return;
      const int a = lmp->atom->tag[p.i], b = lmp->atom->tag[p.j];
      if (with_bonds && p.history[slot::span] != 0.0) {
        *bond_ids++ = std::min(a, b);
        *bond_ids++ = std::max(a, b);
        get_bond(p.history, bond);
        bond += bond_columns;
      } else {
        *contact_ids++ = std::min(a, b);
        *contact_ids++ = std::max(a, b);
        contact[0] = p.history[slot::slip];
        contact[1] = p.history[slot::rest_overlap];
        for (int k = 0; k < ridge_columns; ++k) {
          contact[2 + k] = with_ridges ? p.history[slot::ridge_closing + k] : 0.0;
        }
        contact += contact_columns;
      }
    });
  });
}

}  // extern "C"
