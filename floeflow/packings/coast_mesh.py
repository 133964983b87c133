# SPDX-License-Identifier: GPL-2.0-or-later
"""Coasts as lines and as wall meshes: land polygons, simplified to the size of elements, extruded.

The STL goes to LIGGGHTS' `fix mesh/surface`, and to `walls.mesh` of a scene; the VTU to ParaView.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import shapely
from numpy.typing import NDArray

from floeflow.core.errors import FloeError
from floeflow.core.grids import Grid
from floeflow.core.meshes import write_triangles

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Flags = NDArray[np.bool_]

# Corners that lie nearer to a straight line than this share of an element's radius go.
SIMPLIFY = 0.5


def land_polygons(grid: Grid, land: Flags) -> list[shapely.Polygon]:
    """Land cells joined through their sides, without the sides on the rim of the grid.

    Parameters
    ----------
    grid, land
        Mask grid and its cells of land, (ny, nx).

    Returns
    -------
    list of shapely.Polygon
        m; with holes where water lies within.
    """
    row, column = np.nonzero(land)
    x, y = grid.x_edges, grid.y_edges
    joined = shapely.union_all(shapely.box(x[column], y[row], x[column + 1], y[row + 1]))
    return [part for part in shapely.get_parts(joined) if not part.is_empty]


def coast_segments(polygons: list[shapely.Polygon], radius: float) -> Array:
    """Lines of the coast, no corner nearer to a straight line than elements can tell.

    Polygons are simplified together (Visvalingam and Whyatt 1993, without crossings), so that a
    strait between two of them stays a strait. Islands too small for three sides keep their own.

    Parameters
    ----------
    polygons : list of shapely.Polygon
        Land (m).
    radius : float
        Mean radius of the elements (m).

    Returns
    -------
    ndarray
        Both ends of each line (m), land on the right, (n, 2, 2); lines that follow one another
        share ends to the bit.
    """
    if not polygons:
        return np.empty((0, 2, 2))
    simple = shapely.coverage_simplify(np.array(polygons), SIMPLIFY * radius)
    found = []
    for part in shapely.get_parts(simple):
        for ring in (part.exterior, *part.interiors):
            # Outer rings clockwise, holes anticlockwise: the sea lies to the left.
            outer = ring is part.exterior or shapely.equals(ring, part.exterior)
            corners = shapely.get_coordinates(ring)
            if ring.is_ccw == outer:
                corners = corners[::-1]
            found.append(np.stack([corners[:-1], corners[1:]], axis=1))
    return np.concatenate(found)


def write_coast_mesh(segments: Array, height: float, path: Path) -> None:
    """Write lines as a wall of triangles across the plane of the ice.

    Parameters
    ----------
    segments : ndarray
        From `coast_segments`, (n, 2, 2).
    height : float
        The wall reaches from minus to plus half of it (m).
    path : Path
        Ends in .stl or .vtu.

    Raises
    ------
    FloeError
        Where there is no coast, or the ending is another.
    """
    if path.suffix not in (".stl", ".vtu"):
        raise FloeError(f"{path}: a coast is written as .stl or .vtu")
    if not len(segments):
        raise FloeError(f"{path}: the scene has no coast to write")
    flat, corner = np.unique(segments.reshape(-1, 2), axis=0, return_inverse=True)
    low, high = (np.column_stack([flat, np.full(len(flat), z)]) for z in (-height / 2, height / 2))
    a, b = corner.reshape(-1, 2).T
    n = len(flat)
    triangles = np.concatenate(
        [np.stack([a, b, b + n], axis=1), np.stack([a, b + n, a + n], axis=1)]
    )
    write_triangles(path, np.concatenate([low, high]), triangles)
