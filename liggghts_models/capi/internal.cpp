// SPDX-License-Identifier: GPL-2.0-or-later
//
// C interface: what pairs and walls do to each element now, as the last evaluation left it.
#include <algorithm>

#include "atom.h"
#include "capi.h"
#include "columns.h"
#include "fix_floe_walls.h"
#include "lammps.h"
#include "pair_floe.h"
#include "parts.h"

using namespace LAMMPS_NS;
using floe::Vec2;

namespace {

enum Column { FLOE_INTERNAL_COLUMNS(FLOE_COLUMN) column_count };

// Adds a force that acts at the end of an arm from the element's centre.
void add(double *row, Vec2 arm, Vec2 f) {
  row[force_x] += f.x;
  row[force_y] += f.y;
  row[moment_xx] += arm.x * f.x;
  row[moment_yy] += arm.y * f.y;
  row[moment_xy] += 0.5 * (arm.x * f.y + arm.y * f.x);
}

}  // namespace

extern "C" {

int floe_internal(void *instance, double *columns) {
  return floe::guarded([&] {
    const Atom *atom = floe::instance_of(instance)->atom;
    const floe::Parts parts = floe::find_parts(floe::instance_of(instance));
    if (!parts.floe) throw floe::LiggghtsError("there is no pair_style gran model floe");
    const auto row = [columns](int i) {
      return columns + static_cast<long long>(column_count) * i;
    };
    std::fill(columns, row(atom->nlocal), 0.0);
    parts.floe->each_pair([&](const floe::PairState &p) {
      // Two elements meet where their radii share the way between their centres.
      const double one = atom->radius[p.i] / (atom->radius[p.i] + atom->radius[p.j]);
      add(row(p.i), {one * p.d.x, one * p.d.y}, p.f);
      // The rank of a ghost meets the pair too.
      if (p.j >= atom->nlocal) return;
      const double two = one - 1.0;
      add(row(p.j), {two * p.d.x, two * p.d.y}, {-p.f.x, -p.f.y});
    });
    const FixFloeWalls *walls = floe::find_walls(instance);
    if (walls) walls->each_force([&](int i, Vec2 arm, Vec2 f) { add(row(i), arm, f); });
  });
}

}  // extern "C"
