// SPDX-License-Identifier: GPL-2.0-or-later
//
// Command for input scripts: floe_bonds gap <m> thickness <m> width <share>
//
// Freezes unstressed bonds between all elements whose discs are no further apart than gap. The glue
// line stands across the middle between the two discs; its length is width times the smaller
// diameter. The lists of neighbours must be there: give the command after `run 0`.
#ifndef FLOE_BOND_COMMAND_H
#define FLOE_BOND_COMMAND_H

#include "pointers.h"

namespace LAMMPS_NS {

class BondCommand : protected Pointers {
 public:
  explicit BondCommand(class LAMMPS *lmp) : Pointers(lmp) {}
  void command(int narg, char **arg);
};

}  // namespace LAMMPS_NS

#endif
