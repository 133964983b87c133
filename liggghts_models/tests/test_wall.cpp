// SPDX-License-Identifier: GPL-2.0-or-later
#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include "wall.h"

using floe::Vec2;
using floe::wall_point;
using floe::WallFace;
using floe::WallPoint;

namespace {

const auto at_rest = [](const WallFace &) { return Vec2{0.0, 0.0}; };

// Faces that count for an element at x.
std::vector<int> counting(const std::vector<WallFace> &faces, Vec2 x) {
  std::vector<int> out;
  for (int k = 0; k < static_cast<int>(faces.size()); ++k) {
    const WallPoint at = wall_point(faces[k], {0.0, 0.0}, x);
    if (floe::wall_point_counts(faces, k, at, at_rest, x)) out.push_back(k);
  }
  return out;
}

}  // namespace

TEST_CASE("a face has two sides and ends, a plane one side and none") {
  const WallFace face{{0, 0}, {4, 0}, {0, 0}, 0, false, -1, -1};
  const WallPoint below = wall_point(face, {0, 0}, {1, -2});
  CHECK(below.distance == 2.0);
  CHECK(below.d.y == 2.0);
  CHECK(below.end == 0);
  const WallPoint beyond = wall_point(face, {0, 0}, {7, 4});
  CHECK(beyond.distance == 5.0);
  CHECK(beyond.end == 1);
  const WallFace plane{{0, 0}, {4, 0}, {0, 0}, 0, true, -1, -1};
  CHECK(wall_point(plane, {0, 0}, {7, 4}).distance == 4.0);
  const WallPoint behind = wall_point(plane, {0, 0}, {1, -2});
  CHECK(behind.distance == -2.0);
  CHECK(behind.d.y == 2.0);  // over the distance: the normal still points out of the ice
  CHECK(wall_point(plane, {0, 1}, {1, 5}).distance == 4.0);
}

TEST_CASE("a centre on a face still has a normal") {
  const WallFace face{{0, 0}, {4, 0}, {0, 0}, 0, false, -1, -1};
  for (const Vec2 x : {Vec2{1, 0}, Vec2{4, 0}, Vec2{0, 0}}) {
    const WallPoint at = wall_point(face, {0, 0}, x);
    CHECK(std::fabs(at.d.y / at.distance) == 1.0);
  }
}

TEST_CASE("one corner pushes once, two sides twice") {
  // A right angle; its corner at the origin.
  const std::vector<WallFace> bend{{{-9, 0}, {0, 0}, {0, 0}, 0, false, -1, 1},
                                   {{0, 0}, {0, 9}, {0, 0}, 0, false, 0, -1}};
  CHECK(counting(bend, {1, -1}) == std::vector<int>{0});     // outside: the corner, once
  CHECK(counting(bend, {-1, 1}) == std::vector<int>{0, 1});  // inside: both sides
  CHECK(counting(bend, {-1, -1}) == std::vector<int>{0});    // below the first, off the second
  CHECK(counting(bend, {1, 1}) == std::vector<int>{1});
  // Free ends push too.
  CHECK(counting(bend, {-10, 0.5}) == std::vector<int>{0, 1});
}
