// SPDX-License-Identifier: GPL-2.0-or-later
//
// fix floe/integrate: what a script may have done before a run that would make its numbers wrong.
#include <mpi.h>

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "fix_contact_history.h"
#include "fix_floe_integrate.h"
#include "history.h"
#include "modify.h"
#include "neigh_list.h"
#include "neighbor.h"
#include "pair_floe.h"
#include "pair_gran.h"
#include "plugin.h"

using namespace LAMMPS_NS;

namespace {

// Bonds of this rank's elements, in order: the element and the one at the bond's other end, by ids.
using BondEnds = std::vector<std::pair<int, int>>;

BondEnds held_bonds(const Atom &atom, FixContactHistory &history) {
  BondEnds out;
  for (int i = 0; i < atom.nlocal; ++i) {
    for (int k = 0; k < history.n_partner(i); ++k) {
      if (!floe::is_bond(1, history.contacthistory(i, k))) continue;
      out.emplace_back(atom.tag[i], history.partner(i, k));
    }
  }
  std::sort(out.begin(), out.end());
  return out;
}

BondEnds listed_bonds(const Atom &atom, PairGran &pair) {
  BondEnds out;
  const NeighList &list = *pair.list, &past = *pair.listgranhistory;
  const std::ptrdiff_t size = pair.dnum();
  for (int ii = 0; ii < list.inum; ++ii) {
    const int i = list.ilist[ii];
    for (int jj = 0; jj < list.numneigh[i]; ++jj) {
      if (!floe::is_bond(past.firstneigh[i][jj], past.firstdouble[i] + size * jj)) continue;
      const int j = list.firstneigh[i][jj] & NEIGHMASK;
      out.emplace_back(atom.tag[i], atom.tag[j]);
      if (j < atom.nlocal) out.emplace_back(atom.tag[j], atom.tag[i]);
    }
  }
  std::sort(out.begin(), out.end());
  return out;
}

// How many of all ranks' wanted ids some rank owns.
int count_present(const std::vector<int> &wanted, std::vector<int> owned, MPI_Comm world) {
  int ranks, own = static_cast<int>(wanted.size()), all = 0, here = 0, total = 0;
  MPI_Comm_size(world, &ranks);
  std::vector<int> counts(ranks), starts(ranks);
  MPI_Allgather(&own, 1, MPI_INT, counts.data(), 1, MPI_INT, world);
  for (int k = 0; k < ranks; ++k) {
    starts[k] = all;
    all += counts[k];
  }
  std::vector<int> ids(all);
  MPI_Allgatherv(wanted.data(), own, MPI_INT, ids.data(), counts.data(), starts.data(), MPI_INT,
                 world);
  std::sort(owned.begin(), owned.end());
  for (const int id : ids) here += std::binary_search(owned.begin(), owned.end(), id);
  MPI_Allreduce(&here, &total, 1, MPI_INT, MPI_SUM, world);
  return total;
}

}  // namespace

// Elements above each other would be at one place for laws in the plane.
void FixFloeIntegrate::check_plane() {
  int above = 0, any = 0;
  for (int i = 0; i < atom->nlocal; ++i) above |= atom->x[i][2] != 0.0;
  MPI_Allreduce(&above, &any, 1, MPI_INT, MPI_MAX, world);
  if (any) {
    error->all(
        FLERR,
        "Fix floe/integrate needs all elements at z = 0: a region for create_atoms must hold "
        "no more than that layer of the lattice");
  }
}

