// SPDX-License-Identifier: GPL-2.0-or-later
#include "compute_floe.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "atom.h"
#include "domain.h"
#include "error.h"
#include "fix_floe_integrate.h"
#include "memory.h"
#include "pair_floe.h"
#include "plugin.h"
#include "update.h"

using namespace LAMMPS_NS;

namespace {

const std::vector<std::string> bond_words{
    "id1",   "id2",    "x",         "y",      "whole",   "normal_min", "normal_max",
    "shear", "length", "thickness", "energy", "force_x", "force_y"};
const std::vector<std::string> atom_words{"nbond",    "damage",      "thickness",
                                          "ice_area", "ridged_area", "angle"};

// Which words were asked for, in their order; all where none was.
std::vector<int> chosen(const char *style, const std::vector<std::string> &words, int first,
                        int narg, char **arg, Error *error) {
  std::vector<int> out;
  for (int k = first; k < narg; ++k) {
    const auto found = std::find(words.begin(), words.end(), arg[k]);
    if (found == words.end()) {
      std::string text = std::string("Compute ") + style + ": unknown word " + arg[k] + "; known:";
      for (const std::string &word : words) text += " " + word;
      error->all(FLERR, text.c_str());
    }
    out.push_back(static_cast<int>(found - words.begin()));
  }
  const bool all = out.empty();
  for (int k = 0; all && k < static_cast<int>(words.size()); ++k) out.push_back(k);
  return out;
}

floe::Parts parts_of(LAMMPS *lmp, const char *style, Error *error) {
  const floe::Parts parts = floe::find_parts(lmp);
  if (!parts.floe || !parts.fix) {
    const std::string text = std::string("Compute ") + style +
                             " needs pair_style gran model floe and fix floe/integrate";
    error->all(FLERR, text.c_str());
  }
  return parts;
}

}  // namespace

ComputeFloeBondLocal::ComputeFloeBondLocal(LAMMPS *lmp, int &iarg, int narg, char **arg)
    : Compute(lmp, iarg, narg, arg), columns_(chosen(style, bond_words, iarg, narg, arg, error)) {
  iarg = narg;
  local_flag = 1;
  vector_local = nullptr;  // LIGGGHTS leaves them open
  array_local = nullptr;
  size_local_cols = columns_.size() == 1 ? 0 : static_cast<int>(columns_.size());
}

ComputeFloeBondLocal::~ComputeFloeBondLocal() {
  memory->destroy(array_local);
  memory->destroy(vector_local);
}

void ComputeFloeBondLocal::init() { parts_of(lmp, style, error); }

void ComputeFloeBondLocal::compute_local() {
  invoked_local = update->ntimestep;
  const floe::Parts parts = parts_of(lmp, style, error);
  std::vector<double> values;
  int rows = 0;
  parts.floe->each_pair([&](const floe::PairState &p) {
    if (p.bond < 0) return;
    const floe::BondState b = parts.floe->bond_state(p.bond);
    // A bond across two ranks is met on both: that with the lower id speaks for it.
    if (p.share < 1.0 && p.i != b.lo) return;
    if (!(atom->mask[b.lo] & groupbit) || !(atom->mask[b.hi] & groupbit)) return;
    double centre[3] = {b.centre.x, b.centre.y, 0.0};
    domain->remap(centre);
    const double sign = p.i == b.lo ? 1.0 : -1.0;
    const double row[] = {static_cast<double>(atom->tag[b.lo]),
                          static_cast<double>(atom->tag[b.hi]),
                          centre[0],
                          centre[1],
                          b.whole,
                          b.least,
                          b.most,
                          b.shear,
                          b.length,
                          b.thickness,
                          b.energy,
                          sign * p.f.x,
                          sign * p.f.y};
    for (const int column : columns_) values.push_back(row[column]);
    ++rows;
  });
  size_local_rows = rows;
  if (rows > rows_) {
    rows_ = rows;
    if (size_local_cols)
      memory->grow(array_local, rows_, size_local_cols, "floe/bond/local:array");
    else
      memory->grow(vector_local, rows_, "floe/bond/local:vector");
  }
  if (rows == 0) return;
  std::copy(values.begin(), values.end(), size_local_cols ? array_local[0] : vector_local);
}

double ComputeFloeBondLocal::memory_usage() {
  return static_cast<double>(rows_) * columns_.size() * sizeof(double);
}

ComputeFloeAtom::ComputeFloeAtom(LAMMPS *lmp, int &iarg, int narg, char **arg)
    : Compute(lmp, iarg, narg, arg), columns_(chosen(style, atom_words, iarg, narg, arg, error)) {
  iarg = narg;
  peratom_flag = 1;
  vector_atom = nullptr;
  array_atom = nullptr;
  size_peratom_cols = columns_.size() == 1 ? 0 : static_cast<int>(columns_.size());
}

ComputeFloeAtom::~ComputeFloeAtom() {
  memory->destroy(array_atom);
  memory->destroy(vector_atom);
}

void ComputeFloeAtom::init() { parts_of(lmp, style, error); }

void ComputeFloeAtom::compute_peratom() {
  invoked_peratom = update->ntimestep;
  const floe::Parts parts = parts_of(lmp, style, error);
  const int count = atom->nlocal;
  std::vector<double> bonds(atom->nlocal + atom->nghost, 0.0), whole(bonds);
  parts.floe->each_pair([&](const floe::PairState &p) {
    if (p.bond < 0) return;
    const double share = parts.floe->bond_state(p.bond).whole;
    for (const int i : {p.i, p.j}) {
      bonds[i] += 1.0;
      whole[i] += share;
    }
  });
  if (atom->nmax > rows_) {
    rows_ = atom->nmax;
    if (size_peratom_cols)
      memory->grow(array_atom, rows_, size_peratom_cols, "floe/atom:array");
    else
      memory->grow(vector_atom, rows_, "floe/atom:vector");
  }
  const FixFloeIntegrate &fix = *parts.fix;
  for (int i = 0; i < count; ++i) {
    const double made = fix.bonds_made[i];
    const double area =
        fix.ice_area[i] < 0.0 ? M_PI * atom->radius[i] * atom->radius[i] : fix.ice_area[i];
    const double row[] = {bonds[i],           made > 0.0 ? 1.0 - whole[i] / made : 0.0,
                          fix.thickness[i],   area,
                          fix.ridged_area[i], fix.theta[i]};
    const bool in = atom->mask[i] & groupbit;
    double *to = size_peratom_cols ? array_atom[i] : vector_atom + i;
    for (std::size_t k = 0; k < columns_.size(); ++k) to[k] = in ? row[columns_[k]] : 0.0;
  }
}

double ComputeFloeAtom::memory_usage() {
  return static_cast<double>(rows_) * columns_.size() * sizeof(double);
}
