// SPDX-License-Identifier: GPL-2.0-or-later
//
// C interface: walls, their contacts in and out, the impulses that they gave.
#include <algorithm>
#include <unordered_map>
#include <utility>
#include <vector>

#include "atom.h"
#include "capi.h"
#include "fix_floe_integrate.h"
#include "fix_floe_walls.h"
#include "lammps.h"
#include "liggghts_error.h"
#include "plugin.h"

using namespace LAMMPS_NS;

namespace {

constexpr int face_columns = 6, face_numbers = 4, contact_columns = 5;

// Null where there are none.
FixFloeWalls *find_walls(void *instance) {
  return floe::find_parts(static_cast<LAMMPS *>(instance)).walls;
}

FixFloeWalls *walls_of(void *instance) {
  FixFloeWalls *walls = find_walls(instance);
  if (!walls) throw floe::LiggghtsError("there is no fix floe/walls");
  return walls;
}

}  // namespace

extern "C" {

int floe_set_walls(void *instance, long long walls, long long n, const long long *integers,
                   const double *columns) {
  return floe::guarded([&] {
    std::vector<floe::WallFace> faces;
    for (long long k = 0; k < n; ++k) {
      const double *row = columns + face_columns * k;
      const long long *whole = integers + face_numbers * k;
      faces.push_back({{row[0], row[1]},
                       {row[2], row[3]},
                       {row[4], row[5]},
                       static_cast<int>(whole[0]),
                       whole[1] != 0,
                       static_cast<int>(whole[2]),
                       static_cast<int>(whole[3])});
    }
    walls_of(instance)->set_walls(std::move(faces), static_cast<int>(walls));
  });
}

int floe_put_wall_contacts(void *instance, long long n, const long long *ids,
                           const double *columns) {
  return floe::guarded([&] {
    FixFloeWalls *walls = walls_of(instance);
    const FixFloeIntegrate *fix = floe::find_parts(static_cast<LAMMPS *>(instance)).fix;
    const Atom *atom = static_cast<LAMMPS *>(instance)->atom;
    std::unordered_multimap<long long, long long> rows;
    for (long long k = 0; k < n; ++k) rows.emplace(ids[2 * k], k);
    for (int i = 0; i < atom->nlocal; ++i) {
      const auto range = rows.equal_range(atom->tag[i]);
      for (auto found = range.first; found != range.second; ++found) {
        const long long k = found->second;
        const double *row = columns + contact_columns * k;
        walls->put(atom->tag[i], {static_cast<int>(ids[2 * k + 1]),
                                  {row[0], row[1], {row[2], row[3], row[4], fix->cover[i]}}});
      }
    }
  });
}

long long floe_count_wall_contacts(void *instance) {
  long long n = 0;
  if (FixFloeWalls *walls = find_walls(instance)) {
    walls->each([&n](int, const FixFloeWalls::Contact &) { ++n; });
  }
  return n;
}

int floe_get_wall_contacts(void *instance, long long *ids, double *columns) {
  return floe::guarded([&] {
    FixFloeWalls *walls = find_walls(instance);
    if (!walls) return;
    const Atom *atom = static_cast<LAMMPS *>(instance)->atom;
    walls->each([&](int i, const FixFloeWalls::Contact &c) {
      *ids++ = atom->tag[i];
      *ids++ = c.face;
      for (double value : {c.history.slip, c.history.rest_overlap, c.history.ridge.closing,
                           c.history.ridge.thickness, c.history.ridge.length}) {
        *columns++ = value;
      }
    });
  });
}

int floe_wall_forces(void *instance, double *impulses, double *forces) {
  return floe::guarded([&] {
    const FixFloeWalls *walls = find_walls(instance);
    if (!walls) return;
    std::copy(walls->impulses().begin(), walls->impulses().end(), impulses);
    std::copy(walls->forces().begin(), walls->forces().end(), forces);
  });
}

}  // extern "C"
