// SPDX-License-Identifier: GPL-2.0-or-later
#include "fix_floe_integrate.h"

#include <cmath>
#include <cstring>
#include <string>

#include "atom.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "memory.h"
#include "update.h"

using namespace LAMMPS_NS;

FixFloeIntegrate::FixFloeIntegrate(LAMMPS *lmp, int narg, char **arg)
    : Fix(lmp, narg, arg),
      thickness(nullptr),
      ice_area(nullptr),
      theta(nullptr),
      law{},
      start_time(0.0),
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

int FixFloeIntegrate::setmask() { return FixConst::INITIAL_INTEGRATE; }

void FixFloeIntegrate::init() {
  if (domain->dimension != 2) error->all(FLERR, "Fix floe/integrate needs dimension 2");
}

void FixFloeIntegrate::set_orientation(int i, double angle) {
  theta[i] = angle;
  atom->omega[i][0] = std::cos(angle);
  atom->omega[i][1] = std::sin(angle);
}

void FixFloeIntegrate::note_fault(int i, int kind, int partner, double speed) {
  if (fault.kind != floe::fault_none) return;
  fault.kind = kind;
  fault.step = update->ntimestep;
  fault.id = atom->tag[i];
  fault.partner = partner;
  fault.x = atom->x[i][0];
  fault.y = atom->x[i][1];
  fault.force_x = atom->f[i][0];
  fault.force_y = atom->f[i][1];
  fault.torque = atom->torque[i][2];
  fault.speed = speed;
}

void FixFloeIntegrate::fault_at(int i, int j) {
  note_fault(i, floe::fault_bond_reach, atom->tag[j], 0.0);
}

void FixFloeIntegrate::freeze(int i, int kind, double speed) {
  note_fault(i, kind, 0, speed);
  atom->v[i][0] = atom->v[i][1] = atom->omega[i][2] = 0.0;
}

void FixFloeIntegrate::initial_integrate(int) {
  using floe::Vec2;
  double **x = atom->x, **v = atom->v, **f = atom->f, **omega = atom->omega;
  double **torque = atom->torque;
  const double *radius = atom->radius, *mass = atom->rmass;
  const int *type = atom->type;
  const int *mask = atom->mask;
  const int nlocal = atom->nlocal;
  const double step = update->dt;
  const double middle = start_time + (update->ntimestep - 0.5) * step;
  const floe::ForcingTime time = floe::forcing_time(forcing, middle);
  const bool external = law.use_wind || law.use_ocean || law.use_coriolis || law.use_tilt;
  floe::Ledger sum = ledger;

  for (int i = 0; i < nlocal; ++i) {
    if (!(mask[i] & groupbit)) continue;
    if (type[i] == fixed_type) {
      v[i][0] = v[i][1] = omega[i][2] = 0.0;
      sum.impulse_fixed_x += f[i][0] * step;
      sum.impulse_fixed_y += f[i][1] * step;
      continue;
    }
    floe::ForcingSample air_and_water{};
    if (external) air_and_water = floe::sample_forcing(forcing, time, x[i][0], x[i][1]);
    const Vec2 u{v[i][0], v[i][1]}, contact{f[i][0], f[i][1]};
    const double area = ice_area[i] < 0.0 ? M_PI * radius[i] * radius[i] : ice_area[i];
    const floe::DriftInput in{
        u, contact, mass[i], area, air_and_water.wind, air_and_water.ocean, air_and_water.coriolis};
    const floe::DriftStep out = floe::drift_step(law, in, step);
    const double spin = omega[i][2];
    const double new_spin = floe::spin_step(law.use_ocean, law.water, spin, torque[i][2], mass[i],
                                            radius[i], area, air_and_water.vorticity, step);
    const double check = out.u_new.x + out.u_new.y + new_spin + x[i][0] + x[i][1];
    const double speed2 = out.u_new.x * out.u_new.x + out.u_new.y * out.u_new.y;
    if (!std::isfinite(check)) {
      freeze(i, floe::fault_not_finite, std::sqrt(speed2));
      continue;
    }
    if (speed2 * step * step > radius[i] * radius[i]) {
      freeze(i, floe::fault_runaway, std::sqrt(speed2));
      continue;
    }
    // The mean of old and new velocity makes the works add up to the change of kinetic energy.
    const Vec2 mean{0.5 * (u.x + out.u_new.x), 0.5 * (u.y + out.u_new.y)};
    const auto work = [&](Vec2 impulse) { return impulse.x * mean.x + impulse.y * mean.y; };
    sum.work_contact += step * work(contact);
    sum.work_spin += 0.25 * mass[i] * radius[i] * radius[i] * (new_spin * new_spin - spin * spin);
    if (external) {
      sum.work_wind += work(out.wind);
      sum.impulse_wind_x += out.wind.x;
      sum.impulse_wind_y += out.wind.y;
      sum.work_ocean += work(out.ocean);
      sum.impulse_ocean_x += out.ocean.x;
      sum.impulse_ocean_y += out.ocean.y;
      sum.work_coriolis += work(out.coriolis);
      sum.impulse_coriolis_x += out.coriolis.x;
      sum.impulse_coriolis_y += out.coriolis.y;
      sum.work_tilt += work(out.tilt);
      sum.impulse_tilt_x += out.tilt.x;
      sum.impulse_tilt_y += out.tilt.y;
    }
    v[i][0] = out.u_new.x;
    v[i][1] = out.u_new.y;
    x[i][0] += step * out.u_new.x;
    x[i][1] += step * out.u_new.y;
    omega[i][2] = new_spin;
    set_orientation(i, theta[i] + step * new_spin);
  }
  ledger = sum;
}

void FixFloeIntegrate::grow_arrays(int nmax) {
  memory->grow(thickness, nmax, "floe/integrate:thickness");
  memory->grow(ice_area, nmax, "floe/integrate:ice_area");
  memory->grow(theta, nmax, "floe/integrate:theta");
}

void FixFloeIntegrate::copy_arrays(int i, int j, int) {
  thickness[j] = thickness[i];
  ice_area[j] = ice_area[i];
  theta[j] = theta[i];
}

void FixFloeIntegrate::set_arrays(int i) {
  thickness[i] = default_thickness;
  ice_area[i] = default_ice_area;
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
  return 3;
}

int FixFloeIntegrate::unpack_exchange(int i, double *buf) {
  thickness[i] = buf[0];
  ice_area[i] = buf[1];
  theta[i] = buf[2];
  return 3;
}

double FixFloeIntegrate::memory_usage() { return 3.0 * atom->nmax * sizeof(double); }
