// SPDX-License-Identifier: GPL-2.0-or-later
#include "displace_command.h"

#include <cmath>
#include <cstring>

#include "atom.h"
#include "displace_atoms.h"
#include "fix_floe_integrate.h"
#include "force.h"
#include "group.h"
#include "plugin.h"

using namespace LAMMPS_NS;

// displace_atoms <group> rotate <Px Py Pz> <Rx Ry Rz> <degrees>: about an axis that stands upright, or
// the floes leave the plane, which the next run refuses.
void DisplaceCommand::command(int narg, char **arg) {
  DisplaceAtoms(lmp).command(narg, arg);
  FixFloeIntegrate *fix = floe::find_parts(lmp).fix;
  if (!fix || narg < 9 || std::strcmp(arg[1], "rotate")) return;
  const double degrees = force->numeric(FLERR, arg[8]), up = force->numeric(FLERR, arg[7]);
  const double angle = std::copysign(degrees * (M_PI / 180.0), degrees * up);
  const int bit = group->bitmask[group->find(arg[0])];
  for (int i = 0; i < atom->nlocal; ++i) {
    if (atom->mask[i] & bit) fix->set_orientation(i, fix->theta[i] + angle);
  }
}
