// SPDX-License-Identifier: GPL-2.0-or-later
//
// liggghts-floe: LIGGGHTS with the models of sea ice, for people who write their own input scripts.
// script.cpp brings the models in.
#include <mpi.h>

#include <csignal>

#include "input.h"
#include "lammps.h"
#include "signal_handling.h"

int main(int argc, char **argv) {
  // As in LIGGGHTS' own program: a first interrupt lets it end in order, SIGUSR1 writes a restart.
  std::signal(SIGINT, LAMMPS_NS::SignalHandler::int_handler);
  std::signal(SIGTERM, LAMMPS_NS::SignalHandler::int_handler);
  std::signal(SIGUSR1, LAMMPS_NS::SignalHandler::usr1_handler);
  MPI_Init(&argc, &argv);
  {
    LAMMPS_NS::LAMMPS lmp(argc, argv, MPI_COMM_WORLD);
    lmp.input->file();
  }
  MPI_Finalize();
  return 0;
}
