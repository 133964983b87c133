# SPDX-License-Identifier: GPL-2.0-or-later
"""The coast as closed lines: what no ice passes.

Coast elements stand in the outermost land cells, with gaps between them. The lines around the land
have none: they become faces of a wall (`floeflow.state.walls`).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import shapely
from numpy.typing import NDArray

from floeflow.core.grids import Grid

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Index = NDArray[np.int64]

# Corners that stick out into the sea are cut where they are sharper than this share of a mask cell.
CUT = 0.1
# Centres keep this distance from the coast, in mean radii, where there is room.
CLEARANCE = 0.1
# Corners that lie on a line but for this much are left out, m.
GRID = 1.0


def coastline(grid: Grid, land: Flags) -> tuple[Index, Array]:
    """Rings around the land, inside of it everywhere: no strait of the mask gets narrower.

    Parameters
    ----------
    grid : Grid
        The mask grid.
    land : ndarray
        Its cells of land, (ny, nx).

    Returns
    -------
    start : ndarray
        Where each open ring begins, (k + 1,).
    corner : ndarray
        Corners (m), (c, 2).
    """
    x, y = np.meshgrid(grid.x, grid.y)
    half = 0.5 * grid.spacing
    west, east = x[land] - half, x[land] + half
    cells = shapely.box(west, y[land] - half, east, y[land] + half)
    whole = shapely.coverage_union_all(cells)
    cut = CUT * grid.spacing
    opened = whole.buffer(-cut, join_style="mitre").buffer(cut, join_style="round", quad_segs=1)
    parts = [part for part in shapely.get_parts(opened.simplify(GRID)) if not part.is_empty]
    rings = [ring for part in parts for ring in (part.exterior, *part.interiors)]
    corners = [shapely.get_coordinates(ring)[:-1] for ring in rings]
    start = np.concatenate([[0], np.cumsum([len(ring) for ring in corners])]).astype(np.int64)
    return start, np.concatenate(corners) if corners else np.empty((0, 2))


def off_shore(
    places: Array, start: Index, corner: Array, least: float, allowed: Callable[[Array], Flags]
) -> Array:
    """Places moved so that each keeps a distance from the coast.

    Parameters
    ----------
    places : ndarray
        Centres of elements at sea (m), (n, 2).
    start, corner : ndarray
        Rings of the coast, from `coastline`.
    least : float
        Distance that is to be kept where there is room, m.
    allowed : callable
        Tells of places (m), (k, 2), which may be taken.

    Returns
    -------
    ndarray
        m, (n, 2); where no place around has the distance, that with the most room.
    """
    places = places.copy()
    if len(corner) == 0 or len(places) == 0:
        return places
    of = np.repeat(np.arange(len(start) - 1), np.diff(start))
    closed = shapely.linearrings(corner, indices=of)
    lines, land = (
        shapely.multilinestrings(np.asarray(closed)),
        shapely.union_all(shapely.make_valid(shapely.polygons(closed))),
    )
    shapely.prepare(land)
    turn = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
    around = least * np.column_stack([np.cos(turn), np.sin(turn)])
    near = np.flatnonzero(shapely.distance(shapely.points(places), lines) < least)
    for row in near:
        # The best of the places around: at sea, and furthest from the coast.
        choices = np.concatenate([places[[row]], places[row] + 0.5 * around, places[row] + around])
        found = shapely.points(choices)
        ashore = shapely.contains(land, found) | ~allowed(choices)
        room = np.where(ashore, -1.0, shapely.distance(found, lines))
        enough = np.flatnonzero(room >= least)
        places[row] = choices[enough[0] if len(enough) else int(np.argmax(room))]
    return places
