// SPDX-License-Identifier: GPL-2.0-or-later
#include "fix_floe_integrate.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <string>

#include "atom.h"
#include "comm.h"
#include "defaults.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "memory.h"
#include "modify.h"
#include "number.h"
#include "orientation.h"
#include "output.h"
#include "pair_floe.h"
#include "plugin.h"
#include "sums.h"
#include "turn.h"
#include "update.h"

using namespace LAMMPS_NS;

FixFloeIntegrate::FixFloeIntegrate(LAMMPS *lmp, int narg, char **arg)
    : Fix(lmp, narg, arg),
      thickness(nullptr),
      cover(nullptr),
      ice_area(nullptr),
      theta(nullptr),
      ridged_area(nullptr),
      bonds_made(nullptr),
      impulse(nullptr),
      turn(nullptr),
      loads_cleared(false),
      pairs(nullptr),
      fused(false),
      use_orientation(true),
      law{},
      start_time(0.0),
      ask_fused(false),
      arrays_current_(true),
      kept_ids_(nullptr),
      first_kick(true),
      stop_at_fault(true),
      default_thickness(1.0),
      default_cover(1.0),
      default_ice_area(-1.0) {
  if (!atom->sphere_flag) error->all(FLERR, "Fix floe/integrate needs atom_style granular");
  time_integrate = 1;
  create_attribute = 1;
  comm_border = 2;
  comm_forward = 2;
  restart_global = restart_peratom = 1;
  vector_flag = 1;
  size_vector = floe::sum_count();
  global_freq = 1;
  extvector = 1;
  law.cos_turn = 1.0;
  law.air = floe::defaults::air_drag;
  law.water = floe::defaults::water_drag;
  forcing.time.assign(1, 0.0);
  forcing.velocity.assign(4, 0.0);
  forcing.coriolis.assign(1, 0.0);
  parse(3, narg, arg);
  elapsed_ = static_cast<double>(update->ntimestep) * update->dt;
  grow_arrays(atom->nmax);
  atom->add_callback(0);
  atom->add_callback(1);
  atom->add_callback(2);
  for (int i = 0; i < atom->nlocal; ++i) set_arrays(i);
  // Or LIGGGHTS gives every element the defaults of its first run, whatever they were when it was made.
  just_created = 0;
}

FixFloeIntegrate::~FixFloeIntegrate() {
  atom->delete_callback(id, 0);
  atom->delete_callback(id, 1);
  atom->delete_callback(id, 2);
  memory->destroy(thickness);
  memory->destroy(cover);
  memory->destroy(ice_area);
  memory->destroy(theta);
  memory->destroy(ridged_area);
  memory->destroy(bonds_made);
  memory->destroy(impulse);
  memory->destroy(turn);
  memory->destroy(kept_ids_);
}

// Keywords of the command fix, or of fix_modify.
void FixFloeIntegrate::parse(int first, int narg, char **arg) {
  const auto fail = [&](const std::string &what) {
    error->all(FLERR, ("Fix floe/integrate: " + what).c_str());
  };
  int k = first;
  const auto number = [&](const char *key) {
    if (++k >= narg) fail(std::string(key) + " needs a value");
    double value;
    if (const char *fault = floe::number_fault(arg[k], value)) fail(key + std::string(fault));
    return value;
  };
  const auto flag = [&](const char *key) {
    if (++k >= narg) fail(std::string(key) + " needs yes or no");
    if (!std::strcmp(arg[k], "yes")) return true;
    if (std::strcmp(arg[k], "no")) fail(std::string(key) + " takes yes or no");
    return false;
  };
  const auto speed = [&](const char *key, int component) {
    const bool named = k + 1 < narg && !std::strncmp(arg[k + 1], "v_", 2);
    variable_names_[component] = named ? arg[++k] + 2 : "";
    return named ? 0.0 : number(key);
  };
  const auto not_negative = [&](const char *key) {
    const double value = number(key);
    if (value < 0.0) fail(std::string(key) + " must not be negative");
    return value;
  };
  const auto positive = [&](const char *key) {
    const double value = number(key);
    if (value <= 0.0) fail(std::string(key) + " must be above 0");
    return value;
  };
  for (; k < narg; ++k) {
    const std::string key = arg[k];
    const char *name = arg[k];
    if (key == "wind")
      law.use_wind = flag(name);
    else if (key == "wind_relative")
      law.relative_wind = flag(name);
    else if (key == "ocean_drag")
      law.use_ocean = flag(name);
    else if (key == "coriolis")
      law.use_coriolis = flag(name);
    else if (key == "tilt")
      law.use_tilt = flag(name);
    else if (key == "depth")
      forcing.depth.assign(1, not_negative(name));
    else if (key == "fused")
      ask_fused = flag(name);
    else if (key == "stop_at_fault")
      stop_at_fault = flag(name);
    else if (key == "air_drag")
      law.air = not_negative(name);
    else if (key == "water_drag")
      law.water = not_negative(name);
    else if (key == "turning_angle") {
      const double angle = number(name);
      if (std::fabs(angle) >= 90.0) fail("turning_angle must lie between -90 and 90 degrees");
      law.cos_turn = std::cos(angle * (M_PI / 180.0));
      law.sin_turn = std::sin(angle * (M_PI / 180.0));
    } else if (key == "thickness")
      default_thickness = not_negative(name);
    else if (key == "cover") {
      default_cover = not_negative(name);
      if (default_cover > 1.0) fail("cover must not be above 1");
    } else if (key == "ice_area")
      default_ice_area = not_negative(name);
    else if (key == "wind_velocity") {
      forcing.velocity[0] = speed(name, 0);
      forcing.velocity[1] = speed(name, 1);
    } else if (key == "ocean_velocity") {
      forcing.velocity[2] = speed(name, 2);
      forcing.velocity[3] = speed(name, 3);
    } else if (key == "coriolis_parameter")
      forcing.coriolis[0] = number(name);
    else if (const floe::ForceKey own = floe::Forces::find(key); own.force < 0)
      fail("unknown keyword " + key);
    else if (own.value < 0)
      forces.use[own.force] = flag(name);
    else
      forces.value[own.force][own.value] = own.zero ? not_negative(name) : positive(name);
  }
  with_variables_ = false;
  for (const std::string &name : variable_names_) with_variables_ |= !name.empty();
  // FloeFlow's engine, which asks for fused, gives the depth with the forcing.
  const char *const deep = forces.reads_depth();
  if (deep && forcing.depth.empty() && !ask_fused) fail(std::string(deep) + " yes needs depth");
}

