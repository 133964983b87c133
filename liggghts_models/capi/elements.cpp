// SPDX-License-Identifier: GPL-2.0-or-later
//
// C interface: elements in and out.
#include <mpi.h>

#include <cmath>

#include "atom.h"
#include "atom_vec.h"
#include "capi.h"
#include "columns.h"
#include "comm.h"
#include "domain.h"
#include "fix_floe_integrate.h"
#include "lammps.h"
#include "parts.h"

using namespace LAMMPS_NS;

namespace {

enum Column { FLOE_ELEMENT_COLUMNS(FLOE_COLUMN) column_count };

static_assert(wind_impulse_x + FixFloeIntegrate::impulse_numbers == column_count);

// The part of the box that this rank owns; its upper edge belongs to the next rank.
bool owns(const Domain *domain, const double *row) {
  return row[x] >= domain->sublo[0] && row[x] < domain->subhi[0] && row[y] >= domain->sublo[1] &&
         row[y] < domain->subhi[1];
}

}  // namespace

extern "C" {

int floe_create_elements(void *instance, long long n, const long long *id, const signed char *type,
                         const double *columns) {
  return floe::guarded([&] {
    LAMMPS *lmp = floe::instance_of(instance);
    Atom *atom = lmp->atom;
    FixFloeIntegrate *fix = floe::fix_of(instance);
    int own = 0;
    for (long long k = 0; k < n; ++k) own += owns(lmp->domain, columns + column_count * k);
    // At once: on its own LIGGGHTS makes room for few at a time, and moves all arrays each time.
    if (atom->nlocal + own > atom->nmax) atom->avec->grow(atom->nlocal + own);
    for (long long k = 0; k < n; ++k) {
      const double *row = columns + column_count * k;
      if (!owns(lmp->domain, row)) continue;
      double place[3] = {row[x], row[y], 0.0};
      atom->avec->create_atom(type[k], place);
      const int i = atom->nlocal - 1;
      atom->tag[i] = static_cast<int>(id[k]);
      atom->v[i][0] = row[u];
      atom->v[i][1] = row[v];
      atom->omega[i][2] = row[omega];
      atom->radius[i] = row[radius];
      atom->rmass[i] = row[mass];
      atom->density[i] = row[mass] / (M_PI * row[radius] * row[radius]);
      fix->set_arrays(i);
      fix->set_orientation(i, row[theta]);
      fix->thickness[i] = row[thickness];
      fix->ice_area[i] = row[ice_area];
      fix->cover[i] = row[cover];
      fix->ridged_area[i] = row[ridged_area];
      for (int c = wind_impulse_x; c < column_count; ++c)
        fix->impulse[i][c - wind_impulse_x] = row[c];
    }
    bigint local = atom->nlocal;
    MPI_Allreduce(&local, &atom->natoms, 1, MPI_LMP_BIGINT, MPI_SUM, lmp->world);
    if (atom->natoms != n) throw floe::LiggghtsError("elements lie outside of the box");
  });
}

long long floe_count_elements(void *instance) {
  return floe::counted([&] { return floe::instance_of(instance)->atom->nlocal; });
}

int floe_get_elements(void *instance, long long *id, signed char *type, double *columns) {
  return floe::guarded([&] {
    const Atom *atom = floe::instance_of(instance)->atom;
    const FixFloeIntegrate *fix = floe::fix_of(instance);
    for (int i = 0; i < atom->nlocal; ++i) {
      double *row = columns + static_cast<long long>(column_count) * i;
      id[i] = atom->tag[i];
      type[i] = static_cast<signed char>(atom->type[i]);
      row[x] = atom->x[i][0];
      row[y] = atom->x[i][1];
      row[theta] = fix->theta[i];
      row[u] = atom->v[i][0];
      row[v] = atom->v[i][1];
      row[omega] = atom->omega[i][2];
      row[radius] = atom->radius[i];
      row[mass] = atom->rmass[i];
      row[thickness] = fix->thickness[i];
      row[ice_area] = fix->ice_area[i];
      row[cover] = fix->cover[i];
      row[ridged_area] = fix->ridged_area[i];
      for (int c = wind_impulse_x; c < column_count; ++c)
        row[c] = fix->impulse[i][c - wind_impulse_x];
    }
  });
}

}  // extern "C"
