// SPDX-License-Identifier: GPL-2.0-or-later
#include "sums.h"

#include <mpi.h>

#include <algorithm>
#include <cstring>
#include <sstream>

#include "atom.h"
#include "fix_floe_integrate.h"
#include "fix_floe_walls.h"
#include "lammps.h"
#include "ledger.h"
#include "pair_floe.h"
#include "plugin.h"
#include "update.h"

using namespace LAMMPS_NS;

namespace floe {

namespace {

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

const std::vector<std::string> &sum_names() {
  static const std::vector<std::string> names = [] {
    std::istringstream words(std::string(ledger_names()) +
                             " elastic_bond elastic_contact bonds contacts max_overlap"
                             " kinetic rotational kinetic_now rotational_now momentum_x momentum_y"
                             " elements elastic_wall work_wall wall_contacts" +
                             Forces::sum_names());
    std::vector<std::string> out;
    for (std::string word; words >> word;) out.push_back(word);
    return out;
  }();
  return names;
}

std::vector<double> local_sums(LAMMPS *lmp) {
  const Parts parts = find_parts(lmp);
  if (parts.fix->fused) parts.fix->write_forces();
  PairSums pairs;
  if (parts.floe) pairs = parts.floe->sums(parts.pair);
  const DampingWork damping = parts.fix->damping_to_now();
  Ledger ledger = parts.fix->ledger;
  ledger.dissipation_bond += damping.bond;
  ledger.dissipation_contact += damping.contact;
  const KineticSums moving = kinetic_sums(lmp);
  FixFloeWalls::Sums walls;
  if (parts.walls) walls = parts.walls->sums(pairs.max_overlap);
  // Five structures of doubles and nothing else, in the order of the names.
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
  append(parts.fix->force_ledger);
  return all;
}

std::vector<double> global_sums(LAMMPS *lmp) {
  const std::vector<double> local = local_sums(lmp);
  std::vector<double> out(local.size());
  const int count = static_cast<int>(local.size());
  MPI_Allreduce(local.data(), out.data(), count, MPI_DOUBLE, MPI_SUM, lmp->world);
  const auto &names = sum_names();
  const auto largest = std::find(names.begin(), names.end(), "max_overlap") - names.begin();
  MPI_Allreduce(&local[largest], &out[largest], 1, MPI_DOUBLE, MPI_MAX, lmp->world);
  return out;
}

}  // namespace floe
