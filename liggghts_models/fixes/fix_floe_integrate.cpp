// SPDX-License-Identifier: GPL-2.0-or-later
#include "fix_floe_integrate.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <string>

#include "atom.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "memory.h"
#include "modify.h"
#include "orientation.h"
#include "output.h"
#include "pair_floe.h"
#include "plugin.h"
#include "turn.h"
#include "update.h"

using namespace LAMMPS_NS;

namespace {

void add_external(floe::Ledger &sum, const floe::DriftStep &step, floe::Vec2 mean) {
  const auto work = [mean](floe::Vec2 impulse) { return impulse.x * mean.x + impulse.y * mean.y; };
  sum.work_wind += work(step.wind);
  sum.impulse_wind_x += step.wind.x;
  sum.impulse_wind_y += step.wind.y;
  sum.work_ocean += work(step.ocean);
  sum.impulse_ocean_x += step.ocean.x;
  sum.impulse_ocean_y += step.ocean.y;
  sum.work_coriolis += work(step.coriolis);
  sum.impulse_coriolis_x += step.coriolis.x;
  sum.impulse_coriolis_y += step.coriolis.y;
  sum.work_tilt += work(step.tilt);
  sum.impulse_tilt_x += step.tilt.x;
  sum.impulse_tilt_y += step.tilt.y;
}

}  // namespace

FixFloeIntegrate::FixFloeIntegrate(LAMMPS *lmp, int narg, char **arg)
    : Fix(lmp, narg, arg),
      thickness(nullptr),
      ice_area(nullptr),
      theta(nullptr),
      ridged_area(nullptr),
      pairs(nullptr),
      fused(false),
      use_orientation(true),
      law{},
      start_time(0.0),
      first_kick(true),
      stop_at_fault(true),
      default_thickness(1.0),
      default_ice_area(-1.0) {
  if (!atom->sphere_flag) error->all(FLERR, "Fix floe/integrate needs atom_style granular");
  time_integrate = 1;
  create_attribute = 1;
  comm_border = 1;
  law.cos_turn = 1.0;
  law.air = 1.225 * 0.0015;
  law.water = 1026.0 * 0.0055;
  forcing.time.assign(1, 0.0);
  forcing.velocity.assign(4, 0.0);
  forcing.coriolis.assign(1, 0.0);
  parse(narg, arg);
  grow_arrays(atom->nmax);
  atom->add_callback(0);
  atom->add_callback(2);
  for (int i = 0; i < atom->nlocal; ++i) set_arrays(i);
}

FixFloeIntegrate::~FixFloeIntegrate() {
  atom->delete_callback(id, 0);
  atom->delete_callback(id, 2);
  memory->destroy(thickness);
  memory->destroy(ice_area);
  memory->destroy(theta);
  memory->destroy(ridged_area);
}

void FixFloeIntegrate::parse(int narg, char **arg) {
  const auto fail = [&](const std::string &what) {
    error->all(FLERR, ("Fix floe/integrate: " + what).c_str());
  };
  int k = 3;
  const auto number = [&](const char *key) {
    if (++k >= narg) fail(std::string(key) + " needs a value");
    const double value = force->numeric(FLERR, arg[k]);
    if (!std::isfinite(value)) fail(std::string(key) + " is not finite");
    return value;
  };
  const auto flag = [&](const char *key) {
    if (++k >= narg) fail(std::string(key) + " needs yes or no");
    if (!std::strcmp(arg[k], "yes")) return true;
    if (std::strcmp(arg[k], "no")) fail(std::string(key) + " takes yes or no");
    return false;
  };
  const auto not_negative = [&](const char *key) {
    const double value = number(key);
    if (value < 0.0) fail(std::string(key) + " must not be negative");
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
    else if (key == "stop_at_fault")
      stop_at_fault = flag(name);
    else if (key == "air_drag")
      law.air = not_negative(name);
    else if (key == "water_drag")
      law.water = not_negative(name);
    else if (key == "turning_angle") {
      const double angle = number(name);
      if (std::fabs(angle) > 1.5707) fail("turning_angle must lie between -pi/2 and pi/2");
      law.cos_turn = std::cos(angle);
      law.sin_turn = std::sin(angle);
    } else if (key == "thickness")
      default_thickness = not_negative(name);
    else if (key == "ice_area")
      default_ice_area = not_negative(name);
    else if (key == "wind_velocity") {
      forcing.velocity[0] = number(name);
      forcing.velocity[1] = number(name);
    } else if (key == "ocean_velocity") {
      forcing.velocity[2] = number(name);
      forcing.velocity[3] = number(name);
    } else if (key == "coriolis_parameter")
      forcing.coriolis[0] = number(name);
    else
      fail("unknown keyword " + key);
  }
}

int FixFloeIntegrate::setmask() { return FixConst::INITIAL_INTEGRATE | FixConst::PRE_EXCHANGE; }

