// SPDX-License-Identifier: GPL-2.0-or-later
#include "wall_floe.h"

#include <cmath>
#include <string>

#include "atom.h"
#include "compute_pair_gran_local.h"
#include "error.h"
#include "fix_floe_integrate.h"
#include "fix_mesh_surface.h"
#include "fix_property_atom.h"
#include "fix_wall_gran.h"
#include "history.h"
#include "pair_floe.h"
#include "plugin.h"
#include "tri_mesh.h"
#include "update.h"
#include "wall_law.h"

using namespace LAMMPS_NS;

namespace floe {

namespace {

// Share of a radius by which the nearest point of a wall may lie off the plane: round-off.
constexpr double upright = 1e-6;

}  // namespace

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
                             double *velocity, FixMeshSurface *mesh_fix, int mesh_number,
                             TriMesh *mesh, int triangle) {
  const int i = touch.i;
  // LIGGGHTS asks for all elements at a mesh, and for those of the group at a plane.
  if (!(atom->mask[i] & wall->groupbit)) return;
  double *h = touch.contact_history;
  const bool advance = wall->shearupdate() != 0;
  if (!intersects) {
    // What it slid and overlapped is forgotten; a ridge stays as long as the wall is near.
    if (advance) h[slot::slip] = 0.0;
    if (advance && !laws_->ridging) h[slot::rest_overlap] = 0.0;
    return;
  }
  if (!(std::fabs(touch.delta[2]) <= upright * touch.radi)) {
    error->one(FLERR,
               ("fix wall/gran model floe: the wall's point nearest to element " +
                std::to_string(atom->tag[i]) +
                " is not at z = 0: walls must stand upright and reach a radius above and below")
                   .c_str());
  }
  const bool fixed = atom->type[i] == FixFloeIntegrate::fixed_type;
  const ContactForce f = fixed ? ContactForce{} : force_on(touch, velocity, advance);
  if (advance) {
    fix_->ledger.impulse_wall_x += f.f.x * update->dt;
    fix_->ledger.impulse_wall_y += f.f.y * update->dt;
  }
  if (wall->computeflag()) {
    atom->f[i][0] += f.f.x;
    atom->f[i][1] += f.f.y;
    atom->torque[i][2] += f.torque_one;
  }
  report(wall, touch, velocity, f, {mesh_fix, mesh_number, mesh, triangle});
}

// The wall is a second element without size or mass limit at the nearest point.
ContactForce WallFloe::force_on(LIGGGHTS::ContactModels::SurfacesIntersectData &touch,
                                const double *velocity, bool advance) const {
  const int i = touch.i;
  double *h = touch.contact_history;
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
  return f;
}

// To all of LIGGGHTS that listens to forces of walls, in the order of its own walls.
void WallFloe::report(FixWallGran *wall, LIGGGHTS::ContactModels::SurfacesIntersectData &touch,
                      double *velocity, const ContactForce &f, const Triangle &on) const {
  const int i = touch.i;
  double force[3] = {f.f.x, f.f.y, 0.0};
  double to_wall[3] = {-touch.delta[0], -touch.delta[1], 0.0};
  const double distance = touch.radi - touch.deltan;
  double normal[3] = {to_wall[0] / distance, to_wall[1] / distance, 0.0};
  const int id = on.mesh ? on.mesh->id(on.number) : 0;
  LIGGGHTS::ContactModels::ForceData forces{};
  forces.delta_F[0] = f.f.x;
  forces.delta_F[1] = f.f.y;
  forces.delta_torque[2] = f.torque_one;
  if (wall->computeflag() && wall->store_sum_normal_force()) {
    *wall->get_sum_normal_force_ptr(i) -= force[0] * normal[0] + force[1] * normal[1];
  }
  if (wall->store_force_contact() && update->ntimestep % wall->store_force_contact_every() == 0) {
    wall->add_contactforce_wall(i, forces, id);
  }
  if (wall->store_force_contact_stress()) {
    wall->add_contactforce_stress_wall(i, forces, touch.delta, velocity, id);
  }
  ComputePairGranLocal *rows = wall->compute_wall_gran_local();
  if (rows && wall->addflag()) {
    double point[3] = {atom->x[i][0] + to_wall[0], atom->x[i][1] + to_wall[1], 0.0};
    rows->add_wall_1(on.mesh_number, id, i, point, velocity);
    rows->add_wall_2(i, force[0], force[1], 0.0, 0.0, 0.0, f.torque_one, touch.contact_history,
                     distance * distance, normal);
  }
  // compute wall/gran/local asks once more, and LIGGGHTS sets these to 0 before it does.
  if (wall->store_force()) {
    for (int k = 0; k < 3; ++k) wall->fix_wallforce()->array_atom[i][k] += force[k];
  }
  if (on.fix && wall->computeflag())
    on.fix->add_particle_contribution(i, force, to_wall, on.number, velocity);
}

}  // namespace floe
