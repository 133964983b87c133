// SPDX-License-Identifier: GPL-2.0-or-later
#include "bond_command.h"

#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "atom.h"
#include "comm.h"
#include "defaults.h"
#include "error.h"
#include "fix_floe_integrate.h"
#include "history.h"
#include "neigh_list.h"
#include "number.h"
#include "pair_floe.h"
#include "pair_gran.h"
#include "plugin.h"

using namespace LAMMPS_NS;
namespace slot = floe::slot;

namespace {

// End of the line at a distance along the tangent, in the body frame of an element whose centre is
// `arm` away from the line's centre along the normal.
void put_end(double *h, double cos, double sin, floe::Vec2 n, double arm, double along) {
  const floe::Vec2 t{-n.y, n.x};
  const floe::Vec2 p{arm * n.x + along * t.x, arm * n.y + along * t.y};
  h[0] = cos * p.x + sin * p.y;
  h[1] = cos * p.y - sin * p.x;
}

}  // namespace

void BondCommand::command(int narg, char **arg) {
  double gap = -1.0, thickness = -1.0, width = floe::defaults::edge_share;
  for (int k = 0; k + 1 < narg; k += 2) {
    const std::string key = arg[k];
    double value;
    if (const char *fault = floe::number_fault(arg[k + 1], value)) {
      error->all(FLERR, ("floe_bonds: " + key + fault).c_str());
    }
    if (key == "gap")
      gap = value;
    else if (key == "thickness")
      thickness = value;
    else if (key == "width")
      width = value;
    else
      error->all(FLERR, ("floe_bonds: unknown keyword " + key).c_str());
  }
  if (narg % 2 || !(gap >= 0.0) || !(thickness > 0.0) || !(width > 0.0)) {
    error->all(FLERR, "floe_bonds needs gap (not negative), thickness and width (above 0)");
  }
  const floe::Parts parts = floe::find_parts(lmp);
  if (!parts.floe || !parts.floe->bonds) {
    error->all(FLERR, "floe_bonds needs pair_style gran model floe bonds yes");
  }
  const int holds = parts.floe->lists_hold();
  int all_hold = 0;
  MPI_Allreduce(&holds, &all_hold, 1, MPI_INT, MPI_MIN, world);
  if (!all_hold) {
    error->all(FLERR,
               "floe_bonds needs lists of the present neighbours: give `run 0` right before it");
  }
  const NeighList *list = parts.pair->list, *past = parts.pair->listgranhistory;
  const int size = parts.pair->dnum();
  double **x = atom->x, **turn = parts.fix->turn;
  double made = 0.0;
  parts.floe->write_history();
  for (int ii = 0; ii < list->inum; ++ii) {
    const int i = list->ilist[ii];
    for (int jj = 0; jj < list->numneigh[i]; ++jj) {
      const int j = list->firstneigh[i][jj] & NEIGHMASK;
      const int lo = atom->tag[i] < atom->tag[j] ? i : j, hi = i + j - lo;
      const floe::Vec2 d{x[hi][0] - x[lo][0], x[hi][1] - x[lo][1]};
      const double span = std::sqrt(d.x * d.x + d.y * d.y);
      const double ri = atom->radius[lo], rj = atom->radius[hi];
      if (span > ri + rj + gap) continue;
      double *h = past->firstdouble[i] + static_cast<std::ptrdiff_t>(size) * jj;
      const bool new_bond = !floe::is_bond(past->firstneigh[i][jj], h);
      past->firstneigh[i][jj] = 1;
      std::fill(h, h + size, 0.0);
      const floe::Vec2 n{d.x / span, d.y / span};
      const double half = width * std::min(ri, rj), arm = span * ri / (ri + rj);
      // The tangent (-n_y, n_x) runs from a to b: looking along it the lower id lies on the left.
      put_end(h + slot::lo_ax, turn[lo][0], turn[lo][1], n, arm, -half);
      put_end(h + slot::lo_bx, turn[lo][0], turn[lo][1], n, arm, half);
      put_end(h + slot::hi_ax, turn[hi][0], turn[hi][1], n, arm - span, -half);
      put_end(h + slot::hi_bx, turn[hi][0], turn[hi][1], n, arm - span, half);
      h[slot::span] = span;
      h[slot::bond_thickness] = thickness;
      if (span > parts.floe->reach * (ri + rj)) {
        error->one(FLERR, "floe_bonds: a bond is longer than the pair style's reach");
      }
      if (new_bond) {
        parts.fix->bonds_made[i] += 1.0;
        if (j < atom->nlocal) parts.fix->bonds_made[j] += 1.0;
      }
      made += j < atom->nlocal ? 1.0 : 0.5;
    }
  }
  parts.floe->history_changed();
  double total;
  MPI_Allreduce(&made, &total, 1, MPI_DOUBLE, MPI_SUM, world);
  const std::string text = "floe_bonds: " + std::to_string(std::llround(total)) + " bonds\n";
  if (comm->me == 0 && screen) std::fputs(text.c_str(), screen);
  if (comm->me == 0 && logfile) std::fputs(text.c_str(), logfile);
}
