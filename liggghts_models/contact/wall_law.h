// SPDX-License-Identifier: GPL-2.0-or-later
//
// An element against a wall, by the contact laws and parameters of the pair style. A wall is rigid
// ice: it does not give, bond or ridge; the element does. Shared by fix wall/gran model floe (planes
// and meshes of LIGGGHTS) and fix floe/walls (straight faces in the plane of the ice).
#ifndef FLOE_CONTACT_WALL_LAW_H
#define FLOE_CONTACT_WALL_LAW_H

#include "contact.h"
#include "ridge.h"

namespace LAMMPS_NS {
class FixFloeIntegrate;
}

namespace floe {

class PairFloe;

// History of a contact with a wall.
struct WallHistory {
  double slip = 0.0, rest_overlap = 0.0;  // m
  Ridge ridge{0.0, 0.0, 0.0};             // its length is 0 until it is touched
};

struct WallLaw {
  const PairFloe *laws;
  LAMMPS_NS::FixFloeIntegrate *fix;

  // Force on element i of that mass (kg), and what it loses into the ledger. step: the time (s) over
  // which the history advances; 0: only evaluate.
  ContactForce force(int i, double mass, const ContactPose &pose, double step,
                     WallHistory &history) const;
  double stiffness(int i, double radius) const;  // normal, N/m, at an overlap of 1 m
  // Elastic overlap, m; at most 0: no force.
  double overlap(const ContactPose &pose, const WallHistory &history) const;
  // Elastic energy, J, of an evaluated history.
  double energy(int i, const ContactPose &pose, const WallHistory &history) const;
};

}  // namespace floe

#endif
