# SPDX-License-Identifier: GPL-2.0-or-later
"""Where old elements lie on fresh cells: areas and centres of what each pair shares.

An old cell is the polygon that the state keeps in the element's body frame: carried and turned
with the element, scaled about its centre to the element's effective area.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy import sparse

from floeflow.core.clip import shared
from floeflow.state.cells import polygons_of, rings_of

Array = NDArray[np.float64]
Index = NDArray[np.int64]

# Shares of an old cell below this are round-off of two outlines that coincide.
LEAST_PIECE = 1.0e-9
# A corner that turns inwards by less than this share of its polygon's area does not.
ROUND_OFF = 1.0e-12
# Grid on which GEOS intersects two bent outlines, m.
GRID = 1.0e-6


@dataclass(frozen=True)
class Pieces:
    """What old elements share with fresh cells, sorted by source, then target.

    Parameters
    ----------
    source, target : ndarray
        Rows of the old element and of the fresh cell, (k,).
    area : ndarray
        m2, (k,). Those of a source add up to its effective area.
    x, y : ndarray
        Centres (m), (k,).
    sources, targets : int
        How many there are; every source has a piece.
    """

    source: Index
    target: Index
    area: Array
    x: Array
    y: Array
    sources: int
    targets: int

    def matrix(self) -> sparse.csr_matrix:
        """Shared areas (m2), (sources, targets)."""
        shape = (self.sources, self.targets)
        return sparse.csr_matrix((self.area, (self.source, self.target)), shape=shape)


def carried_polygons(
    start: Index, corner: Array, place: Array, theta: Array, area: Array
) -> NDArray[np.object_]:
    """Old cells where their elements are now.

    Parameters
    ----------
    start, corner : ndarray
        Open rings in the body frames (m), (n + 1,) and (c, 2).
    place, theta : ndarray
        Centres (m), (n, 2), and orientations (rad), (n,).
    area : ndarray
        Area that each is scaled to, on the map (m2), (n,).

    Returns
    -------
    ndarray of shapely.Polygon
        (n,).
    """
    of = np.repeat(np.arange(len(theta)), np.diff(start))
    bare = polygons_of(start, corner)
    middle = shapely.get_coordinates(shapely.centroid(bare))
    scale = np.sqrt(area / shapely.area(bare))
    body = middle[of] + scale[of, None] * (corner - middle[of])
    cos, sin = np.cos(theta)[of], np.sin(theta)[of]
    turned = np.stack([cos * body[:, 0] - sin * body[:, 1], sin * body[:, 0] + cos * body[:, 1]])
    return polygons_of(start, turned.T + place[of])


def overlap(
    old: NDArray[np.object_], cells: NDArray[np.object_]
) -> tuple[Index, Index, Array, Array]:
    """Intersect old cells with fresh ones.

    A slice of the old cells gives the same rows as all of them.

    Parameters
    ----------
    old, cells : ndarray of shapely.Polygon
        (n,) and (m,).

    Returns
    -------
    source, target : ndarray
        Pairs that share more than round-off, sorted, (k,).
    area : ndarray
        m2 on the map, (k,).
    centre : ndarray
        m, (k, 2).
    """
    source, target = shapely.STRtree(cells).query(old)
    order = np.lexsort((target, source))
    source, target = source[order].astype(np.int64), target[order].astype(np.int64)
    area, centre = np.zeros(len(source)), np.zeros((len(source), 2))
    first, second = rings_of(old), rings_of(cells)
    by_cell, by_old = convex(*second)[target], convex(*first)[source]
    rows = np.flatnonzero(by_cell)
    area[rows], centre[rows] = shared(*first, *second, source[rows], target[rows])
    rows = np.flatnonzero(~by_cell & by_old)
    area[rows], centre[rows] = shared(*second, *first, target[rows], source[rows])
    rows = np.flatnonzero(~by_cell & ~by_old)
    # On a grid of the precision of the coordinates GEOS is slower, but safe.
    both = shapely.intersection(old[source[rows]], cells[target[rows]], grid_size=GRID)
    area[rows] = shapely.area(both)
    some = area[rows] > 0
    centre[rows[some]] = shapely.get_coordinates(shapely.centroid(both[some]))
    keep = area > LEAST_PIECE * shapely.area(old)[source]
    return source[keep], target[keep], area[keep], centre[keep]


def convex(start: Index, corner: Array) -> NDArray[np.bool_]:
    """Whether anticlockwise open rings have no corner that turns inwards by more than round-off.

    Parameters
    ----------
    start, corner : ndarray
        Starts (n + 1,) and corners (m), (c, 2); each ring has three corners or more.

    Returns
    -------
    ndarray
        Of bool, one a ring, (n,).
    """
    row = np.arange(len(corner))
    first, last = (np.repeat(each, np.diff(start)) for each in (start[:-1], start[1:] - 1))
    before = corner[np.where(row == first, last, row - 1)]
    after = corner[np.where(row == last, first, row + 1)]
    one, two = corner - before, after - corner
    turn = one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]
    # Of the triangle that a corner cuts off, or that it takes from the hull.
    if len(start) == 1:
        return np.zeros(0, dtype=bool)
    inwards = np.add.reduceat(np.maximum(-turn, 0.0), start[:-1])
    twice = np.add.reduceat(
        (before[:, 0] - corner[first, 0]) * (corner[:, 1] - corner[first, 1])
        - (before[:, 1] - corner[first, 1]) * (corner[:, 0] - corner[first, 0]),
        start[:-1],
    )
    return np.asarray(inwards <= ROUND_OFF * np.abs(twice))


def covered(source: Index, area: Array, old: NDArray[np.object_]) -> Array:
    """Share of each old cell that lies on fresh ones, (n,).

    Parameters
    ----------
    source : Index
        Old cell of each piece, (pieces,).
    area : ndarray
        Of each piece (m2), (pieces,).
    old : ndarray
        Polygons of the n old cells (m).

    Returns
    -------
    ndarray
        0 to 1, to round-off.
    """
    found = np.bincount(source, weights=area, minlength=len(old))
    return np.asarray(found / shapely.area(old))


def make_pieces(
    pairs: tuple[Index, Index, Array, Array], chosen: Index, area: Array, targets: int
) -> Pieces:
    """Pieces of some old elements, scaled so that each element's add up to its effective area.

    What lay outside of the cells (on land, where an element was pressed ashore) is thereby
    spread over the element's pieces at sea.

    Parameters
    ----------
    pairs : tuple
        From `overlap`.
    chosen : ndarray
        Rows of the old elements to keep, ascending, each with a pair; they are renumbered.
    area : ndarray
        Effective areas of the chosen (m2), (len(chosen),).
    targets : int
        Number of cells.

    Returns
    -------
    Pieces
        Of the chosen elements, whose areas (m2) add up to what is given.
    """
    source, target, shared, centre = pairs
    keep = np.isin(source, chosen)
    source, target = np.searchsorted(chosen, source[keep]), target[keep]
    shared, centre = shared[keep], centre[keep]
    total = np.bincount(source, weights=shared, minlength=len(chosen))
    scaled = shared * (area / total)[source]
    return Pieces(
        source, target, scaled, centre[:, 0], centre[:, 1], sources=len(chosen), targets=targets
    )