void FixFloeIntegrate::init() {
  if (domain->dimension != 2) error->all(FLERR, "Fix floe/integrate needs dimension 2");
  const int others = modify->n_pre_initial_integrate + modify->n_post_integrate +
                     modify->n_pre_force + modify->n_post_force + modify->n_pre_final_integrate +
                     modify->n_final_integrate + modify->n_end_of_step;
  fused = pairs && others == 0 && modify->n_initial_integrate == 1 && output->ndump == 0;
  floe::clear_forces(lmp, !fused);
}

void FixFloeIntegrate::pre_exchange() {
  if (pairs) pairs->lists_change();
}

// Between runs commands may read and change LIGGGHTS' history, or take elements away.
void FixFloeIntegrate::post_run() {
  if (pairs) pairs->write_history();
}

void FixFloeIntegrate::setup_pre_exchange() {
  if (pairs) pairs->bonds_changed();
}

void FixFloeIntegrate::write_forces() {
  const int count = std::min(atom->nlocal, static_cast<int>(loads.size()));
  for (int i = 0; i < count; ++i) {
    double *f = atom->f[i], *torque = atom->torque[i];
    // Where other fixes add theirs LIGGGHTS has cleared the arrays; else they hold anything.
    if (fused) f[0] = f[1] = f[2] = torque[0] = torque[1] = torque[2] = 0.0;
    f[0] += loads[i].fx;
    f[1] += loads[i].fy;
    torque[2] += loads[i].torque;
  }
}

// From velocities at the beginning and the end of the step, or of its second half.
void FixFloeIntegrate::count_damping(int i, floe::Vec2 u, floe::Vec2 u_new, double spin,
                                     double new_spin, floe::Ledger &sum) const {
  // The first force after the state was set acts from the time of the positions on.
  const double old_share = first_kick ? 0.25 : 0.5,
               step = first_kick ? 0.5 * update->dt : update->dt;
  const double x = old_share * u.x + (1.0 - old_share) * u_new.x;
  const double y = old_share * u.y + (1.0 - old_share) * u_new.y;
  const double turn = old_share * spin + (1.0 - old_share) * new_spin;
  const auto work = [&](const floe::Load &d) { return d.fx * x + d.fy * y + d.torque * turn; };
  if (!damped_bond.empty()) sum.dissipation_bond -= step * work(damped_bond[i]);
  sum.dissipation_contact -= step * work(damped_contact[i]);
}

floe::DampingWork FixFloeIntegrate::damping_to_now() const {
  floe::DampingWork out;
  if (first_kick || damped_contact.empty()) return out;
  const double half = 0.5 * update->dt;
  for (int i = 0; i < atom->nlocal; ++i) {
    if (atom->type[i] == fixed_type) continue;
    const double m = atom->rmass[i], r = atom->radius[i];
    const double x = atom->v[i][0] + 0.5 * half * atom->f[i][0] / m;
    const double y = atom->v[i][1] + 0.5 * half * atom->f[i][1] / m;
    const double turn = atom->omega[i][2] + half * atom->torque[i][2] / (m * r * r);
    const auto work = [&](const floe::Load &d) { return d.fx * x + d.fy * y + d.torque * turn; };
    if (!damped_bond.empty()) out.bond -= half * work(damped_bond[i]);
    out.contact -= half * work(damped_contact[i]);
  }
  return out;
}

