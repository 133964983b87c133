// SPDX-License-Identifier: GPL-2.0-or-later
//
// Energies, works, impulses and counts: what the ledger accumulated, and sums over the present state.
#ifndef FLOE_FIXES_SUMS_H
#define FLOE_FIXES_SUMS_H

#include <string>
#include <vector>

namespace LAMMPS_NS {
class LAMMPS;
}

namespace floe {

// Names of all sums, in their order.
const std::vector<std::string> &sum_names();
inline int sum_count() { return static_cast<int>(sum_names().size()); }

// Those of this rank.
std::vector<double> local_sums(LAMMPS_NS::LAMMPS *lmp);
// Those of all ranks: added up, but for the largest overlap.
std::vector<double> global_sums(LAMMPS_NS::LAMMPS *lmp);

}  // namespace floe

#endif
