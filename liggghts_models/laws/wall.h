// SPDX-License-Identifier: GPL-2.0-or-later
//
// Geometry of walls in the plane of the ice: straight faces, each part of a wall that moves at a
// constant velocity. A plane has no ends and ice on its left side only (looking from a to b); a face
// of a mesh ends at a and b, where it may meet a neighbour, and has two sides.
#ifndef FLOE_LAWS_WALL_H
#define FLOE_LAWS_WALL_H

#include <cmath>
#include <limits>
#include <vector>

#include "bond.h"

namespace floe {

struct WallFace {
  Vec2 a, b;          // m, at time 0
  Vec2 v;             // m/s
  int wall;           // to which it belongs
  bool plane;         // endless, one-sided
  int before, after;  // faces that it meets at a and b; -1: none
};

// Point of a face nearest to an element.
struct WallPoint {
  Vec2 d;           // from the element's centre to it, m
  double distance;  // |d|; of a plane below 0 where the centre lies behind it
  int end;          // -1 at a, 1 at b, 0 between
};

// Of a face that has moved by `moved` (m) to an element at x.
inline WallPoint wall_point(const WallFace &face, Vec2 moved, Vec2 x) {
  const Vec2 a{face.a.x + moved.x, face.a.y + moved.y};
  const Vec2 along{face.b.x - face.a.x, face.b.y - face.a.y};
  const Vec2 to_x{x.x - a.x, x.y - a.y};
  const double square = along.x * along.x + along.y * along.y;
  const double length = std::sqrt(square);
  const Vec2 left{-along.y / length, along.x / length};
  const double height = to_x.x * left.x + to_x.y * left.y;
  const double share = (to_x.x * along.x + to_x.y * along.y) / square;
  // A direction is needed even where the element's centre lies on the face.
  const double least = std::numeric_limits<double>::min();
  if (face.plane || (share > 0.0 && share < 1.0)) {
    const double h = height == 0.0 ? least : height;
    return {{-h * left.x, -h * left.y}, face.plane ? h : std::fabs(h), 0};
  }
  const Vec2 corner = share > 0.0 ? along : Vec2{0.0, 0.0};
  const Vec2 d{corner.x - to_x.x, corner.y - to_x.y};
  const double distance = std::sqrt(d.x * d.x + d.y * d.y);
  const int end = share > 0.0 ? 1 : -1;
  if (distance > 0.0) return {d, distance, end};
  return {{-least * left.x, -least * left.y}, least, end};
}

// Neighbour at the end where a point lies, or -1.
inline int wall_neighbour(const WallFace &face, int end) {
  if (end == 0) return -1;
  return end < 0 ? face.before : face.after;
}

// Whether the point `at` of face `k` counts for an element at x, or a neighbour speaks for it: the one
// that is nearer, or, where both are nearest at the corner they share, the one with the lower number.
template <typename Moved>
bool wall_point_counts(const std::vector<WallFace> &faces, int k, const WallPoint &at, Moved moved,
                       Vec2 x) {
  const int other = wall_neighbour(faces[k], at.end);
  if (other < 0) return true;
  const WallPoint there = wall_point(faces[other], moved(faces[other]), x);
  return wall_neighbour(faces[other], there.end) == k && k < other;
}

}  // namespace floe

#endif
