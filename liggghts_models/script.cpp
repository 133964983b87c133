// SPDX-License-Identifier: GPL-2.0-or-later
//
// What input scripts need and the engine does not: in liggghts-floe, and in libfloe-preload.so, which
// brings the models into the stock program: LD_PRELOAD=libfloe-preload.so liggghts -in in.script
//
// The definitions here come before those of LIGGGHTS' library in the dynamic linker's search.
#include <dlfcn.h>
#include <mpi.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

#include "error.h"
#include "lammps.h"
#include "plugin.h"
#include "universe.h"

namespace {

// A run that MPI ends loses what the standard output holds back: write it line by line.
[[gnu::constructor]] void write_lines_at_once() { std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ); }

// On the screen, in the log and on standard error, before MPI_Abort ends all ranks unflushed.
[[noreturn]] void end_with(FILE *screen, FILE *logfile, MPI_Comm comm, const char *text,
                           const char *file, int line) {
  int me = 0;
  MPI_Comm_rank(comm, &me);
  const bool seen = screen == stdout && isatty(STDOUT_FILENO);
  for (FILE *out : {screen, logfile, seen ? nullptr : stderr}) {
    if (out) std::fprintf(out, "ERROR on proc %d: %s (%s:%d)\n", me, text, file, line);
  }
  std::fflush(nullptr);
  MPI_Abort(comm, 1);
  std::abort();  // not reached
}

}  // namespace

// The models are there from the start, and again after the command `clear`.
void LAMMPS_NS::LAMMPS::create() {
  using Create = void (*)(LAMMPS *);
  static const auto next =
      reinterpret_cast<Create>(dlsym(RTLD_NEXT, "_ZN9LAMMPS_NS6LAMMPS6createEv"));
  next(this);
  floe::register_models(this);
}

void LAMMPS_NS::Error::one(const char *file, int line, const char *text) {
  end_with(screen, logfile, world, text, file, line);
}

void LAMMPS_NS::Error::universe_one(const char *file, int line, const char *text) {
  end_with(universe->uscreen, universe->ulogfile, universe->uworld, text, file, line);
}