// Another wind in the middle of a script: what the fix holds of the elements stays.
int FixFloeIntegrate::modify_param(int narg, char **arg) {
  parse(0, narg, arg);
  return narg;
}

double FixFloeIntegrate::step_length() const { return update->dt; }

int FixFloeIntegrate::setmask() {
  return FixConst::INITIAL_INTEGRATE | FixConst::POST_INTEGRATE | FixConst::PRE_EXCHANGE;
}

void FixFloeIntegrate::init() {
  if (domain->dimension != 2) error->all(FLERR, "Fix floe/integrate needs dimension 2");
  if (update->whichflag == 2 || std::strcmp(update->integrate_style, "verlet")) {
    error->all(FLERR,
               "Fix floe/integrate needs the command run with run_style verlet: nothing else "
               "moves floes by it");
  }
  // Without this fix itself.
  const int others = modify->n_pre_initial_integrate + modify->n_post_integrate - 1 +
                     modify->n_pre_force + modify->n_post_force + modify->n_pre_final_integrate +
                     modify->n_final_integrate + modify->n_end_of_step;
  // LIGGGHTS itself makes three computes, for thermodynamic output.
  fused = ask_fused && pairs && igroup == 0 && others == 0 && modify->n_initial_integrate == 1 &&
          output->ndump == 0 && modify->ncompute <= 3;
  floe::clear_forces(lmp, !fused);
  floe::write_turns(theta, atom->nlocal, turn ? turn[0] : nullptr);
  find_variables();
  check_others();
  check_plane();
  check_kept();
}

void FixFloeIntegrate::pre_exchange() {
  write_velocities();
  // A run without set-up begins here: what moves now goes to other ranks with all that it has.
  between_runs_ = false;
  if (pairs) pairs->lists_change();
}

// Between runs commands may read and change LIGGGHTS' history, or take elements away.
void FixFloeIntegrate::post_run() {
  has_run_ = has_run_ || pairs;
  between_runs_ = true;
  if (pairs) pairs->keep_history();
  std::copy_n(atom->tag, atom->nlocal, kept_ids_);
}

void FixFloeIntegrate::setup_pre_exchange() {
  check_period();
  between_runs_ = false;
  if (pairs) pairs->forget_records();
}

void FixFloeIntegrate::setup(int) { check_listed(); }

void FixFloeIntegrate::set_orientation(int i, double angle) {
  theta[i] = angle;
  floe::cos_sin(angle, turn[i][0], turn[i][1]);
}

void FixFloeIntegrate::send_orientations() { comm->forward_comm_fix(this); }

int FixFloeIntegrate::pack_comm(int n, int *list, double *buf, int, int *) {
  for (int k = 0; k < n; ++k) {
    buf[2 * k] = turn[list[k]][0];
    buf[2 * k + 1] = turn[list[k]][1];
  }
  return comm_forward;
}

void FixFloeIntegrate::unpack_comm(int n, int first, double *buf) {
  for (int k = 0; k < n; ++k) {
    turn[first + k][0] = buf[2 * k];
    turn[first + k][1] = buf[2 * k + 1];
  }
}

