// SPDX-License-Identifier: GPL-2.0-or-later
//
// What the pair style and the fix accumulate over a run, and the faults they raise. Each entry is
// counted where it arises, none as the remainder of the others, so that budgets can be checked.
#ifndef FLOE_LEDGER_H
#define FLOE_LEDGER_H

namespace floe {

// Local sums of one rank; names in the same order as in ledger_names.
struct Ledger {
  double work_wind = 0.0, work_ocean = 0.0, work_coriolis = 0.0, work_tilt = 0.0;  // J
  double work_contact = 0.0;  // J, of contact and bond forces on mobile elements
  double work_spin = 0.0;     // J, change of rotational energy by all torques
  double impulse_wind_x = 0.0, impulse_wind_y = 0.0;  // N s
  double impulse_ocean_x = 0.0, impulse_ocean_y = 0.0;
  double impulse_coriolis_x = 0.0, impulse_coriolis_y = 0.0;
  double impulse_tilt_x = 0.0, impulse_tilt_y = 0.0;
  double impulse_fixed_x = 0.0, impulse_fixed_y = 0.0;       // taken up by fixed elements
  double impulse_wall_x = 0.0, impulse_wall_y = 0.0;         // given by walls
  double dissipation_bond = 0.0, dissipation_contact = 0.0;  // J
  double dissipation_friction = 0.0, dissipation_fracture = 0.0, dissipation_ridging = 0.0;
  double bonds_cracked = 0.0, bonds_broken = 0.0;  // counts
};

inline const char *ledger_names() {
  return "work_wind work_ocean work_coriolis work_tilt work_contact work_spin "
         "impulse_wind_x impulse_wind_y impulse_ocean_x impulse_ocean_y "
         "impulse_coriolis_x impulse_coriolis_y impulse_tilt_x impulse_tilt_y "
         "impulse_fixed_x impulse_fixed_y impulse_wall_x impulse_wall_y dissipation_bond "
         "dissipation_contact "
         "dissipation_friction dissipation_fracture dissipation_ridging bonds_cracked bonds_broken";
}

enum FaultKind { fault_none = 0, fault_not_finite = 1, fault_runaway = 2, fault_bond_reach = 3 };

// First fault of one rank. An element at fault stays where it was, so that the run can end in order.
struct Fault {
  int kind = fault_none;
  long long step = 0, id = 0, partner = 0;
  double x = 0.0, y = 0.0, force_x = 0.0, force_y = 0.0, torque = 0.0;
  double speed = 0.0;
};

}  // namespace floe

#endif
