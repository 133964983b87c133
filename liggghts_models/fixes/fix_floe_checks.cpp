// SPDX-License-Identifier: GPL-2.0-or-later
//
// fix floe/integrate: what a script may have done before a run that would make its numbers wrong.
#include <mpi.h>

#include <sstream>
#include <string>

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "fix_contact_history.h"
#include "fix_floe_integrate.h"
#include "modify.h"
#include "neighbor.h"

using namespace LAMMPS_NS;

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
// fix moves them.
void FixFloeIntegrate::warn_of_others() {
  if (modify->find_fix_style("floe/integrate", 1)) {
    error->all(FLERR,
               "There may be only one fix floe/integrate: it holds thickness and orientation");
  }
  int moved = 0;
  for (int k = 0; k < modify->nfix; ++k) {
    if (modify->fix[k]->time_integrate) moved |= modify->fix[k]->groupbit;
  }
  bigint still = 0, total = 0;
  for (int i = 0; i < atom->nlocal; ++i) {
    if (!(atom->mask[i] & moved) && atom->type[i] != fixed_type) ++still;
  }
  MPI_Allreduce(&still, &total, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  if (total == 0 || comm->me != 0) return;
  const std::string text = std::to_string(total) +
                           " elements are outside of the group of fix floe/integrate and no other "
                           "fix moves them: they stay where they are";
  error->warning(FLERR, text.c_str());
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
