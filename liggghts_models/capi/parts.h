// SPDX-License-Identifier: GPL-2.0-or-later
//
// What the C interface works on, or a sentence where the input has not set it up.
#ifndef FLOE_CAPI_PARTS_H
#define FLOE_CAPI_PARTS_H

#include "lammps.h"
#include "liggghts_error.h"
#include "plugin.h"

namespace floe {

inline LAMMPS_NS::LAMMPS *instance_of(void *instance) {
  if (!instance) throw LiggghtsError("no LIGGGHTS is open");
  return static_cast<LAMMPS_NS::LAMMPS *>(instance);
}

inline LAMMPS_NS::FixFloeIntegrate *fix_of(void *instance) {
  LAMMPS_NS::FixFloeIntegrate *fix = find_parts(instance_of(instance)).fix;
  if (!fix) throw LiggghtsError("there is no fix floe/integrate");
  return fix;
}

// Null where there are none.
inline LAMMPS_NS::FixFloeWalls *find_walls(void *instance) {
  return find_parts(instance_of(instance)).walls;
}

inline LAMMPS_NS::FixFloeWalls *walls_of(void *instance) {
  LAMMPS_NS::FixFloeWalls *walls = find_walls(instance);
  if (!walls) throw LiggghtsError("there is no fix floe/walls");
  return walls;
}

}  // namespace floe

#endif
