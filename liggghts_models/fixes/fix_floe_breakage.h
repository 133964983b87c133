// SPDX-License-Identifier: GPL-2.0-or-later
//
// fix ID all floe/breakage N [file NAME]: a log of the bonds that break.
//
// Every N steps the breakages since the last time go to the file, and are the fix's local rows until
// the next time (dump local), as with LAMMPS' fix store/local.
#ifndef LMP_FIX_FLOE_BREAKAGE_H
#define LMP_FIX_FLOE_BREAKAGE_H

#include <cstdio>
#include <string>
#include <vector>

#include "fix.h"

namespace LAMMPS_NS {

class FixFloeBreakage : public Fix {
 public:
  FixFloeBreakage(class LAMMPS *, int, char **);
  ~FixFloeBreakage() override;
  void pre_delete(bool) override;
  int setmask() override;
  void init() override;
  void setup(int) override;
  void end_of_step() override;
  void post_run() override;
  double compute_scalar() override { return total_; }
  double memory_usage() override;

 private:
  void collect();
  void write(const std::vector<double> &rows);
  std::string path_;
  FILE *file_ = nullptr;
  double total_ = 0.0;  // of all ranks
  int rows_ = 0;
};

}  // namespace LAMMPS_NS

#endif
