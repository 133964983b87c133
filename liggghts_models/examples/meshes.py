# SPDX-License-Identifier: GPL-2.0-or-later
"""Writes the walls of the examples: python meshes.py (they are in the repository already).

A wall is a chain of straight lines in the plane of the ice, drawn upright: two triangles a line.
"""

from __future__ import annotations

import math
from pathlib import Path

FOLDER = Path(__file__).parent
Corners = list[tuple[float, float]]


def write_wall(name: str, chains: list[Corners], height: float) -> None:
    """Write chains of corners (m) as triangles between -height and height."""
    lines = ["solid wall"]
    for corners in chains:
        for (xa, ya), (xb, yb) in zip(corners, corners[1:], strict=False):
            for triangle in (
                ((xa, ya, -height), (xb, yb, -height), (xb, yb, height)),
                ((xa, ya, -height), (xb, yb, height), (xa, ya, height)),
            ):
                lines += ["facet normal 0 0 0", "outer loop"]
                lines += [f"vertex {x:.6g} {y:.6g} {z:.6g}" for x, y, z in triangle]
                lines += ["endloop", "endfacet"]
    (FOLDER / name).write_text("\n".join([*lines, "endsolid wall", ""]))


def pieces(corners: Corners, longest: float) -> Corners:
    """Corners with more of them between, so that no line is longer than that."""
    out = [corners[0]]
    for (xa, ya), (xb, yb) in zip(corners, corners[1:], strict=False):
        count = math.ceil(math.hypot(xb - xa, yb - ya) / longest)
        out += [
            (xa + (xb - xa) * k / count, ya + (yb - ya) * k / count) for k in range(1, count + 1)
        ]
    return out


def main() -> None:
    """All walls."""
    km = 1000.0
    # compression: a plate above a pack of 40 km x 35 km
    write_wall("plate.stl", [pieces([(-2 * km, 36 * km), (42 * km, 36 * km)], 11 * km)], 4 * km)
    # brazilian: plates above and below a disc of 20 m
    for name, y in (("upper.stl", 10.05), ("lower.stl", -10.05)):
        write_wall(name, [pieces([(-8.0, y), (8.0, y)], 4.0)], 2.0)
    # ice_arch: shores that narrow to a strait 12 km wide
    left = [(-40 * km, 62 * km), (-40 * km, 30 * km), (-6 * km, 0.0), (-6 * km, -20 * km)]
    right = [(-x, y) for x, y in left]
    write_wall("strait.stl", [pieces(left, 12 * km), pieces(right, 12 * km)], 6 * km)
    # cyclone: a coast with a cape
    coast = [(-90 * km, -8 * km), (-40 * km, -11 * km), (-10 * km, -6.5 * km), (15 * km, -13 * km)]
    coast += [(90 * km, -9 * km)]
    write_wall("coast.stl", [pieces(coast, 25 * km)], 12 * km)
    # cylinder: a pillar of 60 m diameter
    ring = [
        (30.0 * math.cos(2 * math.pi * k / 24), 30.0 * math.sin(2 * math.pi * k / 24))
        for k in range(24)
    ]
    write_wall("cylinder.stl", [[*ring, ring[0]]], 8.0)


if __name__ == "__main__":
    main()
