// SPDX-License-Identifier: GPL-2.0-or-later
//
// fix wall/gran model floe: elements against planes and triangle meshes, moving ones included, with
// the contact laws and parameters of pair_style gran model floe. A wall is rigid ice: it does not
// give, bond or ridge; the element does.
#ifndef FLOE_CONTACT_WALL_FLOE_H
#define FLOE_CONTACT_WALL_FLOE_H

#include <string>

#include "contact.h"
#include "granular_wall.h"
#include "pointers.h"

namespace LAMMPS_NS {
class FixFloeIntegrate;
}

namespace floe {

class PairFloe;

class WallFloe : public LIGGGHTS::Walls::IGranularWall, private LAMMPS_NS::Pointers {
 public:
  explicit WallFloe(LAMMPS_NS::LAMMPS *lmp) : Pointers(lmp) {}

  void settings(int narg, char **arg, LIGGGHTS::IContactHistorySetup *setup) override;
  void init_granular() override;
  bool checkSurfaceIntersect(LIGGGHTS::ContactModels::SurfacesIntersectData &) override;
  void compute_force(LAMMPS_NS::FixWallGran *wall,
                     LIGGGHTS::ContactModels::SurfacesIntersectData &touch, bool intersects,
                     double *velocity, LAMMPS_NS::FixMeshSurface *, int, LAMMPS_NS::TriMesh *,
                     int) override;
  int get_history_offset(std::string name) override;
  bool contact_match(const std::string type, const std::string model) override {
    return type == "normal" && model == "floe";
  }

 private:
  struct Triangle {
    LAMMPS_NS::FixMeshSurface *fix;  // null for a plane
    int mesh_number;
    LAMMPS_NS::TriMesh *mesh;
    int number;
  };
  ContactForce force_on(LIGGGHTS::ContactModels::SurfacesIntersectData &touch,
                        const double *velocity, bool advance) const;
  void report(LAMMPS_NS::FixWallGran *wall, LIGGGHTS::ContactModels::SurfacesIntersectData &touch,
              double *velocity, const ContactForce &f, const Triangle &on) const;

  const PairFloe *laws_ = nullptr;
  LAMMPS_NS::FixFloeIntegrate *fix_ = nullptr;
};

}  // namespace floe

#endif
