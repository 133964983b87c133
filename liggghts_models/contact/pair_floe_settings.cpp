// SPDX-License-Identifier: GPL-2.0-or-later
//
// Set-up of pair_style gran model floe: keywords, history, checks.
#include <cmath>
#include <cstdio>
#include <cstring>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "comm.h"
#include "defaults.h"
#include "error.h"
#include "fix_floe_integrate.h"
#include "force.h"
#include "history.h"
#include "modify.h"
#include "neighbor.h"
#include "number.h"
#include "pair_floe.h"
#include "pair_gran.h"
#include "plugin.h"
#include "update.h"

using namespace LAMMPS_NS;

namespace floe {

namespace {

constexpr double degree = M_PI / 180.0;

// Whether a law of the list has such a keyword.
template <typename Laws>
bool knows(Laws laws, const std::string &key) {
  bool found = false;
  laws.each([&](auto law) {
    for (const LawKeyword &word : law.keywords) found |= word.name && key == word.name;
  });
  return found;
}

// The chosen law's own numbers: as given, else their defaults.
template <typename Laws>
void take_own(Laws laws, int number, const std::map<std::string, double> &given,
              double (&own)[law_keywords]) {
  laws.with(number, [&](auto law) {
    for (int k = 0; k < law_keywords; ++k) {
      const LawKeyword &word = law.keywords[k];
      if (!word.name) continue;
      const auto found = given.find(word.name);
      own[k] = found == given.end() ? word.value : found->second;
    }
  });
}

}  // namespace

PairFloe::~PairFloe() {
  auto *fix = dynamic_cast<FixFloeIntegrate *>(modify->find_fix_style("floe/integrate", 0));
  if (fix && fix->pairs == this) fix->pairs = nullptr;
}

int PairFloe::history_size() const {
  if (bonds) return static_cast<int>(slot::bond_size);
  return ridging ? static_cast<int>(slot::ridge_size) : static_cast<int>(slot::contact_size);
}

void PairFloe::settings(int narg, char **arg, LIGGGHTS::IContactHistorySetup *setup) {
  const auto fail = [&](const std::string &what) {
    error->all(FLERR, ("pair_style gran model floe: " + what).c_str());
  };
  if (std::strcmp(update->unit_style, "si")) fail("needs `units si`: its defaults are in SI units");
  int k = 0;
  const auto number = [&](const std::string &key, bool positive) {
    if (++k >= narg) fail(key + " needs a value");
    double value;
    if (const char *fault = number_fault(arg[k], value)) fail(key + fault);
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
  const auto law = [&](const std::string &key, auto laws) {
    const int number = laws.number(++k < narg ? arg[k] : "");
    if (number < 0) fail(key + " takes " + laws.names());
    return number;
  };
  words_.clear();
  for (int n = 0; n < narg; ++n) words_ += std::string(n ? " " : "") + arg[n];
  double poisson = defaults::poisson;
  bond.young = defaults::bond_young;
  bond.damping = defaults::bond_damping;
  bond.tensile_share = defaults::tensile_share;
  bond.tan_phi = std::tan(defaults::friction_angle * degree);
  compressive = defaults::compressive_strength;
  contact.young = defaults::contact_young;
  contact.shear_ratio = defaults::contact_shear_ratio;
  contact.damping = defaults::contact_damping;
  contact.friction = defaults::friction_coefficient;
  ridge = {defaults::ridge_force, defaults::ridge_hardening, defaults::ridge_thickness,
           defaults::lead_softening};
  int bond_law = 0;
  std::map<std::string, double> own;  // keywords of single laws
  for (; k < narg; ++k) {
    const std::string key = arg[k];
    if (key == "bonds")
      bonds = flag(key);
    else if (key == "friction")
      friction = flag(key);
    else if (key == "ridging")
      ridging = flag(key);
    else if (key == "fixed_contacts")
      fixed_contacts = flag(key);
    else if (key == "bond_law")
      bond_law = law(key, BondLaws{});
    else if (key == "contact_law")
      contact.law = law(key, ContactLaws{});
    else if (knows(BondLaws{}, key) || knows(ContactLaws{}, key))
      own[key] = number(key, true);
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
    else if (key == "lead_softening")
      ridge.softening = number(key, false);
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
      // No ice has as little, but an angle in radians would.
      if (angle < 2.0 || angle >= 90.0) fail("friction_angle must lie between 2 and 90 degrees");
      bond.tan_phi = std::tan(angle * degree);
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
  const auto constant = [](auto law) { return law.constant; };
  if (ridging && !ContactLaws::with(contact.law, constant)) {
    fail("ridging yes needs contact_law " + ContactLaws::names(constant) +
         ": ridges close by a spring of constant stiffness");
  }
  contact.poisson = poisson;
  // LIGGGHTS has thrown the style that was there away, with the history of all pairs.
  const auto *fix = dynamic_cast<FixFloeIntegrate *>(modify->find_fix_style("floe/integrate", 0));
  if (fix && fix->has_run()) {
    fail(
        "cannot be set between runs, which would forget bonds and histories; write_restart, and "
        "set it after read_restart");
  }
  contact.damping_ratio = std::sqrt(contact.shear_ratio);
  take_own(ContactLaws{}, contact.law, own, contact.own);
  bond = bond_material(bond.young, poisson, bond.damping, bond.tensile_share, bond.tan_phi);
  bond.law = bond_law;
  take_own(BondLaws{}, bond.law, own, bond.own);
  BondLaws::with(bond.law, [&](auto law) {
    if (const char *fault = law.fault(bond)) {
      fail("bond_law " + std::string(law.name) + " " + fault);
    }
  });
  for (int slot = 0; slot < history_size(); ++slot) {
    setup->add_history_value("floe_" + std::to_string(slot), "0");
  }
  neighbor->register_contact_dist_factor(reach);
}

void PairFloe::init_granular() {
  fix_ = dynamic_cast<FixFloeIntegrate *>(modify->find_fix_style("floe/integrate", 0));
  if (!fix_) error->all(FLERR, "pair_style gran model floe needs fix floe/integrate");
  if (find_parts(lmp).floe != this) {
    error->all(FLERR, "pair_style gran model floe cannot be a part of pair_style hybrid");
  }
  fix_->use_orientation = bonds;
  fix_->pairs = this;
  if (page_ && (page_ != neighbor->pgsize || one_ != neighbor->oneatom)) {
    error->all(FLERR,
               "pair_style gran model floe: neigh_modify page and one may only be set before the "
               "first run: LIGGGHTS forgets the pairs when they change");
  }
  page_ = neighbor->pgsize;
  one_ = neighbor->oneatom;
  if (neighbor->contactDistanceFactor > reach) reach = neighbor->contactDistanceFactor;
}

int PairFloe::get_history_offset(const std::string name) {
  for (int slot = 0; slot < history_size(); ++slot) {
    if (name == "floe_" + std::to_string(slot)) return slot;
  }
  return -1;
}

// The words of the command, behind the number of the model, which LIGGGHTS has read ahead.
void PairFloe::write_restart_settings(FILE *file) {
  const int size = static_cast<int>(words_.size());
  std::fwrite(&hash_, sizeof hash_, 1, file);
  std::fwrite(&size, sizeof size, 1, file);
  std::fwrite(words_.data(), 1, words_.size(), file);
}

void PairFloe::read_restart_settings(FILE *file, std::int64_t) {
  int size = -1;
  std::string words;
  if (comm->me == 0) {
    std::int64_t hash;
    bool whole = std::fread(&hash, sizeof hash, 1, file) == 1 &&
                 std::fread(&size, sizeof size, 1, file) == 1 && size >= 0 && size < 100000;
    if (whole) {
      words.resize(size);
      whole = std::fread(&words[0], 1, size, file) == static_cast<std::size_t>(size);
    }
    if (!whole) size = -1;
  }
  MPI_Bcast(&size, 1, MPI_INT, 0, world);
  if (size < 0) error->all(FLERR, "pair_style gran model floe: the restart file is cut or damaged");
  words.resize(size);
  MPI_Bcast(&words[0], size, MPI_CHAR, 0, world);
  std::istringstream in(words);
  std::vector<std::string> parts;
  for (std::string part; in >> part;) parts.push_back(part);
  std::vector<char *> arg;
  for (std::string &part : parts) arg.push_back(&part[0]);
  settings(static_cast<int>(arg.size()), arg.data(), pair_);
}

}  // namespace floe