// Elements outside of the group stay where they are, as with LIGGGHTS' own integrators, unless another
// fix moves them. None may be moved twice.
void FixFloeIntegrate::check_others() {
  const auto count = [this](auto is) {
    bigint own = 0, all = 0;
    for (int i = 0; i < atom->nlocal; ++i) own += is(i) ? 1 : 0;
    MPI_Allreduce(&own, &all, 1, MPI_LMP_BIGINT, MPI_SUM, world);
    return all;
  };
  if (modify->find_fix_style("floe/integrate", 1)) {
    error->all(FLERR,
               "There may be only one fix floe/integrate: it holds thickness and orientation");
  }
  if (neighbor->neigh_once()) {
    error->all(
        FLERR,
        "Fix floe/integrate: with neigh_modify once yes floes that meet later in a run would "
        "pass through each other; give once no");
  }
  int moved = 0;
  for (int k = 0; k < modify->nfix; ++k) {
    const Fix *fix = modify->fix[k];
    if (fix == this || !fix->time_integrate) continue;
    moved |= fix->groupbit;
    const bigint twice =
        count([&](int i) { return atom->mask[i] & fix->groupbit && atom->mask[i] & groupbit; });
    if (!twice) continue;
    const std::string text = "Fix floe/integrate: " + std::to_string(twice) +
                             " floes of its group are moved by another fix too (" + fix->id +
                             "): each floe must be in the group of one of them only";
    error->all(FLERR, text.c_str());
  }
  const bigint still = count(
      [&](int i) { return !(atom->mask[i] & (moved | groupbit)) && atom->type[i] != fixed_type; });
  if (comm->me != 0) return;
  if (still) {
    const std::string text = std::to_string(still) +
                             " elements are outside of the group of fix floe/integrate and no "
                             "other fix moves them: they stay where they are";
    error->warning(FLERR, text.c_str());
  }
  if (modify->find_fix_style("adapt", 0)) {
    error->warning(
        FLERR,
        "fix adapt changes the mass of a disc with the cube of its diameter, also in two "
        "dimensions: `set group ID density` makes it anew");
  }
}

// LIGGGHTS forgets a pair that it does not list: a bond would go without a word. At the beginning of a
// run each bond that elements hold is listed, or its partner is gone.
void FixFloeIntegrate::check_listed() const {
  const floe::Parts parts = floe::find_parts(lmp);
  auto *history =
      dynamic_cast<FixContactHistory *>(modify->find_fix_style_strict("contacthistory", 0));
  if (ask_fused || !parts.floe || !parts.floe->bonds || !history) return;
  const BondEnds held = held_bonds(*atom, *history), listed = listed_bonds(*atom, *parts.pair);
  BondEnds lost;
  std::set_difference(held.begin(), held.end(), listed.begin(), listed.end(),
                      std::back_inserter(lost));
  std::vector<int> partners;
  for (const auto &ends : lost) partners.push_back(ends.second);
  const int present = count_present(partners, {atom->tag, atom->tag + atom->nlocal}, world);
  if (!present) return;
  const std::string text =
      "Fix floe/integrate: " + std::to_string((present + 1) / 2) +
      " bonds would be lost, because their floes are no neighbours any more: neigh_modify exclude "
      "takes them out of the lists, or they were moved apart between the runs";
  error->all(FLERR, text.c_str());
}

// Bonds lie in the frames of the elements, whose angles this fix holds; LIGGGHTS finds the history of a
// pair by the ids of its elements.
void FixFloeIntegrate::check_kept() {
  auto *history =
      dynamic_cast<FixContactHistory *>(modify->find_fix_style_strict("contacthistory", 0));
  int own[2] = {0, 0}, any[2];  // a pair with a history, an element with another id than it had
  for (int i = 0; i < atom->nlocal; ++i) {
    own[0] |= history && history->n_partner(i) > 0;
    own[1] |= kept_ids_[i] != 0 && kept_ids_[i] != atom->tag[i];
  }
  MPI_Allreduce(own, any, 2, MPI_INT, MPI_MAX, world);
  if (any[0] && !known_) {
    error->all(
        FLERR,
        "Fix floe/integrate: angles and thicknesses of floes that have bonds or contacts are "
        "lost, because their fix was deleted or has another ID in the restart file; change "
        "keywords with fix_modify, and keep the ID");
  }
  if (any[0] && any[1]) {
    error->all(FLERR,
               "Fix floe/integrate: floes have other ids than in the last run, and their bonds "
               "would be lost; give delete_atoms the words `compress no`");
  }
  known_ = true;
}

// LIGGGHTS knows a pair by its ids: it cannot keep two histories for one that meets twice.
void FixFloeIntegrate::check_period() const {
  const double reach = neighbor->cutneighmax;
  for (int k = 0; k < 2; ++k) {
    if (!domain->periodicity[k] || domain->prd[k] >= 2.0 * reach) continue;
    std::ostringstream text;
    text
        << "Fix floe/integrate: the periodic box is " << domain->prd[k] << " m wide in "
        << "xy"[k] << ", less than twice the " << reach
        << " m up to which neighbours are listed: two floes would meet on both sides; make the box "
        << "wider";
    error->all(FLERR, text.str().c_str());
  }
}
