// SPDX-License-Identifier: GPL-2.0-or-later
//
// Replaces LIGGGHTS' handler of errors that all ranks meet together. The dynamic linker takes the
// first definition it finds, and that of the plugin comes before the library's. Where a library was
// linked with -Bsymbolic-functions this has no effect, and the error ends the process as in stock
// LIGGGHTS, after it was written to the log.
#include "liggghts_error.h"

#include <cstdio>

#include "comm.h"
#include "error.h"

void LAMMPS_NS::Error::all(const char *, int, const char *text) {
  if (logfile) {
    std::fprintf(logfile, "ERROR: %s\n", text);
    std::fflush(logfile);
  }
  throw floe::LiggghtsError(text);
}
