# SPDX-License-Identifier: GPL-2.0-or-later
"""Outlines of cells that are only partly filled: the ice edge inside of a cell."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Halvings of the place of a straight edge; what is left is taken up by scaling the outline.
HALVINGS = 40
# A cell filled up to this share of itself is whole.
WHOLE = 1.0 - 1.0e-9


def cut(polygons: NDArray[np.object_], share: Array, middle: Array) -> NDArray[np.object_]:
    """Cut cells by a straight line so that a share of each is left, on the side of its content.

    The line lies across the way from the cell's centre to that of its content, nearly the choice
    of the moment-of-fluid method (Dyadechko & Shashkov 2005), which puts the cut cell's centre
    nearest to the content's.

    Parameters
    ----------
    polygons : ndarray of shapely.Polygon
        (m,).
    share : ndarray
        Share of each cell that is filled, (m,).
    middle : ndarray
        Centres of what fills them (m), (m, 2).

    Returns
    -------
    ndarray of shapely.Polygon
        (m,); the largest part where a bent cell falls apart.
    """
    out = polygons.copy()
    part = np.flatnonzero(share < WHOLE)
    if not len(part):
        return out
    whole, wanted = polygons[part], share[part] * shapely.area(polygons[part])
    centre = shapely.get_coordinates(shapely.centroid(whole))
    along = middle[part] - centre
    size = np.hypot(*along.T)
    along = np.where(size[:, None] > 0, along / np.maximum(size, 1e-300)[:, None], [1.0, 0.0])
    reach = np.hypot(*(shapely.bounds(whole)[:, 2:] - shapely.bounds(whole)[:, :2]).T)
    low, high = -reach, reach.copy()
    for _ in range(HALVINGS):
        at = 0.5 * (low + high)
        left = shapely.area(shapely.intersection(whole, _half(centre, along, at, reach)))
        low, high = np.where(left > wanted, at, low), np.where(left > wanted, high, at)
    pieces = shapely.intersection(whole, _half(centre, along, low, reach))
    out[part] = [_largest(piece) for piece in pieces]
    return out


def _half(centre: Array, along: Array, at: Array, reach: Array) -> NDArray[np.object_]:
    """Squares that cover a cell's half beyond a line, at a way from its centre (m)."""
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    side = 2.0 * reach[:, None]
    foot = centre + at[:, None] * along
    corners = (foot - side * across, foot - side * across + 2 * side * along)
    other = (foot + side * across + 2 * side * along, foot + side * across)
    return np.asarray(shapely.polygons(np.stack([*corners, *other], axis=1)))


def _largest(piece: shapely.Geometry) -> shapely.Polygon:
    parts = [part for part in shapely.get_parts(piece) if part.geom_type == "Polygon"]
    return shapely.Polygon(max(parts, key=lambda part: float(part.area)).exterior)
