// SPDX-License-Identifier: GPL-2.0-or-later
//
// C interface: opening, commands, errors, forcing, sums.
#include <mpi.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "capi.h"
#include "columns.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "fix_floe_integrate.h"
#include "history.h"
#include "input.h"
#include "parts.h"
#include "sums.h"

using namespace LAMMPS_NS;

namespace floe {

std::string &last_error() {
  static std::string text;
  return text;
}

}  // namespace floe

namespace {

template <int Count>
std::string names_of(const floe::PairColumn (&columns)[Count]) {
  std::string out;
  for (const floe::PairColumn &column : columns) out += std::string(column.name) + " ";
  return out;
}

}  // namespace

extern "C" {

const char *floe_error(void) { return floe::last_error().c_str(); }

int floe_interface(void) { return FLOE_INTERFACE; }

const char *floe_layout(void) {
  static std::string layout;
  const int failed = floe::guarded([] {
    layout = FLOE_ELEMENT_COLUMNS(FLOE_COLUMN_NAME) ";" + names_of(floe::bond_columns) + ";" +
             names_of(floe::contact_columns) +
             ";" FLOE_FACE_NUMBERS(FLOE_COLUMN_NAME) ";" FLOE_FACE_COLUMNS(
                 FLOE_COLUMN_NAME) ";" FLOE_INTERNAL_COLUMNS(FLOE_COLUMN_NAME);
  });
  return failed ? "" : layout.c_str();
}

int floe_open(int argc, char **argv, void *comm, void **instance) {
  return floe::guarded([&] {
    auto *lmp = new LAMMPS(argc, argv, *static_cast<MPI_Comm *>(comm));
    floe::register_models(lmp);
    *instance = lmp;
  });
}

int floe_close(void *instance) {
  return floe::guarded([&] { delete floe::instance_of(instance); });
}

int floe_command(void *instance, const char *line) {
  return floe::guarded([&] { floe::instance_of(instance)->input->one(line); });
}

int floe_divide(void *instance, const double *x, const double *y) {
  return floe::guarded([&] {
    Comm *comm = floe::instance_of(instance)->comm;
    comm->uniform = 0;
    std::copy(x, x + comm->procgrid[0] + 1, comm->xsplit);
    std::copy(y, y + comm->procgrid[1] + 1, comm->ysplit);
    floe::instance_of(instance)->domain->set_local_box();
  });
}

int floe_set_start_time(void *instance, double seconds) {
  return floe::guarded([&] { floe::fix_of(instance)->start_time = seconds; });
}

int floe_set_forcing(void *instance, long long nt, long long ny, long long nx, const double *time,
                     double x0, double dx, double y0, double dy, const double *velocity,
                     const double *coriolis, int over_discs, int wind_stress) {
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
    grid.over_discs = over_discs != 0;
    grid.wind_stress = wind_stress != 0;
    floe::fix_of(instance)->forcing = std::move(grid);
  });
}

int floe_set_depth(void *instance, const double *depth) {
  return floe::guarded([&] {
    floe::ForcingGrid &grid = floe::fix_of(instance)->forcing;
    grid.depth.assign(depth, depth + grid.coriolis.size());
  });
}

const char *floe_sum_names(void) {
  static std::string names;
  const int failed = floe::guarded([] {
    names.clear();
    for (const std::string &name : floe::sum_names()) names += (names.empty() ? "" : " ") + name;
  });
  return failed ? "" : names.c_str();
}

int floe_sums(void *instance, double *out, int size) {
  return floe::guarded([&] {
    floe::fix_of(instance);
    const std::vector<double> all = floe::local_sums(floe::instance_of(instance));
    if (static_cast<int>(all.size()) != size) throw floe::LiggghtsError("floe_sums: wrong size");
    std::memcpy(out, all.data(), all.size() * sizeof(double));
  });
}

int floe_fault(void *instance, long long *integers, double *numbers) {
  return floe::guarded([&] {
    const floe::Fault &fault = floe::fix_of(instance)->fault;
    const long long whole[4] = {fault.kind, fault.step, fault.id, fault.partner};
    const double real[6] = {fault.x,       fault.y,      fault.force_x,
                            fault.force_y, fault.torque, fault.speed};
    std::memcpy(integers, whole, sizeof whole);
    std::memcpy(numbers, real, sizeof real);
  });
}

}  // extern "C"
