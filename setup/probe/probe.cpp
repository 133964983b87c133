// SPDX-License-Identifier: GPL-2.0-or-later
// The smallest library that needs what the plugin needs: LIGGGHTS' headers, its library and MPI.
// It tells LIGGGHTS commands and reads back what they did through the objects of the headers, so
// that headers which do not belong to the library, or two MPIs in one process, come to light.
// Used by `make doctor` alone.
#include <mpi.h>

#include "atom.h"
#include "comm.h"
#include "input.h"
#include "lammps.h"

using namespace LAMMPS_NS;

extern "C" void probe_command(void *handle, const char *command) {
  static_cast<LAMMPS *>(handle)->input->one(command);
}

// Number of elements on all ranks; -1 where LIGGGHTS' idea of the ranks is not MPI's.
extern "C" int probe_elements(void *handle) {
  LAMMPS *liggghts = static_cast<LAMMPS *>(handle);
  int ranks = 0;
  MPI_Comm_size(liggghts->world, &ranks);
  if (ranks != liggghts->comm->nprocs) return -1;
  int all = 0;
  MPI_Allreduce(&liggghts->atom->nlocal, &all, 1, MPI_INT, MPI_SUM, liggghts->world);
  return all;
}