void FixFloeIntegrate::note_fault(int i, int kind, int partner, double speed) {
  if (fault.kind != floe::fault_none) return;
  fault.kind = kind;
  fault.step = update->ntimestep;
  fault.id = atom->tag[i];
  fault.partner = partner;
  fault.x = atom->x[i][0];
  fault.y = atom->x[i][1];
  fault.force_x = fused ? loads[i].fx : atom->f[i][0];
  fault.force_y = fused ? loads[i].fy : atom->f[i][1];
  fault.torque = fused ? loads[i].torque : atom->torque[i][2];
  fault.speed = speed;
  if (!stop_at_fault) return;
  const char *what = kind == floe::fault_not_finite ? "became non-finite"
                     : kind == floe::fault_runaway  ? "moves further than its radius in a step"
                                                    : "has a bond beyond the pair style's reach";
  char text[200];
  std::snprintf(text, sizeof text, "Element %d %s at (%.6g, %.6g), last force (%.6g, %.6g)",
                atom->tag[i], what, fault.x, fault.y, fault.force_x, fault.force_y);
  error->one(FLERR, text);
}

void FixFloeIntegrate::fault_at(int i, int j) {
  note_fault(i, floe::fault_bond_reach, atom->tag[j], 0.0);
}

void FixFloeIntegrate::freeze(int i, int kind, double speed) {
  note_fault(i, kind, 0, speed);
  atom->v[i][0] = atom->v[i][1] = atom->omega[i][2] = 0.0;
}

void FixFloeIntegrate::grow_arrays(int nmax) {
  memory->grow(thickness, nmax, "floe/integrate:thickness");
  memory->grow(cover, nmax, "floe/integrate:cover");
  memory->grow(ice_area, nmax, "floe/integrate:ice_area");
  memory->grow(theta, nmax, "floe/integrate:theta");
  memory->grow(ridged_area, nmax, "floe/integrate:ridged_area");
  memory->grow(bonds_made, nmax, "floe/integrate:bonds_made");
  memory->grow(impulse, nmax, impulse_numbers, "floe/integrate:impulse");
  memory->grow(turn, nmax, 2, "floe/integrate:turn");
  memory->grow(kept_ids_, nmax, "floe/integrate:kept_ids");
}

void FixFloeIntegrate::copy_arrays(int i, int j, int) {
  // delete_atoms fills gaps from behind. A second one in a row loses bonds of what was moved twice.
  if (between_runs_ && pairs && !pairs->lists_hold()) {
    error->one(FLERR,
               "delete_atoms: floes were taken away before, and bonds would be lost; give `run 0` "
               "between the two");
  }
  thickness[j] = thickness[i];
  cover[j] = cover[i];
  ice_area[j] = ice_area[i];
  theta[j] = theta[i];
  ridged_area[j] = ridged_area[i];
  bonds_made[j] = bonds_made[i];
  for (int k = 0; k < impulse_numbers; ++k) impulse[j][k] = impulse[i][k];
  turn[j][0] = turn[i][0];
  turn[j][1] = turn[i][1];
  kept_ids_[j] = kept_ids_[i];
}

void FixFloeIntegrate::set_arrays(int i) {
  thickness[i] = default_thickness;
  cover[i] = default_cover;
  ice_area[i] = default_ice_area;
  ridged_area[i] = bonds_made[i] = 0.0;
  for (int k = 0; k < impulse_numbers; ++k) impulse[i][k] = 0.0;
  set_orientation(i, 0.0);
  kept_ids_[i] = 0;
}

int FixFloeIntegrate::pack_border(int n, int *list, double *buf) {
  for (int k = 0; k < n; ++k) {
    buf[2 * k] = thickness[list[k]];
    buf[2 * k + 1] = cover[list[k]];
  }
  return 2 * n;
}

int FixFloeIntegrate::unpack_border(int n, int first, double *buf) {
  for (int k = 0; k < n; ++k) {
    thickness[first + k] = buf[2 * k];
    cover[first + k] = buf[2 * k + 1];
  }
  return 2 * n;
}

int FixFloeIntegrate::pack_exchange(int i, double *buf) {
  buf[0] = thickness[i];
  buf[1] = ice_area[i];
  buf[2] = theta[i];
  buf[3] = ridged_area[i];
  buf[4] = bonds_made[i];
  buf[5] = cover[i];
  for (int k = 0; k < impulse_numbers; ++k) buf[6 + k] = impulse[i][k];
  return own_numbers;
}

int FixFloeIntegrate::unpack_exchange(int i, double *buf) {
  thickness[i] = buf[0];
  ice_area[i] = buf[1];
  theta[i] = buf[2];
  ridged_area[i] = buf[3];
  bonds_made[i] = buf[4];
  cover[i] = buf[5];
  for (int k = 0; k < impulse_numbers; ++k) impulse[i][k] = buf[6 + k];
  set_orientation(i, theta[i]);
  kept_ids_[i] = 0;
  return own_numbers;
}

double FixFloeIntegrate::memory_usage() { return 12.0 * atom->nmax * sizeof(double); }
