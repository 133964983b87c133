// SPDX-License-Identifier: GPL-2.0-or-later
//
// Replaces LIGGGHTS' handlers of errors. The dynamic linker takes the first definition it finds, and
// that of the plugin comes before the library's. Where a library was linked with
// -Bsymbolic-functions this has no effect, and an error ends the process as in stock LIGGGHTS, after
// it was written to the log.
#include "liggghts_error.h"

#include <mpi.h>

#include <cstdio>

#include "error.h"

// All ranks meet it together, so all of them can go on.
void LAMMPS_NS::Error::all(const char *, int, const char *text) {
  if (logfile) {
    std::fprintf(logfile, "ERROR: %s\n", text);
    std::fflush(logfile);
  }
  throw floe::LiggghtsError(text);
}

// One rank meets it. The others would wait for it for ever: the run ends, with the reason.
void LAMMPS_NS::Error::one(const char *file, int line, const char *text) {
  int ranks = 1;
  MPI_Comm_size(world, &ranks);
  if (ranks == 1) all(file, line, text);
  std::fprintf(stderr, "LIGGGHTS: %s\n", text);
  MPI_Abort(world, 1);
  throw floe::LiggghtsError(text);  // not reached
}

void LAMMPS_NS::Error::universe_all(const char *file, int line, const char *text) {
  all(file, line, text);
}

void LAMMPS_NS::Error::universe_one(const char *file, int line, const char *text) {
  one(file, line, text);
}
