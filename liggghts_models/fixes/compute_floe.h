// SPDX-License-Identifier: GPL-2.0-or-later
//
// compute ID group floe/bond/local word ...: a row for each bond with both ends in the group.
// compute ID group floe/atom word ...: numbers of each element.
#ifndef LMP_COMPUTE_FLOE_H
#define LMP_COMPUTE_FLOE_H

#include <vector>

#include "compute.h"

namespace LAMMPS_NS {

class ComputeFloeBondLocal : public Compute {
 public:
  ComputeFloeBondLocal(class LAMMPS *, int &iarg, int narg, char **arg);
  ~ComputeFloeBondLocal() override;
  void init() override;
  void compute_local() override;
  double memory_usage() override;

 private:
  std::vector<int> columns_;
  int rows_ = 0;
};

class ComputeFloeAtom : public Compute {
 public:
  ComputeFloeAtom(class LAMMPS *, int &iarg, int narg, char **arg);
  ~ComputeFloeAtom() override;
  void init() override;
  void compute_peratom() override;
  double memory_usage() override;

 private:
  std::vector<int> columns_;
  int rows_ = 0;
};

}  // namespace LAMMPS_NS

#endif
