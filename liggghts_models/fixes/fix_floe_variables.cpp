// SPDX-License-Identifier: GPL-2.0-or-later
//
// fix floe/integrate: wind and water that variables of the input script give.
#include "atom.h"
#include "error.h"
#include "fix_floe_integrate.h"
#include "input.h"
#include "modify.h"
#include "update.h"
#include "variable.h"

using namespace LAMMPS_NS;

void FixFloeIntegrate::find_variables() {
  for (int k = 0; k < 4; ++k) {
    variables_[k] = -1;
    if (variable_names_[k].empty()) continue;
    char *name = &variable_names_[k][0];
    variables_[k] = input->variable->find(name);
    const int v = variables_[k];
    if (v < 0 || !(input->variable->equalstyle(v) || input->variable->atomstyle(v))) {
      const std::string text = "Fix floe/integrate: there is no equal- or atom-style variable " +
                               variable_names_[k] + " for wind or water";
      error->all(FLERR, text.c_str());
    }
  }
}

void FixFloeIntegrate::sample_variables() {
  sampled_.assign(4 * static_cast<std::size_t>(atom->nlocal) + 4, 0.0);
  modify->clearstep_compute();
  for (int k = 0; k < 4; ++k) {
    const int v = variables_[k];
    if (v < 0) continue;
    if (input->variable->atomstyle(v)) {
      input->variable->compute_atom(v, igroup, sampled_.data() + k, 4, 0);
      continue;
    }
    const double value = input->variable->compute_equal(v);
    for (int i = 0; i < atom->nlocal; ++i) sampled_[4 * i + k] = value;
  }
  modify->addstep_compute(update->ntimestep + 1);
}

void FixFloeIntegrate::take_variables(int i, floe::ForcingSample &here) const {
  double *const to[4] = {&here.wind.x, &here.wind.y, &here.ocean.x, &here.ocean.y};
  for (int k = 0; k < 4; ++k) {
    if (variables_[k] >= 0) *to[k] = sampled_[4 * i + k];
  }
}
