// SPDX-License-Identifier: GPL-2.0-or-later
//
// Adds pair style, fix and commands to a LIGGGHTS that is linked or loaded as a library.
#ifndef FLOE_PLUGIN_H
#define FLOE_PLUGIN_H

#include <functional>

namespace LAMMPS_NS {
class Comm;
class LAMMPS;
class FixFloeIntegrate;
class FixFloeWalls;
class PairGran;
}  // namespace LAMMPS_NS

namespace floe {

class PairFloe;

// Once per LIGGGHTS instance, and again after its `clear` command.
void register_models(LAMMPS_NS::LAMMPS *lmp);

// Parts of a running instance; null where the input has not set them up.
struct Parts {
  LAMMPS_NS::PairGran *pair = nullptr;
  PairFloe *floe = nullptr;
  LAMMPS_NS::FixFloeIntegrate *fix = nullptr;
  LAMMPS_NS::FixFloeWalls *walls = nullptr;
};
Parts find_parts(LAMMPS_NS::LAMMPS *lmp);

// Whether LIGGGHTS sets its arrays of forces to 0 in each step.
void clear_forces(LAMMPS_NS::LAMMPS *lmp, bool wanted);

// Calls with the elements, own or ghosts, that this rank hands to ghosts in each step.
void each_sent(LAMMPS_NS::Comm *comm, const std::function<void(int)> &visit);

}  // namespace floe

#endif
