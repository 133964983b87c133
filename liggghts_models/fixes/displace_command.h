// SPDX-License-Identifier: GPL-2.0-or-later
//
// LIGGGHTS' command displace_atoms; with the style rotate floes turn along, as one body of ice does.
#ifndef FLOE_DISPLACE_COMMAND_H
#define FLOE_DISPLACE_COMMAND_H

#include "pointers.h"

namespace LAMMPS_NS {

class DisplaceCommand : protected Pointers {
 public:
  explicit DisplaceCommand(class LAMMPS *lmp) : Pointers(lmp) {}
  void command(int narg, char **arg);
};

}  // namespace LAMMPS_NS

#endif
