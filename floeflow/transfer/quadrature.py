# SPDX-License-Identifier: GPL-2.0-or-later
"""Points over the cells of elements, to take means over them.

Cells are discs, or polygons as the packing leaves them. Points are dense enough for a grid's
spacing: the mean of a field that is linear across the grid's cells is exact, of others nearly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from floeflow.core.errors import FloeError
from floeflow.transfer.stencil import Array, Index


@dataclass(frozen=True)
class Points:
    """Points over the cells of elements.

    Parameters
    ----------
    x, y : ndarray
        Places (m), (points,).
    mean : scipy.sparse.csr_array
        Share of each point in its element's mean, (n, points): rows add up to 1.
    """

    x: Array
    y: Array
    mean: csr_array


def disc_points(x: Array, y: Array, radius: Array, spacing: float) -> Points:
    """Points over discs: Gauss-Legendre in the squared radius, even angles.

    Parameters
    ----------
    x, y, radius : ndarray
        Discs (m), (n,).
    spacing : float
        Grid spacing that the points must resolve (m).

    Returns
    -------
    Points
        Places (m), (p,), and the matrix (n, p) that takes means over the discs.

    Raises
    ------
    FloeError
        For a radius or spacing that is not above 0.
    """
    if not (radius > 0.0).all() or not spacing > 0.0:
        raise FloeError("remap: discs need radii, and points a spacing, above 0 m")
    rings = max(1, int(np.ceil(2.0 * radius.max(initial=0.0) / spacing)))
    spokes = 4 * rings + 2
    nodes, shares = np.polynomial.legendre.leggauss(rings)
    r = np.sqrt(0.5 * (nodes + 1.0))
    # Rings are turned against each other, so that spokes do not line up with the grid.
    angle = 2.0 * np.pi * (np.arange(spokes) + 0.5 * (np.arange(rings) % 2)[:, None]) / spokes
    dx, dy = (r[:, None] * np.cos(angle)).ravel(), (r[:, None] * np.sin(angle)).ravel()
    weight = np.repeat(0.5 * shares / spokes, spokes)
    per, n = len(weight), len(x)
    start = per * np.arange(n + 1)
    mean = csr_array((np.tile(weight, n), np.arange(per * n), start), shape=(n, per * n))
    px, py = x[:, None] + radius[:, None] * dx, y[:, None] + radius[:, None] * dy
    return Points(px.ravel(), py.ravel(), mean)


def polygon_points(start: Index, x: Array, y: Array, spacing: float) -> Points:
    """Points over convex polygons: triangles from the first corner, cut up, three points each.

    Parameters
    ----------
    start : ndarray of int
        First corner of each polygon, and the end, (n + 1,).
    x, y : ndarray
        Corners of the open rings (m), (corners,).
    spacing : float
        Grid spacing that the points must resolve (m).

    Returns
    -------
    Points
        Places (m), (p,), and the matrix (n, p) that takes means over the polygons.

    Raises
    ------
    FloeError
        For a polygon of fewer than three corners, by its number.
    """
    count = np.diff(start)
    if (count < 3).any():
        raise FloeError(f"remap: the cell of element {int(np.argmax(count < 3))} is not a polygon")
    owner = np.repeat(np.arange(len(count)), count - 2)
    rank = np.arange(len(owner)) - np.repeat(np.cumsum(count - 2) - (count - 2), count - 2)
    first, second = start[:-1][owner], start[:-1][owner] + rank + 1
    corner = np.stack([first, second, second + 1], axis=1)
    px, py = x[corner], y[corner]
    size = max(np.ptp(px, axis=1).max(initial=0.0), np.ptp(py, axis=1).max(initial=0.0))
    for _ in range(max(0, int(np.ceil(np.log2(max(size / spacing, 1e-9)))))):
        px, py = _quarter(px), _quarter(py)
        owner = np.repeat(owner, 4)
    ux, uy = px[:, 1] - px[:, 0], py[:, 1] - py[:, 0]
    area = 0.5 * np.abs(ux * (py[:, 2] - py[:, 0]) - uy * (px[:, 2] - px[:, 0]))
    whole = np.bincount(owner, area, len(count))
    # Middles of the sides: exact for quadratic fields.
    mx, my = (0.5 * (p + np.roll(p, -1, axis=1)) for p in (px, py))
    weight = np.repeat(area / whole[owner] / 3.0, 3)
    index = np.repeat(owner, 3), np.arange(mx.size)
    mean = csr_array((weight, index), shape=(len(count), mx.size))
    return Points(mx.ravel(), my.ravel(), mean)


def _quarter(p: Array) -> Array:
    """Cut triangles into four, (triangles, 3) to (4 triangles, 3), in order of the owners."""
    a, b, c = p.T
    ab, bc, ca = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.stack([np.stack(part, axis=1) for part in parts], axis=1).reshape(-1, 3)
