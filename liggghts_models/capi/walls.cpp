// SPDX-License-Identifier: GPL-2.0-or-later
//
// C interface: walls, their contacts in and out, the impulses that they gave.
#include <algorithm>
#include <unordered_map>
#include <utility>
#include <vector>

#include "atom.h"
#include "capi.h"
#include "columns.h"
#include "fix_floe_integrate.h"
#include "fix_floe_walls.h"
#include "history.h"
#include "parts.h"

using namespace LAMMPS_NS;
namespace slot = floe::slot;

namespace {

enum Number { FLOE_FACE_NUMBERS(FLOE_COLUMN) number_count };
enum Column { FLOE_FACE_COLUMNS(FLOE_COLUMN) column_count };
constexpr int contact_width = sizeof floe::contact_columns / sizeof *floe::contact_columns;

}  // namespace

extern "C" {

int floe_set_walls(void *instance, long long walls, long long n, const long long *integers,
                   const double *columns) {
  return floe::guarded([&] {
    std::vector<floe::WallFace> faces;
    for (long long k = 0; k < n; ++k) {
      const double *row = columns + column_count * k;
      const long long *whole = integers + number_count * k;
      faces.push_back({{row[ax], row[ay]},
                       {row[bx], row[by]},
                       {row[u], row[v]},
                       static_cast<int>(whole[wall]),
                       whole[plane] != 0,
                       static_cast<int>(whole[before]),
                       static_cast<int>(whole[after])});
    }
    floe::walls_of(instance)->set_walls(std::move(faces), static_cast<int>(walls));
  });
}

int floe_put_wall_contacts(void *instance, long long n, const long long *ids,
                           const double *columns) {
  return floe::guarded([&] {
    FixFloeWalls *walls = floe::walls_of(instance);
    const FixFloeIntegrate *fix = floe::fix_of(instance);
    const Atom *atom = floe::instance_of(instance)->atom;
    std::unordered_multimap<long long, long long> rows;
    for (long long k = 0; k < n; ++k) rows.emplace(ids[2 * k], k);
    for (int i = 0; i < atom->nlocal; ++i) {
      const auto range = rows.equal_range(atom->tag[i]);
      for (auto found = range.first; found != range.second; ++found) {
        const long long k = found->second;
        double h[slot::ridge_size] = {};
        floe::take_columns(floe::contact_columns, columns + contact_width * k, h);
        h[slot::ridge_cover] = fix->cover[i];
        walls->put(atom->tag[i], {static_cast<int>(ids[2 * k + 1]),
                                  {h[slot::slip], h[slot::rest_overlap], floe::ridge_at(h)}});
      }
    }
  });
}

long long floe_count_wall_contacts(void *instance) {
  return floe::counted([&] {
    long long n = 0;
    if (FixFloeWalls *walls = floe::find_walls(instance)) {
      walls->each([&n](int, const FixFloeWalls::Contact &) { ++n; });
    }
    return n;
  });
}

int floe_get_wall_contacts(void *instance, long long *ids, double *columns) {
  return floe::guarded([&] {
    FixFloeWalls *walls = floe::find_walls(instance);
    if (!walls) return;
    const Atom *atom = floe::instance_of(instance)->atom;
    walls->each([&](int i, const FixFloeWalls::Contact &c) {
      *ids++ = atom->tag[i];
      *ids++ = c.face;
      double h[slot::ridge_size] = {};
      h[slot::slip] = c.history.slip;
      h[slot::rest_overlap] = c.history.rest_overlap;
      floe::put_ridge(c.history.ridge, h);
      floe::give_columns(floe::contact_columns, h, columns);
      columns += contact_width;
    });
  });
}

int floe_wall_forces(void *instance, double *impulses, double *forces) {
  return floe::guarded([&] {
    const FixFloeWalls *walls = floe::find_walls(instance);
    if (!walls) return;
    std::copy(walls->impulses().begin(), walls->impulses().end(), impulses);
    std::copy(walls->forces().begin(), walls->forces().end(), forces);
  });
}

}  // extern "C"
