// SPDX-License-Identifier: GPL-2.0-or-later
//
// liggghts-floe: LIGGGHTS with the models of sea ice, for people who write their own input scripts.
#include <mpi.h>

#include "input.h"
#include "lammps.h"
#include "plugin.h"

int main(int argc, char **argv) {
  MPI_Init(&argc, &argv);
  {
    LAMMPS_NS::LAMMPS lmp(argc, argv, MPI_COMM_WORLD);
    floe::register_models(&lmp);
    lmp.input->file();
  }
  MPI_Finalize();
  return 0;
}
