// SPDX-License-Identifier: GPL-2.0-or-later
#include "wall_floe.h"

#include "atom.h"
#include "error.h"
#include "fix_floe_integrate.h"
#include "fix_wall_gran.h"
#include "history.h"
#include "pair_floe.h"
#include "plugin.h"
#include "update.h"
#include "wall_law.h"

using namespace LAMMPS_NS;

namespace floe {

void WallFloe::settings(int narg, char **arg, LIGGGHTS::IContactHistorySetup *setup) {
  if (narg > 0) {
    const std::string text = std::string("fix wall/gran model floe: unknown keyword ") + arg[0];
    error->all(FLERR, text.c_str());
  }
  laws_ = find_parts(lmp).floe;
  if (!laws_) {
    error->all(FLERR, "fix wall/gran model floe needs pair_style gran model floe before it");
  }
  // Walls bond with nothing: the slots of a contact are enough.
  const int size = laws_->ridging ? int{slot::ridge_size} : int{slot::contact_size};
  for (int k = 0; k < size; ++k) setup->add_history_value("floe_" + std::to_string(k), "0");
}

void WallFloe::init_granular() {
  const Parts parts = find_parts(lmp);
  laws_ = parts.floe;
  fix_ = parts.fix;
  if (!laws_ || !fix_) {
    error->all(FLERR,
               "fix wall/gran model floe needs pair_style gran model floe and "
               "fix floe/integrate");
  }
}

bool WallFloe::checkSurfaceIntersect(LIGGGHTS::ContactModels::SurfacesIntersectData &) {
  return true;  // asked for other shapes than discs only
}

int WallFloe::get_history_offset(std::string name) {
  const int size = laws_->ridging ? int{slot::ridge_size} : int{slot::contact_size};
  for (int k = 0; k < size; ++k) {
    if (name == "floe_" + std::to_string(k)) return k;
  }
  return -1;
}

void WallFloe::compute_force(FixWallGran *wall,
                             LIGGGHTS::ContactModels::SurfacesIntersectData &touch, bool intersects,
                             double *velocity, FixMeshSurface *, int, TriMesh *, int) {
  const int i = touch.i;
  double *h = touch.contact_history;
  if (atom->type[i] == FixFloeIntegrate::fixed_type) return;
  const bool advance = wall->shearupdate() != 0;
  if (!intersects) {
    // What it slid and overlapped is forgotten; a ridge stays as long as the wall is near.
    if (advance) h[slot::slip] = 0.0;
    if (advance && !laws_->ridging) h[slot::rest_overlap] = 0.0;
    return;
  }
  // The wall is a second element without size or mass limit at the nearest point.
  const double distance = touch.radi - touch.deltan;
  const double *v = atom->v[i];
  const ContactPose pose{
      {-touch.delta[0], -touch.delta[1]},       distance,          touch.radi, 0.0,
      {velocity[0] - v[0], velocity[1] - v[1]}, atom->omega[i][2], 0.0};
  WallHistory past{h[slot::slip], h[slot::rest_overlap], {}};
  if (laws_->ridging) past.ridge = ridge_at(h);
  const ContactForce f =
      WallLaw{laws_, fix_}.force(i, atom->rmass[i], pose, advance ? update->dt : 0.0, past);
  if (advance) {
    h[slot::slip] = past.slip;
    h[slot::rest_overlap] = past.rest_overlap;
    if (laws_->ridging) put_ridge(past.ridge, h);
  }
  if (advance) {
    fix_->ledger.impulse_wall_x += f.f.x * update->dt;
    fix_->ledger.impulse_wall_y += f.f.y * update->dt;
  }
  if (!wall->computeflag()) return;
  atom->f[i][0] += f.f.x;
  atom->f[i][1] += f.f.y;
  atom->torque[i][2] += f.torque_one;
}

}  // namespace floe
