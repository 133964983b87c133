# SPDX-License-Identifier: GPL-2.0-or-later
"""The radical (power) Voronoi tessellation of discs, clipped to the ice.

The power diagram is the projection of the lower hull of the points (x, y, x^2 + y^2 - r^2)
(Aurenhammer 1987). Discs that do not overlap lie inside their own power cells, and the edge between
two of them is the radical axis, which passes between the discs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from floeflow.core.clip import shared
from floeflow.core.grids import Grid
from floeflow.state.cells import rings_of

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Flags = NDArray[np.bool_]

# Ring of far points that closes the outermost cells: how many, and at how many half-diagonals.
GUARDS, GUARD_DISTANCE = 8, 6.0
# Corners of a cell nearer to each other than this share of their distance from its site are one.
SAME_CORNER = 1.0e-10
# Edges shorter than this share of the mean element's diameter are corners, not sides.
SHORTEST_EDGE = 1.0e-6
# A cell whose clipped area is smaller by less than this share is whole.
WHOLE = 1.0e-9


@dataclass(frozen=True)
class Diagram:
    """Power diagram of n discs.

    Parameters
    ----------
    polygons : ndarray of shapely.Polygon
        Convex cells, not clipped, anticlockwise, (n,).
    lo, hi : ndarray
        Neighbours, lo < hi, sorted, (m,).
    ends : ndarray
        End points of their shared edges, a on the right and b on the left as seen from lo to hi,
        (m, 2, 2) in metres.
    """

    polygons: NDArray[np.object_]
    lo: Index
    hi: Index
    ends: Array


def power_diagram(points: Array, radius: Array, grid: Grid) -> Diagram:
    """Power diagram of discs in the plane.

    Parameters
    ----------
    points : ndarray
        Centres (m), (n, 2), n >= 1.
    radius : ndarray
        Radii (m), (n,); no disc may hold another's centre.
    grid : Grid
        Its rectangle holds the points and is covered by their cells.

    Returns
    -------
    Diagram
        Cells tile at least the grid's rectangle.
    """
    count = len(points)
    low, high = (np.array([grid.x_edges[k], grid.y_edges[k]]) for k in (0, -1))
    middle, reach = 0.5 * (low + high), 0.5 * float(np.hypot(*(high - low)))
    angle = 2 * np.pi * (np.arange(GUARDS) + 0.5) / GUARDS
    ring = GUARD_DISTANCE * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    sites = np.concatenate([(points - middle) / reach, ring])
    weight = np.concatenate([(radius / reach) ** 2, np.zeros(GUARDS)])
    lifted = np.column_stack([sites, (sites**2).sum(axis=1) - weight])
    hull = ConvexHull(lifted)
    lower = hull.equations[:, 2] < 0
    number = np.cumsum(lower) - 1
    faces = hull.simplices[lower].astype(np.int64)
    beside = hull.neighbors[lower]
    beside = np.where(lower[beside], number[beside], -1)
    centres = _power_centres(sites, weight, faces)
    polygons = _cells(sites, faces, centres, count)
    polygons = shapely.transform(polygons, lambda xy: xy * reach + middle)
    lo, hi, ends = _edges(sites, faces, beside, centres, count)
    return Diagram(polygons, lo, hi, ends * reach + middle)


def _power_centres(sites: Array, weight: Array, faces: Index) -> Array:
    """Points of equal power to three discs, solved relative to the first for accuracy."""
    a, b, c = (sites[faces[:, k]] for k in range(3))
    wa, wb, wc = (weight[faces[:, k]] for k in range(3))
    p, q = b - a, c - a
    e = 0.5 * ((p**2).sum(axis=1) - wb + wa)
    f = 0.5 * ((q**2).sum(axis=1) - wc + wa)
    det = p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]
    x = (e * q[:, 1] - f * p[:, 1]) / det
    y = (f * p[:, 0] - e * q[:, 0]) / det
    return a + np.stack([x, y], axis=1)


def _cells(sites: Array, faces: Index, centres: Array, count: int) -> NDArray[np.object_]:
    """Convex cells: the power centres around each site in the order of their angle."""
    site, face = faces.ravel(), np.repeat(np.arange(len(faces)), 3)
    mine = site < count
    site, face = site[mine], face[mine]
    # Faces in a fixed order, whatever order the hull found them in.
    off = centres[face] - sites[site]
    angle = np.arctan2(off[:, 1], off[:, 0])
    order = np.lexsort((face, angle, site))
    site, corner, far = site[order], centres[face[order]], np.hypot(*off[order].T)
    # More than three sites of equal power at a point: it comes several times, in any order. A side
    # of round-off that runs backwards would clip all away.
    first = np.searchsorted(site, np.arange(count))
    before = np.arange(len(site)) - 1
    before[first] = np.append(first[1:], len(site)) - 1
    apart = np.hypot(*(corner - corner[before]).T) > SAME_CORNER * far
    rings = shapely.linearrings(corner[apart], indices=site[apart])
    return np.asarray(shapely.polygons(rings))


def _edges(
    sites: Array, faces: Index, beside: Index, centres: Array, count: int
) -> tuple[Index, Index, Array]:
    """Each side shared by two faces is dual to the edge between their power centres."""
    face = np.repeat(np.arange(len(faces)), 3)
    other = beside.ravel()
    # Side k of a face lies opposite to its corner k.
    one, two = np.roll(faces, -1, axis=1).ravel(), np.roll(faces, -2, axis=1).ravel()
    lo, hi = np.minimum(one, two), np.maximum(one, two)
    once = (face < other) & (hi < count)
    lo, hi, face, other = lo[once], hi[once], face[once], other[once]
    ends = np.stack([centres[face], centres[other]], axis=1)
    along, across = sites[hi] - sites[lo], ends[:, 1] - ends[:, 0]
    turned = along[:, 0] * across[:, 1] - along[:, 1] * across[:, 0] < 0
    ends[turned] = ends[turned][:, ::-1]
    order = np.lexsort((hi, lo))
    return lo[order], hi[order], ends[order]


@dataclass(frozen=True)
class Overlay:
    """Areas that cells share with the ice cells of the mask.

    Parameters
    ----------
    element, cell : ndarray
        Pairs: element and flat mask cell, sorted by element, (k,).
    area : ndarray
        Plane area of their intersection (m2), (k,).
    correction : float
        Largest change, as a share of a mask cell, that made the areas in each mask cell add up.
    """

    element: Index
    cell: Index
    area: Array
    correction: float


def overlay(polygons: NDArray[np.object_], grid: Grid, ice: Flags) -> Overlay:
    """Intersect convex cells with the ice cells of the mask, exactly.

    The areas in each mask cell are then scaled to add up to its area; what that changes is
    round-off and is returned.

    Parameters
    ----------
    polygons : ndarray of shapely.Polygon
        Cells that tile the plane around the ice.
    grid, ice
        Mask grid and its ice cells.

    Returns
    -------
    Overlay
        Element, cell of the mask and area (m2) of each piece, and the largest relative change by
        scaling.
    """
    start, ring = rings_of(polygons)
    element, cell = touched(grid, ice, shapely.bounds(polygons))
    cells, box = np.unique(cell, return_inverse=True)
    fours, corners = cell_corners(grid, cells)
    area, _ = shared(fours, corners, start, ring, box, element)
    some = area > 0
    element, box, area = element[some], box[some], area[some]
    total = np.bincount(box, weights=area, minlength=cells.size)
    scale = grid.spacing**2 / total
    return Overlay(element, cells[box], area * scale[box], float(np.abs(scale - 1.0).max()))


def cell_corners(grid: Grid, cells: Index) -> tuple[Index, Array]:
    """Squares of mask cells, given by flat index, as open rings: starts, and corners (m).

    Parameters
    ----------
    grid : Grid
        Cells of the mask.
    cells : Index
        Flat index, (k,).

    Returns
    -------
    tuple of Index and ndarray
        (k + 1,), and (4 k, 2).
    """
    row, column = np.divmod(cells, grid.x.size)
    x, y = grid.x_edges, grid.y_edges
    west, south, east, north = x[column], y[row], x[column + 1], y[row + 1]
    corners = np.stack([west, south, east, south, east, north, west, north], axis=1)
    return 4 * np.arange(cells.size + 1), corners.reshape(-1, 2)


def touched(grid: Grid, ice: Flags, bounds: Array) -> tuple[Index, Index]:
    """Pairs of rectangle (west, south, east, north) and flat flagged cell that meet, sorted.

    Parameters
    ----------
    grid : Grid
        Cells of the mask.
    ice : Flags
        Flags, (ny, nx).
    bounds : ndarray
        Rectangles (m), (n, 4).

    Returns
    -------
    tuple of Index
        Rectangle and cell of each pair, (pairs,).
    """
    first_row, first_column = grid.cell_of(bounds[:, 0], bounds[:, 1])
    last_row, last_column = grid.cell_of(bounds[:, 2], bounds[:, 3])
    wide = last_column - first_column + 1
    count = wide * (last_row - first_row + 1)
    of = np.repeat(np.arange(len(bounds)), count)
    rank = np.arange(len(of)) - np.repeat(np.cumsum(count) - count, count)
    up, right = np.divmod(rank, wide[of])
    cell = (first_row[of] + up) * grid.x.size + first_column[of] + right
    has = ice.ravel()[cell]
    return of[has], cell[has]


def cell_boxes(grid: Grid, cells: Index) -> NDArray[np.object_]:
    """Squares of mask cells given by flat index.

    Parameters
    ----------
    grid : Grid
        Cells of the mask.
    cells : Index
        Flat index, (k,).

    Returns
    -------
    ndarray
        Shapely boxes, (k,).
    """
    row, column = np.divmod(cells, grid.x.size)
    x, y = grid.x_edges, grid.y_edges
    return np.asarray(shapely.box(x[column], y[row], x[column + 1], y[row + 1]))


def clip(
    diagram: Diagram, found: Overlay, grid: Grid, shortest: float
) -> tuple[NDArray[np.object_], Index, Index, Array]:
    """Clip cells and edges to the ice.

    Of a cell that land cuts into parts the largest is kept as its polygon, of an edge the longest;
    areas do not come from here.

    Parameters
    ----------
    diagram, found
        Diagram and its overlay with the ice.
    grid : Grid
        The mask grid.
    shortest : float
        Edges shorter than this (m) are dropped.

    Returns
    -------
    polygons : ndarray of shapely.Polygon
        (n,), anticlockwise.
    lo, hi, ends
        As in `Diagram`, for the edges that are left.
    """
    count = len(diagram.polygons)
    covered = np.bincount(found.element, weights=found.area, minlength=count)
    whole = covered >= (1.0 - WHOLE) * shapely.area(diagram.polygons)
    polygons = diagram.polygons.copy()
    start = np.searchsorted(found.element, np.arange(count + 1))
    domain: dict[int, shapely.Geometry] = {}
    for number in np.flatnonzero(~whole).tolist():
        boxes = cell_boxes(grid, found.cell[start[number] : start[number + 1]])
        domain[number] = shapely.union_all(boxes)
        polygons[number] = _largest(shapely.intersection(polygons[number], domain[number]))
    ends = diagram.ends.copy()
    for edge in np.flatnonzero(~whole[diagram.lo] & ~whole[diagram.hi]):
        line = shapely.linestrings(ends[edge])
        both = shapely.union(domain[int(diagram.lo[edge])], domain[int(diagram.hi[edge])])
        ends[edge] = _longest(shapely.intersection(line, both), ends[edge])
    keep = np.hypot(*(ends[:, 1] - ends[:, 0]).T) >= shortest
    return shapely.orient_polygons(polygons), diagram.lo[keep], diagram.hi[keep], ends[keep]


def _largest(geometry: shapely.Geometry) -> shapely.Geometry:
    parts = [part for part in shapely.get_parts(geometry) if part.geom_type == "Polygon"]
    best = max(parts, key=lambda part: float(part.area))
    return shapely.Polygon(best.exterior)


def _longest(geometry: shapely.Geometry, ends: Array) -> Array:
    """Ends of the longest piece in the direction of the edge; a point where nothing is left."""
    parts = shapely.get_parts(shapely.line_merge(geometry))
    lines = [part for part in parts if part.geom_type == "LineString" and part.length > 0]
    if not lines:
        return np.stack([ends[0], ends[0]])
    best = shapely.get_coordinates(max(lines, key=lambda part: float(part.length)))
    piece = np.stack([best[0], best[-1]])
    forward = ((piece[1] - piece[0]) * (ends[1] - ends[0])).sum() >= 0
    return piece if forward else piece[::-1]