void FixFloeIntegrate::set_orientation(int i, double angle) {
  theta[i] = angle;
  floe::cos_sin(angle, atom->omega[i][0], atom->omega[i][1]);
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

void FixFloeIntegrate::initial_integrate(int) {
  if (law.use_wind || law.use_ocean || law.use_coriolis || law.use_tilt)
    advance<true>();
  else
    advance<false>();
}

template <bool External>
void FixFloeIntegrate::advance() {
  const double middle = start_time + (update->ntimestep - 0.5) * update->dt;
  const floe::ForcingTime time = floe::forcing_time(forcing, middle);
  const int nlocal = atom->nlocal;
  floe::Ledger sum = ledger;
  // In groups that stay in the cache between the passes over them.
  constexpr int group = 128;
  for (int first = 0; first < nlocal; first += group) {
    const int last = std::min(first + group, nlocal);
    fused ? advance_some<External, true>(first, last, time, sum)
          : advance_some<External, false>(first, last, time, sum);
    // Of all elements: for those that did not turn it changes nothing.
    if (!use_orientation) continue;
    floe::write_turns(theta + first, last - first, atom->omega[first]);
    for (int i = first; i < last && fused; ++i) {
      bodies[i].cos = atom->omega[i][0];
      bodies[i].sin = atom->omega[i][1];
    }
  }
  ledger = sum;
  first_kick = false;
}

template <bool External, bool Fused>
void FixFloeIntegrate::advance_some(int first, int last, const floe::ForcingTime &time,
                                    floe::Ledger &sum) {
  using floe::Vec2;
  double **const x = atom->x, **const v = atom->v, **const omega = atom->omega;
  double *const *const f = atom->f, *const *const torques = atom->torque;
  floe::Body *const body = bodies.data();
  const floe::Load *const load = loads.data();
  const double *radius = atom->radius, *mass = atom->rmass;
  const int *type = atom->type, *mask = atom->mask;
  const double step = update->dt;
  const bool exact = !damped_contact.empty();

  for (int i = first; i < last; ++i) {
    if (!(mask[i] & groupbit)) continue;
    const Vec2 contact = Fused ? Vec2{load[i].fx, load[i].fy} : Vec2{f[i][0], f[i][1]};
    const double torque = Fused ? load[i].torque : torques[i][2];
    if (type[i] == fixed_type) {
      v[i][0] = v[i][1] = omega[i][2] = 0.0;
      if (Fused) body[i].u = body[i].v = body[i].spin = 0.0;
      sum.impulse_fixed_x += contact.x * step;
      sum.impulse_fixed_y += contact.y * step;
      continue;
    }
    const Vec2 u{v[i][0], v[i][1]};
    const double m = mass[i], r = radius[i], spin = omega[i][2];
    floe::DriftStep out;
    double new_spin;
    if constexpr (External) {
      const double area = ice_area[i] < 0.0 ? M_PI * r * r : ice_area[i];
      const floe::ForcingSample here = floe::sample_forcing(forcing, time, x[i][0], x[i][1]);
      out =
          floe::drift_step(law, {u, contact, m, area, here.wind, here.ocean, here.coriolis}, step);
      new_spin =
          floe::spin_step(law.use_ocean, law.water, spin, torque, m, r, area, here.vorticity, step);
    } else {
      const double per_mass = step / m;
      out.u_new = {u.x + per_mass * contact.x, u.y + per_mass * contact.y};
      new_spin = floe::free_spin_step(spin, torque, per_mass, r);
    }
    const double distance = step * step * (out.u_new.x * out.u_new.x + out.u_new.y * out.u_new.y);
    // One test for both faults: a comparison with what is not finite is false.
    if (!(distance <= r * r) || !std::isfinite(new_spin)) {
      const bool finite = std::isfinite(distance + new_spin);
      freeze(i, finite ? floe::fault_runaway : floe::fault_not_finite, std::sqrt(distance) / step);
      if (Fused) body[i].u = body[i].v = body[i].spin = 0.0;
      continue;
    }
    // The mean of old and new velocity makes the works add up to the change of kinetic energy.
    const Vec2 mean{0.5 * (u.x + out.u_new.x), 0.5 * (u.y + out.u_new.y)};
    sum.work_contact += step * (contact.x * mean.x + contact.y * mean.y);
    sum.work_spin += 0.25 * m * r * r * (new_spin * new_spin - spin * spin);
    if (exact) count_damping(i, u, out.u_new, spin, new_spin, sum);
    if constexpr (External) add_external(sum, out, mean);
    const Vec2 place{x[i][0] + step * out.u_new.x, x[i][1] + step * out.u_new.y};
    v[i][0] = out.u_new.x;
    v[i][1] = out.u_new.y;
    x[i][0] = place.x;
    x[i][1] = place.y;
    omega[i][2] = new_spin;
    if (Fused) {
      body[i].x = place.x;
      body[i].y = place.y;
      body[i].u = out.u_new.x;
      body[i].v = out.u_new.y;
      body[i].spin = new_spin;
    }
    theta[i] += step * new_spin;
  }
}

void FixFloeIntegrate::grow_arrays(int nmax) {
  memory->grow(thickness, nmax, "floe/integrate:thickness");
  memory->grow(ice_area, nmax, "floe/integrate:ice_area");
  memory->grow(theta, nmax, "floe/integrate:theta");
  memory->grow(ridged_area, nmax, "floe/integrate:ridged_area");
}

void FixFloeIntegrate::copy_arrays(int i, int j, int) {
  thickness[j] = thickness[i];
  ice_area[j] = ice_area[i];
  theta[j] = theta[i];
  ridged_area[j] = ridged_area[i];
}

void FixFloeIntegrate::set_arrays(int i) {
  thickness[i] = default_thickness;
  ice_area[i] = default_ice_area;
  ridged_area[i] = 0.0;
  set_orientation(i, 0.0);
}

int FixFloeIntegrate::pack_border(int n, int *list, double *buf) {
  for (int k = 0; k < n; ++k) buf[k] = thickness[list[k]];
  return n;
}

int FixFloeIntegrate::unpack_border(int n, int first, double *buf) {
  std::memcpy(thickness + first, buf, n * sizeof(double));
  return n;
}

int FixFloeIntegrate::pack_exchange(int i, double *buf) {
  buf[0] = thickness[i];
  buf[1] = ice_area[i];
  buf[2] = theta[i];
  buf[3] = ridged_area[i];
  return 4;
}

int FixFloeIntegrate::unpack_exchange(int i, double *buf) {
  thickness[i] = buf[0];
  ice_area[i] = buf[1];
  theta[i] = buf[2];
  ridged_area[i] = buf[3];
  return 4;
}

double FixFloeIntegrate::memory_usage() { return 4.0 * atom->nmax * sizeof(double); }
