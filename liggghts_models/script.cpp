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
#include <cstring>
#include <sstream>
#include <string>

#include "domain.h"
#include "error.h"
#include "fix.h"
#include "lammps.h"
#include "modify.h"
#include "plugin.h"
#include "universe.h"

namespace {

// A run that MPI ends loses what the standard output holds back: write it line by line.
[[gnu::constructor]] void write_lines_at_once() { std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ); }

// On the screen, in the log and on standard error.
void print(FILE *screen, FILE *logfile, const std::string &text, const char *file, int line) {
  // Under mpirun the standard output looks like a terminal and may still go to a file.
  const bool seen = screen == stdout && isatty(STDOUT_FILENO) && isatty(STDERR_FILENO);
  for (FILE *out : {screen, logfile, seen ? nullptr : stderr}) {
    if (out) std::fprintf(out, "%s (%s:%d)\n", text.c_str(), file, line);
  }
}

// Before MPI_Abort ends all ranks unflushed.
[[noreturn]] void abort_with(FILE *screen, FILE *logfile, MPI_Comm comm, const std::string &text,
                             const char *file, int line) {
  int me = 0;
  MPI_Comm_rank(comm, &me);
  print(screen, logfile, "ERROR on proc " + std::to_string(me) + ": " + text, file, line);
  std::fflush(nullptr);
  MPI_Abort(comm, 1);
  std::abort();  // not reached
}

// LIGGGHTS sorts the triangles of meshes into bins of the box, and says no more than "assertion
// failed" where one, or its periodic image, lies in none of them.
std::string explained(const char *text, const char *file, LAMMPS_NS::Modify *modify,
                      LAMMPS_NS::Domain *domain) {
  std::string meshes;
  for (int k = 0; modify && k < modify->nfix; ++k) {
    const LAMMPS_NS::Fix *fix = modify->fix[k];
    if (std::strncmp(fix->style, "mesh/surface", 12) == 0) meshes += std::string(" ") + fix->id;
  }
  if (meshes.empty() || !std::strstr(file, "region_neighbor_list")) return text;
  std::ostringstream out;
  out << "a triangle of the meshes" << meshes << " does not fit the simulation box, which reaches"
      << " from " << domain->boxlo[0] << " to " << domain->boxhi[0] << " in x, from "
      << domain->boxlo[1] << " to " << domain->boxhi[1] << " in y and from " << domain->boxlo[2]
      << " to " << domain->boxhi[2] << " in z: make the box several times as wide, long and deep"
      << " as the largest triangle and keep moving meshes inside";
  return out.str();
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
  abort_with(screen, logfile, world, explained(text, file, modify, domain), file, line);
}

void LAMMPS_NS::Error::universe_one(const char *file, int line, const char *text) {
  abort_with(universe->uscreen, universe->ulogfile, universe->uworld, text, file, line);
}

// All ranks meet it together.
void LAMMPS_NS::Error::all(const char *file, int line, const char *text) {
  MPI_Barrier(world);
  int me = 0;
  MPI_Comm_rank(world, &me);
  if (me == 0) print(screen, logfile, std::string("ERROR: ") + text, file, line);
  std::fflush(nullptr);
  if (universe->nworlds > 1) MPI_Abort(universe->uworld, 1);
  MPI_Finalize();
  std::exit(1);
}

// LIGGGHTS' own print some memory behind the sentence, and nothing on standard error.
void LAMMPS_NS::Error::fix_error(const char *file, int line, Fix *fix, const char *style,
                                 const char *text) {
  const std::string head = std::string("Fix ") + style + " (id " + fix->id + "): ";
  all(file, line, (head + (std::strlen(text) > 2 ? text : "illegal command")).c_str());
}

void LAMMPS_NS::Error::fix_error(const char *file, int line, Fix *fix, const char *text) {
  fix_error(file, line, fix, fix->style, text);
}
