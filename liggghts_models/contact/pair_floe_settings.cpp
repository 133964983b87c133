// SPDX-License-Identifier: GPL-2.0-or-later
//
// Set-up of pair_style gran model floe: keywords, history, checks.
#include <cmath>
#include <cstring>
#include <string>

#include "comm.h"
#include "error.h"
#include "fix_floe_integrate.h"
#include "force.h"
#include "history.h"
#include "modify.h"
#include "neighbor.h"
#include "pair_floe.h"

using namespace LAMMPS_NS;

namespace floe {

int PairFloe::history_size() const {
  if (bonds) return static_cast<int>(slot::bond_size);
  return ridging ? static_cast<int>(slot::ridge_size) : static_cast<int>(slot::contact_size);
}

void PairFloe::settings(int narg, char **arg, LIGGGHTS::IContactHistorySetup *setup) {
  const auto fail = [&](const std::string &what) {
    error->all(FLERR, ("pair_style gran model floe: " + what).c_str());
  };
  int k = 0;
  const auto number = [&](const std::string &key, bool positive) {
    if (++k >= narg) fail(key + " needs a value");
    const double value = force->numeric(FLERR, arg[k]);
    if (!std::isfinite(value)) fail(key + " is not finite");
    if (value < 0.0 || (positive && value == 0.0)) {
      fail(key + (positive ? " must be above 0" : " must not be negative"));
    }
    return value;
  };
  const auto flag = [&](const std::string &key) {
    if (++k >= narg) fail(key + " needs yes or no");
    if (!std::strcmp(arg[k], "yes")) return true;
    if (std::strcmp(arg[k], "no")) fail(key + " takes yes or no");
    return false;
  };
  double poisson = 0.3;
  bond.young = 1.0e9;
  bond.tensile_share = 0.1;
  bond.tan_phi = std::tan(35.0 * M_PI / 180.0);
  compressive = 1.0e6;
  contact.young = 1.0e8;
  contact.shear_ratio = 0.5;
  contact.friction = 0.3;
  ridge = {26126.0, 928.0, 0.3};
  for (; k < narg; ++k) {
    const std::string key = arg[k];
    if (key == "bonds")
      bonds = flag(key);
    else if (key == "friction")
      friction = flag(key);
    else if (key == "ridging")
      ridging = flag(key);
    else if (key == "deterministic")
      deterministic = flag(key);
    else if (key == "exact_losses")
      exact_losses = flag(key);
    else if (key == "ridge_force")
      ridge.start = number(key, true);
    else if (key == "ridge_hardening")
      ridge.hardening = number(key, false);
    else if (key == "ridge_thickness")
      ridge.thin = number(key, true);
    else if (key == "bond_young")
      bond.young = number(key, true);
    else if (key == "poisson")
      poisson = number(key, false);
    else if (key == "bond_damping")
      bond.damping = number(key, false);
    else if (key == "tensile_share")
      bond.tensile_share = number(key, false);
    else if (key == "compressive_strength") {
      if (k + 1 < narg && !std::strcmp(arg[k + 1], "kovacs_sodhi")) {
        kovacs_sodhi = true;
        ++k;
      } else {
        compressive = number(key, false);
      }
    } else if (key == "friction_angle") {
      const double angle = number(key, true);
      if (angle >= M_PI_2) fail("friction_angle must be below pi/2");
      bond.tan_phi = std::tan(angle);
    } else if (key == "contact_young")
      contact.young = number(key, true);
    else if (key == "contact_shear_ratio")
      contact.shear_ratio = number(key, true);
    else if (key == "contact_damping")
      contact.damping = number(key, false);
    else if (key == "friction_coefficient")
      contact.friction = number(key, false);
    else if (key == "reach")
      reach = number(key, true);
    else
      fail("unknown keyword " + key);
  }
  if (poisson >= 0.5) fail("poisson must be below 0.5");
  if (reach < 1.0) fail("reach must be at least 1");
  contact.damping_ratio = std::sqrt(contact.shear_ratio);
  bond = bond_material(bond.young, poisson, bond.damping, bond.tensile_share, bond.tan_phi);
  for (int slot = 0; slot < history_size(); ++slot) {
    setup->add_history_value("floe_" + std::to_string(slot), "0");
  }
  neighbor->register_contact_dist_factor(reach);
}

void PairFloe::init_granular() {
  fix_ = dynamic_cast<FixFloeIntegrate *>(modify->find_fix_style("floe/integrate", 0));
  if (!fix_) error->all(FLERR, "pair_style gran model floe needs fix floe/integrate");
  fix_->use_orientation = bonds;
  fix_->pairs = this;
  if (neighbor->contactDistanceFactor > reach) reach = neighbor->contactDistanceFactor;
}

int PairFloe::get_history_offset(const std::string name) {
  for (int slot = 0; slot < history_size(); ++slot) {
    if (name == "floe_" + std::to_string(slot)) return slot;
  }
  return -1;
}

void PairFloe::write_restart_settings(FILE *) {
  error->all(FLERR,
             "pair_style gran model floe: write_restart is not supported, use the state file");
}

void PairFloe::read_restart_settings(FILE *, std::int64_t) {
  error->all(FLERR,
             "pair_style gran model floe: read_restart is not supported, use the state file");
}

}  // namespace floe
