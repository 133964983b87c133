// SPDX-License-Identifier: GPL-2.0-or-later
//
// Wind, current, Coriolis parameter and depth of the sea at an element: bilinear in space, linear in
// time, from a regular grid. The four velocities of a node lie side by side, because they are always read
// together. Outside of the grid the nearest edge holds; the driver checks that time is covered.
// At the element's centre, or as the mean over its disc.
#ifndef FLOE_LAWS_FORCING_H
#define FLOE_LAWS_FORCING_H

#include <algorithm>
#include <array>
#include <cmath>
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
  bool over_discs = false;       // means over discs, not values at centres
  bool wind_stress = false;      // wind is stored as |w| w (m2/s2), of which means keep the stress
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

// Places on a disc of radius 1 whose mean is that over the disc for polynomials up to degree 7: two
// rings of Gauss-Legendre in the squared radius, eight places each (floeflow/core/discs.py).
inline const std::array<Vec2, 16> &disc_places() {
  static const std::array<Vec2, 16> places = [] {
    std::array<Vec2, 16> out;
    for (int k = 0; k < 16; ++k) {
      const int ring = k / 8;
      const double r = std::sqrt(0.5 * (1.0 + (ring ? 1.0 : -1.0) / std::sqrt(3.0)));
      const double angle = 2.0 * M_PI * (k % 8 + 0.5 * ring) / 8.0;
      out[k] = {r * std::cos(angle), r * std::sin(angle)};
    }
    return out;
  }();
  return places;
}

// Whether a disc meets a line of nodes, where fields have their kinks; else its mean is the value at
// its centre.
inline bool meets_nodes(double position, double origin, double spacing, int n, double radius) {
  if (n == 1) return false;
  const double s = (position - origin) / spacing, reach = radius / spacing;
  return std::floor(s - reach) != std::floor(s + reach);
}

// Nodes of one axis that a disc meets: the first, and how many.
inline int nodes_met(double position, double origin, double spacing, int n, double radius,
                     int &count) {
  double weight;
  const int first = forcing_cell(position - radius, origin, spacing, n, weight);
  const int last = forcing_cell(position + radius, origin, spacing, n, weight);
  count = std::min(last + 2, n) - first;
  return first;
}

// Velocities are means over the disc; Coriolis parameter, vorticity and depth are its centre's.
inline ForcingSample disc_mean(const ForcingGrid &g, const ForcingTime &time, double x, double y,
                               double radius) {
  ForcingSample out = sample_forcing(g, time, x, y);
  if (!meets_nodes(x, g.x0, g.dx, g.nx, radius) && !meets_nodes(y, g.y0, g.dy, g.ny, radius)) {
    return out;
  }
  // Shares of the nodes are added up first, so that each node is read once.
  int columns, rows;
  const int left = nodes_met(x, g.x0, g.dx, g.nx, radius, columns);
  const int low = nodes_met(y, g.y0, g.dy, g.ny, radius, rows);
  constexpr int most = 64;
  double some[most];
  std::vector<double> many(columns * rows > most ? columns * rows : 0);
  double *const share = many.empty() ? some : many.data();
  std::fill(share, share + columns * rows, 0.0);
  const int right = columns > 1 ? 1 : 0, up = rows > 1 ? columns : 0;
  for (const Vec2 &at : disc_places()) {
    double wx, wy;
    const int ix = forcing_cell(x + radius * at.x, g.x0, g.dx, g.nx, wx) - left;
    const int iy = forcing_cell(y + radius * at.y, g.y0, g.dy, g.ny, wy) - low;
    double *const node = share + iy * columns + ix;
    node[0] += (1.0 - wx) * (1.0 - wy);
    node[right] += wx * (1.0 - wy);
    node[up] += (1.0 - wx) * wy;
    node[up + right] += wx * wy;
  }
  double mean[4] = {0.0, 0.0, 0.0, 0.0};
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const std::size_t node = 4 * (static_cast<std::size_t>(low + j) * g.nx + left + i);
      const double *a = time.before + node, *b = time.after + node;
      const double weight = share[j * columns + i] / 16.0;
      for (int k = 0; k < 4; ++k) mean[k] += weight * (a[k] + time.weight * (b[k] - a[k]));
    }
  }
  out.wind = {mean[0], mean[1]};
  out.ocean = {mean[2], mean[3]};
  return out;
}

// What acts on an element.
inline ForcingSample forcing_on(const ForcingGrid &g, const ForcingTime &time, double x, double y,
                                double radius) {
  ForcingSample out =
      g.over_discs ? disc_mean(g, time, x, y, radius) : sample_forcing(g, time, x, y);
  if (g.wind_stress) {
    const double size = std::sqrt(std::hypot(out.wind.x, out.wind.y));
    if (size > 0.0) out.wind = {out.wind.x / size, out.wind.y / size};
  }
  return out;
}

}  // namespace floe

#endif
