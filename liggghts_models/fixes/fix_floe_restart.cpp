// SPDX-License-Identifier: GPL-2.0-or-later
//
// fix floe/integrate: restart files, and sums for input scripts.
#include <mpi.h>

#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "fix_floe_integrate.h"
#include "pair_floe.h"
#include "sums.h"
#include "update.h"

using namespace LAMMPS_NS;

namespace {

// Of the numbers in a restart file: raised whenever their layout changes.
constexpr double restart_version = 6.0;
struct Kept {
  floe::Ledger ledger;
  floe::Forces::Ledger forces;
};
constexpr int kept_size = sizeof(Kept) / sizeof(double);
// Of one element, how many they are included.
constexpr int element_numbers = 1 + FixFloeIntegrate::own_numbers;
// Numbers in front of the sums.
constexpr int head = 4;

// Of the names of all sums: another list of forces has another one. FNV-1a of 32 bits.
double sums_mark() {
  std::uint32_t mark = 2166136261u;
  for (const std::string &name : floe::sum_names()) {
    for (const char letter : name + " ") {
      mark = (mark ^ static_cast<unsigned char>(letter)) * 16777619u;
    }
  }
  return mark;
}

}  // namespace

void FixFloeIntegrate::write_restart(FILE *file) {
  // A file written within a run: the steps changed the history since the elements took it along.
  if (pairs) pairs->keep_history();
  const Kept kept{ledger, force_ledger};
  double own[kept_size];
  std::memcpy(own, &kept, sizeof kept);
  std::vector<double> out{restart_version, elapsed_, first_kick ? 1.0 : 0.0, sums_mark()};
  out.resize(head + kept_size);
  MPI_Allreduce(own, out.data() + head, kept_size, MPI_DOUBLE, MPI_SUM, world);
  if (comm->me != 0) return;
  const int bytes = static_cast<int>(out.size() * sizeof(double));
  std::fwrite(&bytes, sizeof bytes, 1, file);
  std::fwrite(out.data(), sizeof(double), out.size(), file);
}

void FixFloeIntegrate::restart(char *buf) {
  const double *in = reinterpret_cast<double *>(buf);
  if (in[0] != restart_version) {
    error->all(FLERR, "Fix floe/integrate: another version wrote the restart file");
  }
  if (in[head - 1] != sums_mark()) {
    error->all(FLERR, "Fix floe/integrate: a plugin with other forces wrote the restart file");
  }
  elapsed_ = in[1];
  known_ = true;
  first_kick = in[2] != 0.0;
  // The sums of all ranks go on with the first.
  Kept kept{};
  if (comm->me == 0) std::memcpy(static_cast<void *>(&kept), in + head, sizeof kept);
  ledger = kept.ledger;
  force_ledger = kept.forces;
}

int FixFloeIntegrate::pack_restart(int i, double *buf) {
  buf[0] = element_numbers;
  return 1 + pack_exchange(i, buf + 1);
}

void FixFloeIntegrate::unpack_restart(int i, int nth) {
  const double *extra = atom->extra[i];
  int m = 0;
  for (int k = 0; k < nth; ++k) m += static_cast<int>(extra[m]);
  std::vector<double> row(extra + m + 1, extra + m + element_numbers);
  unpack_exchange(i, row.data());
}

int FixFloeIntegrate::size_restart(int) { return element_numbers; }

int FixFloeIntegrate::maxsize_restart() { return element_numbers; }

double FixFloeIntegrate::compute_vector(int k) {
  const long long now = pairs ? pairs->evaluations() : update->ntimestep;
  if (sums_.empty() || now != sums_at_) sums_ = floe::global_sums(lmp);
  sums_at_ = now;
  return sums_[k];
}
