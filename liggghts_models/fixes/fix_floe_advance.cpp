// SPDX-License-Identifier: GPL-2.0-or-later
//
// fix floe/integrate: one step of all elements, and the works that are counted with it.
#include <algorithm>
#include <cmath>

#include "atom.h"
#include "fix_floe_integrate.h"
#include "orientation.h"
#include "output.h"
#include "plugin.h"
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

void FixFloeIntegrate::initial_integrate(int) {
  elapsed_ += update->dt;
  if (with_variables_) sample_variables();
  if (law.use_wind || law.use_ocean || law.use_coriolis || law.use_tilt || forces.any())
    advance<true>();
  else
    advance<false>();
}

// Elements outside of the group: whoever moves them, their bonds turn with the spin of this step,
// which another fix may have set after initial_integrate() here.
void FixFloeIntegrate::post_integrate() {
  if (fused || igroup == 0) return;
  for (int i = 0; i < atom->nlocal; ++i) {
    if (atom->mask[i] & groupbit) continue;
    set_orientation(i, theta[i] + update->dt * atom->omega[i][2]);
  }
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
    // For the next evaluation of the pairs, as long as they are in the cache.
    if (fused) std::fill(loads.begin() + first, loads.begin() + last, floe::Load{});
    // Of all elements: for those that did not turn it changes nothing.
    if (!use_orientation) continue;
    if (fused) {
      double turns[2 * group];
      floe::write_turns(theta + first, last - first, turns);
      for (int i = first; i < last; ++i) {
        bodies[i].cos = turns[2 * (i - first)];
        bodies[i].sin = turns[2 * (i - first) + 1];
      }
    } else {
      floe::write_turns(theta + first, last - first, turn[first]);
    }
  }
  ledger = sum;
  first_kick = false;
  loads_cleared = fused;
  arrays_current_ = !fused;
  if (output_now()) write_velocities();
  if (!arrays_current_) write_sent();
}

// Whether somebody may look at the elements after this step.
bool FixFloeIntegrate::output_now() const {
  return update->ntimestep == update->laststep || update->ntimestep == output->next;
}

void FixFloeIntegrate::write_velocity(int i) {
  const floe::Body &body = bodies[i];
  atom->v[i][0] = body.u;
  atom->v[i][1] = body.v;
  atom->omega[i][2] = body.spin;
  turn[i][0] = body.cos;
  turn[i][1] = body.sin;
}

void FixFloeIntegrate::write_velocities() {
  if (arrays_current_) return;
  for (int i = 0; i < atom->nlocal; ++i) write_velocity(i);
  arrays_current_ = true;
}

// LIGGGHTS hands velocities to ghosts from its arrays.
void FixFloeIntegrate::write_sent() {
  const int nlocal = atom->nlocal;
  floe::each_sent(comm, [this, nlocal](int i) {
    if (i < nlocal) write_velocity(i);
  });
}

template <bool External, bool Fused>
void FixFloeIntegrate::advance_some(int first, int last, const floe::ForcingTime &time,
                                    floe::Ledger &sum) {
  using floe::Vec2;
  double **const v = atom->v, **const omega = atom->omega;
  double (*const x)[3] =
      reinterpret_cast<double (*)[3]>(atom->x[0]);  // LIGGGHTS' rows are one array
  double *const *const f = atom->f, *const *const torques = atom->torque;
  floe::Body *const body = bodies.data();
  const floe::Load *const load = loads.data();
  const bool from_body = Fused && !arrays_current_;
  const double *radius = atom->radius, *mass = atom->rmass;
  const int *type = atom->type, *mask = atom->mask;
  const double step = update->dt;
  const bool exact = !damped_contact.empty();
  const floe::Forces acting = forces.with_depth(!forcing.depth.empty());
  const bool act = acting.any();
  floe::Forces::Impulses given_by_forces;

  for (int i = first; i < last; ++i) {
    if (!Fused && !(mask[i] & groupbit)) continue;  // post_integrate() turns it
    const Vec2 contact = Fused ? Vec2{load[i].fx, load[i].fy} : Vec2{f[i][0], f[i][1]};
    const double torque = Fused ? load[i].torque : torques[i][2];
    if (type[i] == fixed_type) {
      v[i][0] = v[i][1] = omega[i][2] = 0.0;
      if (Fused) body[i].u = body[i].v = body[i].spin = 0.0;
      sum.impulse_fixed_x += contact.x * step;
      sum.impulse_fixed_y += contact.y * step;
      continue;
    }
    const double *const speed = from_body ? &body[i].u : v[i];
    const Vec2 u{speed[0], speed[1]};
    const double m = mass[i], r = Fused ? body[i].radius : radius[i];
    const double spin = from_body ? body[i].spin : omega[i][2];
    floe::DriftStep out;
    double new_spin;
    if constexpr (External) {
      const double area = ice_area[i] < 0.0 ? M_PI * r * r : ice_area[i];
      floe::ForcingSample here = floe::forcing_on(forcing, time, x[i][0], x[i][1], r);
      if (with_variables_) take_variables(i, here);
      const floe::DriftInput in{u, contact, m, area, here.wind, here.ocean, here.coriolis};
      out = act ? acting.step(law, {in, thickness[i], cover[i], here.depth}, step, given_by_forces)
                : floe::drift_step(law, in, step);
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
    if constexpr (External) {
      add_external(sum, out, mean);
      if (act) floe::Forces::add(force_ledger, given_by_forces, mean);
      double *const given = impulse[i];
      given[0] += out.wind.x;
      given[1] += out.wind.y;
      given[2] += out.ocean.x;
      given[3] += out.ocean.y;
    }
    const Vec2 place{x[i][0] + step * out.u_new.x, x[i][1] + step * out.u_new.y};
    x[i][0] = place.x;
    x[i][1] = place.y;
    if (Fused) {
      body[i].x = place.x;
      body[i].y = place.y;
      body[i].u = out.u_new.x;
      body[i].v = out.u_new.y;
      body[i].spin = new_spin;
    } else {
      v[i][0] = out.u_new.x;
      v[i][1] = out.u_new.y;
      omega[i][2] = new_spin;
    }
    theta[i] += step * new_spin;
  }
}
