// SPDX-License-Identifier: GPL-2.0-or-later
#include "fix_floe_breakage.h"

#include <mpi.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>

#include "comm.h"
#include "domain.h"
#include "error.h"
#include "memory.h"
#include "modify.h"
#include "pair_floe.h"
#include "plugin.h"
#include "update.h"

using namespace LAMMPS_NS;

namespace {

constexpr int columns = 11;
const char *const header =
    "# step time id1 id2 x y mode normal_stress shear_stress thickness energy\n";
const char *const modes[] = {"", "tension", "shear", "compression"};

}  // namespace

FixFloeBreakage::FixFloeBreakage(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg) {
  nevery = narg > 3 ? std::atoi(arg[3]) : 0;
  const bool named = narg == 6 && !std::strcmp(arg[4], "file");
  if (nevery < 1 || (narg != 4 && !named)) {
    error->all(FLERR,
               "Fix floe/breakage: give the number of steps between outputs, and perhaps "
               "the word file with a name");
  }
  if (igroup != 0) error->all(FLERR, "Fix floe/breakage logs all bonds: give it the group all");
  if (named) path_ = arg[5];
  int failed = 0;
  if (named && comm->me == 0) {
    file_ = std::fopen(arg[5], "w");
    failed = file_ == nullptr;
    if (file_) std::fputs(header, file_);
  }
  MPI_Bcast(&failed, 1, MPI_INT, 0, world);
  if (failed) {
    error->all(FLERR, ("Fix floe/breakage: the file " + path_ + " cannot be written").c_str());
  }
  scalar_flag = 1;
  extscalar = 1;
  global_freq = nevery;
  local_flag = 1;
  array_local = nullptr;
  local_freq = nevery;
  size_local_cols = columns;
  size_local_rows = 0;
}

FixFloeBreakage::~FixFloeBreakage() {
  if (file_) std::fclose(file_);
  memory->destroy(array_local);
}

// At the end of the program the pair style is gone before the fixes are.
void FixFloeBreakage::pre_delete(bool unfixed) {
  if (!unfixed) return;
  if (floe::PairFloe *pairs = floe::find_parts(lmp).floe) pairs->log_breakages = false;
}

int FixFloeBreakage::setmask() { return FixConst::END_OF_STEP; }

void FixFloeBreakage::init() {
  floe::PairFloe *pairs = floe::find_parts(lmp).floe;
  if (!pairs || !pairs->bonds) {
    error->all(FLERR, "Fix floe/breakage needs pair_style gran model floe bonds yes");
  }
  if (modify->find_fix_style("floe/breakage", 1)) {
    error->all(FLERR,
               "There may be only one fix floe/breakage: a second would find what the first left");
  }
  pairs->log_breakages = true;
}

void FixFloeBreakage::setup(int) { size_local_rows = 0; }

void FixFloeBreakage::end_of_step() { collect(); }

// What broke since the last multiple of N steps.
void FixFloeBreakage::post_run() { collect(); }

void FixFloeBreakage::collect() {
  std::vector<floe::Breakage> &found = floe::find_parts(lmp).floe->breakages;
  std::vector<double> rows;
  for (const floe::Breakage &b : found) {
    double place[3] = {b.x, b.y, 0.0};
    domain->remap(place);
    for (const double value :
         {static_cast<double>(b.step), b.time, static_cast<double>(b.lo), static_cast<double>(b.hi),
          place[0], place[1], static_cast<double>(static_cast<int>(b.mode)), b.normal, b.shear,
          b.thickness, b.energy}) {
      rows.push_back(value);
    }
  }
  found.clear();
  size_local_rows = static_cast<int>(rows.size()) / columns;
  if (size_local_rows > rows_) {
    rows_ = size_local_rows;
    memory->grow(array_local, rows_, columns, "floe/breakage:rows");
  }
  if (!rows.empty()) std::copy(rows.begin(), rows.end(), array_local[0]);

  const int own = static_cast<int>(rows.size());
  std::vector<int> counts(comm->nprocs), starts(comm->nprocs);
  MPI_Allgather(&own, 1, MPI_INT, counts.data(), 1, MPI_INT, world);
  int all = 0;
  for (int k = 0; k < comm->nprocs; ++k) {
    starts[k] = all;
    all += counts[k];
  }
  total_ += all / columns;
  if (all == 0) return;
  std::vector<double> gathered(comm->me == 0 ? all : 0);
  MPI_Gatherv(rows.data(), own, MPI_DOUBLE, gathered.data(), counts.data(), starts.data(),
              MPI_DOUBLE, 0, world);
  if (file_) write(gathered);
}

// In the order of steps and ids, so that the file does not depend on the ranks.
void FixFloeBreakage::write(const std::vector<double> &rows) {
  std::vector<std::array<double, columns>> sorted(rows.size() / columns);
  for (std::size_t k = 0; k < sorted.size(); ++k) {
    std::copy_n(rows.begin() + k * columns, columns, sorted[k].begin());
  }
  std::sort(sorted.begin(), sorted.end(), [](const auto &a, const auto &b) {
    return std::array<double, 3>{a[0], a[2], a[3]} < std::array<double, 3>{b[0], b[2], b[3]};
  });
  for (const auto &r : sorted) {
    std::fprintf(file_, "%.0f %.9g %.0f %.0f %.9g %.9g %s %.9g %.9g %.9g %.9g\n", r[0], r[1], r[2],
                 r[3], r[4], r[5], modes[static_cast<int>(r[6])], r[7], r[8], r[9], r[10]);
  }
  std::fflush(file_);
}

double FixFloeBreakage::memory_usage() {
  return static_cast<double>(rows_) * columns * sizeof(double);
}
