// SPDX-License-Identifier: GPL-2.0-or-later
#include "wall_floe.h"

#include <algorithm>
#include <cmath>

#include "atom.h"
#include "error.h"
#include "fix_floe_integrate.h"
#include "fix_wall_gran.h"
#include "history.h"
#include "pair_floe.h"
#include "plugin.h"
#include "update.h"

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

template <bool Friction, bool Ridging>
ContactForce WallFloe::force(int i, const ContactPose &pose, double *h, bool advance) {
  // The wall does not give: all the spring is the element's ice, all the mass its own.
  const double thickness = fix_->thickness[i], stiffness = laws_->contact.young * thickness;
  const ContactConstants constants{
      stiffness, 2.0 * laws_->contact.damping * std::sqrt(stiffness * atom->rmass[i])};
  const double step = advance ? update->dt : 0.0;
  double rest = h[slot::rest_overlap], slip = h[slot::slip], limit = 0.0;
  double overlap =
      Ridging ? (pose.radius_one - pose.distance) - rest : effective_overlap(pose, rest);
  if (advance) h[slot::rest_overlap] = rest;
  if (!(overlap > 0.0) && !std::isnan(overlap)) {
    if (advance) h[slot::slip] = 0.0;
    return {};
  }
  if constexpr (Ridging) {
    if (h[slot::ridge_length] == 0.0) {
      h[slot::ridge_thickness] = thickness;
      h[slot::ridge_length] = 2.0 * edge_share * pose.radius_one;
    }
    Ridge now = ridge_at(h);
    const double closed =
        advance ? laws_->close_ridge(stiffness, pose.radius_one - rest, overlap, now) : 0.0;
    if (closed > 0.0) {
      h[slot::rest_overlap] = rest + closed;
      h[slot::ridge_closing] = now.closing;
      h[slot::ridge_thickness] = now.thickness;
      overlap = (pose.radius_one - pose.distance) - h[slot::rest_overlap];
      fix_->ledger.dissipation_ridging += stiffness * overlap * closed;
      fix_->ridged_area[i] += now.length * closed;
    }
    limit = laws_->ridging_limit(now);
  }
  ContactLoss loss;
  const ContactForce out = contact_force<Friction, Ridging>(laws_->contact, constants, pose,
                                                            overlap, step, slip, loss, limit);
  if (advance) h[slot::slip] = slip;
  fix_->ledger.dissipation_contact += loss.damping * step;
  fix_->ledger.dissipation_friction += loss.friction;
  return out;
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
  ContactForce f;
  if (laws_->friction) {
    f = laws_->ridging ? force<true, true>(i, pose, h, advance)
                       : force<true, false>(i, pose, h, advance);
  } else {
    f = laws_->ridging ? force<false, true>(i, pose, h, advance)
                       : force<false, false>(i, pose, h, advance);
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
