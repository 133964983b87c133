// SPDX-License-Identifier: GPL-2.0-or-later
//
// C interface: opening, commands, errors, forcing, sums.
#include <mpi.h>

#include <cstring>
#include <string>
#include <vector>

#include "atom.h"
#include "capi.h"
#include "error.h"
#include "fix_floe_integrate.h"
#include "fix_floe_walls.h"
#include "input.h"
#include "lammps.h"
#include "liggghts_error.h"
#include "pair_floe.h"
#include "plugin.h"
#include "update.h"

using namespace LAMMPS_NS;

namespace floe {

std::string &last_error() {
  static std::string text;
  return text;
}

}  // namespace floe

namespace {

LAMMPS *lmp_of(void *instance) { return static_cast<LAMMPS *>(instance); }

// Velocities belong to half a step before the positions. kinetic and rotational take them as they
// are, kinetic_now and rotational_now at the time of the positions, half a step of contact force on.
struct KineticSums {
  double kinetic = 0.0, rotational = 0.0, kinetic_now = 0.0, rotational_now = 0.0;
  double momentum_x = 0.0, momentum_y = 0.0, elements = 0.0;
};

KineticSums kinetic_sums(LAMMPS *lmp) {
  KineticSums out;
  const Atom *atom = lmp->atom;
  for (int i = 0; i < atom->nlocal; ++i) {
    out.elements += 1.0;
    if (atom->type[i] == FixFloeIntegrate::fixed_type) continue;
    const double m = atom->rmass[i], r = atom->radius[i], w = atom->omega[i][2];
    const double u = atom->v[i][0], v = atom->v[i][1];
    out.kinetic += 0.5 * m * (u * u + v * v);
    out.rotational += 0.25 * m * r * r * w * w;
    const double half = 0.5 * lmp->update->dt / m;
    const double nu = u + half * atom->f[i][0], nv = v + half * atom->f[i][1];
    const double nw = w + half * atom->torque[i][2] / (0.5 * r * r);
    out.kinetic_now += 0.5 * m * (nu * nu + nv * nv);
    out.rotational_now += 0.25 * m * r * r * nw * nw;
    out.momentum_x += m * u;
    out.momentum_y += m * v;
  }
  return out;
}

}  // namespace

extern "C" {

const char *floe_error(void) { return floe::last_error().c_str(); }

int floe_open(int argc, char **argv, void *comm, void **instance) {
  return floe::guarded([&] {
    auto *lmp = new LAMMPS(argc, argv, *static_cast<MPI_Comm *>(comm));
    floe::register_models(lmp);
    *instance = lmp;
  });
}

void floe_close(void *instance) { delete lmp_of(instance); }

int floe_command(void *instance, const char *line) {
  return floe::guarded([&] { lmp_of(instance)->input->one(line); });
}

void floe_set_start_time(void *instance, double seconds) {
  floe::find_parts(lmp_of(instance)).fix->start_time = seconds;
}

int floe_set_forcing(void *instance, long long nt, long long ny, long long nx, const double *time,
                     double x0, double dx, double y0, double dy, const double *velocity,
                     const double *coriolis) {
  return floe::guarded([&] {
    floe::ForcingGrid grid;
    grid.time.assign(time, time + nt);
    grid.x0 = x0;
    grid.dx = dx;
    grid.y0 = y0;
    grid.dy = dy;
    grid.nx = static_cast<int>(nx);
    grid.ny = static_cast<int>(ny);
    grid.velocity.assign(velocity, velocity + 4 * nt * ny * nx);
    grid.coriolis.assign(coriolis, coriolis + ny * nx);
    floe::find_parts(lmp_of(instance)).fix->forcing = std::move(grid);
  });
}

const char *floe_sum_names(void) {
  static const std::string names =
      std::string(floe::ledger_names()) +
      " elastic_bond elastic_contact bonds contacts max_overlap"
      " kinetic rotational kinetic_now rotational_now momentum_x momentum_y elements"
      " elastic_wall work_wall wall_contacts";
  return names.c_str();
}

int floe_sums(void *instance, double *out, int size) {
  return floe::guarded([&] {
    const floe::Parts parts = floe::find_parts(lmp_of(instance));
    if (parts.fix->fused) parts.fix->write_forces();
    floe::PairSums pairs = parts.floe->sums(parts.pair);
    const floe::DampingWork damping = parts.fix->damping_to_now();
    floe::Ledger ledger = parts.fix->ledger;
    ledger.dissipation_bond += damping.bond;
    ledger.dissipation_contact += damping.contact;
    const KineticSums moving = kinetic_sums(lmp_of(instance));
    FixFloeWalls::Sums walls;
    if (parts.walls) walls = parts.walls->sums(pairs.max_overlap);
    // Four structures of doubles and nothing else, in the order of the names.
    std::vector<double> all;
    const auto append = [&all](const auto &part) {
      static_assert(sizeof(part) % sizeof(double) == 0, "sums are doubles");
      const std::size_t start = all.size();
      all.resize(start + sizeof(part) / sizeof(double));
      std::memcpy(all.data() + start, &part, sizeof(part));
    };
    append(ledger);
    append(pairs);
    append(moving);
    append(walls);
    if (static_cast<int>(all.size()) != size) throw floe::LiggghtsError("floe_sums: wrong size");
    std::memcpy(out, all.data(), all.size() * sizeof(double));
  });
}

void floe_fault(void *instance, long long *integers, double *numbers) {
  const floe::Fault &fault = floe::find_parts(lmp_of(instance)).fix->fault;
  const long long whole[4] = {fault.kind, fault.step, fault.id, fault.partner};
  const double real[6] = {fault.x,       fault.y,      fault.force_x,
                          fault.force_y, fault.torque, fault.speed};
  std::memcpy(integers, whole, sizeof whole);
  std::memcpy(numbers, real, sizeof real);
}

}  // extern "C"
