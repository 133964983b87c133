// SPDX-License-Identifier: GPL-2.0-or-later
//
// Wind, current, Coriolis parameter and depth of the sea at an element: bilinear in space, linear in
// time, from a regular grid. The four velocities of a node lie side by side, because they are always read
// together. Outside of the grid the nearest edge holds; the driver checks that time is covered.
#ifndef FLOE_LAWS_FORCING_H
#define FLOE_LAWS_FORCING_H

#include <algorithm>
#include <cstddef>
#include <vector>

#include "bond.h"

namespace floe {

struct ForcingSample {
  Vec2 wind, ocean;  // m/s
  double coriolis;   // 1/s
  double vorticity;  // of the ocean current, 1/s
  double depth;      // of the sea, m; 0 where it is not given
};

struct ForcingGrid {
  std::vector<double> time;   // s, ascending
  double x0 = 0.0, y0 = 0.0;  // first node, m
  double dx = 1.0, dy = 1.0;  // spacing, m
  int nx = 1, ny = 1;
  std::vector<double> velocity;  // [time][y][x][wind_u, wind_v, ocean_u, ocean_v]
  std::vector<double> coriolis;  // [y][x]
  std::vector<double> depth;     // [y][x], m; empty where no effect reads it
};

// Two neighbouring times and the weight of the later one.
struct ForcingTime {
  const double *before, *after;
  double weight;
};

inline ForcingTime forcing_time(const ForcingGrid &g, double t) {
  const std::size_t level = static_cast<std::size_t>(g.nx) * g.ny * 4;
  const std::size_t nt = g.time.size();
  const double *data = g.velocity.data();
  if (nt == 1 || t <= g.time.front()) return {data, data, 0.0};
  if (t >= g.time.back()) return {data + (nt - 1) * level, data + (nt - 1) * level, 0.0};
  const std::size_t k = std::upper_bound(g.time.begin(), g.time.end(), t) - g.time.begin();
  const double weight = (t - g.time[k - 1]) / (g.time[k] - g.time[k - 1]);
  return {data + (k - 1) * level, data + k * level, weight};
}

// Left node and weight of the right one along one axis.
inline int forcing_cell(double position, double origin, double spacing, int n, double &weight) {
  if (n == 1) {
    weight = 0.0;
    return 0;
  }
  const double s = std::min(std::max((position - origin) / spacing, 0.0), double(n - 1));
  const int k = std::min(static_cast<int>(s), n - 2);
  weight = s - k;
  return k;
}

inline ForcingSample sample_forcing(const ForcingGrid &g, const ForcingTime &time, double x,
                                    double y) {
  double wx, wy;
  const int ix = forcing_cell(x, g.x0, g.dx, g.nx, wx);
  const int iy = forcing_cell(y, g.y0, g.dy, g.ny, wy);
  const std::size_t n00 = static_cast<std::size_t>(iy) * g.nx + ix;
  const std::size_t right = g.nx > 1 ? 1 : 0, up = g.ny > 1 ? g.nx : 0;
  const std::size_t node[4] = {n00, n00 + right, n00 + up, n00 + up + right};
  double v[4][4];
  for (int c = 0; c < 4; ++c) {
    const double *a = time.before + 4 * node[c], *b = time.after + 4 * node[c];
    for (int k = 0; k < 4; ++k) v[c][k] = a[k] + time.weight * (b[k] - a[k]);
  }
  double out[4];
  for (int k = 0; k < 4; ++k) {
    const double south = v[0][k] + wx * (v[1][k] - v[0][k]);
    const double north = v[2][k] + wx * (v[3][k] - v[2][k]);
    out[k] = south + wy * (north - south);
  }
  const double dvdx = (v[1][3] - v[0][3]) + wy * ((v[3][3] - v[2][3]) - (v[1][3] - v[0][3]));
  const double dudy = (v[2][2] - v[0][2]) + wx * ((v[3][2] - v[1][2]) - (v[2][2] - v[0][2]));
  const auto steady = [&](const std::vector<double> &field) {
    if (field.empty()) return 0.0;
    const double *c = field.data();
    const double south = c[node[0]] + wx * (c[node[1]] - c[node[0]]);
    const double north = c[node[2]] + wx * (c[node[3]] - c[node[2]]);
    return south + wy * (north - south);
  };
  return {{out[0], out[1]},
          {out[2], out[3]},
          steady(g.coriolis),
          dvdx / g.dx - dudy / g.dy,
          steady(g.depth)};
}

}  // namespace floe

#endif
