# SPDX-License-Identifier: GPL-2.0-or-later
"""Area means of a file's cells in the cells of a grid, where the file is the finer one.

A sample at a cell's centre would see one of many source cells. Each source cell is drawn on the
map as the quadrilateral of its corners and cut by the grid's squares; the shared areas are the
weights. Folds and seams of curvilinear grids need no care: a cell is a polygon like any other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pyproj
from numpy.typing import NDArray
from scipy import sparse

from floeflow.core.clip import shared
from floeflow.core.fields import AnySource, Curvilinear, shape_of
from floeflow.core.grids import Grid, from_lonlat, metres_per_unit
from floeflow.core.interpolate import Transfer, triangle_weights, weights

Array = NDArray[np.float64]
Index = NDArray[np.int64]

# A cell is covered by the source from this share of its area on.
LEAST_COVERED = 0.5
# A source cell wider than so many of the typical one is none of the map's: it lies around the
# point opposite to its centre.
WIDEST = 8.0


@dataclass(frozen=True)
class AreaMeans:
    """Weights by shared area, (points, source cells), rows adding up to 1."""

    matrix: sparse.csr_matrix
    inside: NDArray[np.bool_]

    def of(self, values: Array) -> Array:
        """Values in the cells: (..., ny, nx), unpadded, to (..., points).

        Parameters
        ----------
        values : ndarray
            Of the source's grid, in any unit.

        Returns
        -------
        ndarray
            In the unit of the values, (..., points).
        """
        flat = values.reshape(-1, self.matrix.shape[1])
        means = np.asarray((self.matrix @ flat.T).T)
        return means.reshape(*values.shape[:-2], self.matrix.shape[0])


def transfer(
    source: AnySource, grid: Grid, plane: pyproj.CRS, lon: Array, lat: Array, finer: float = 1.0
) -> Transfer:
    """Area means where the source is finer than the grid, else bilinear weights.

    Parameters
    ----------
    source : Source or Curvilinear
        The file's grid.
    grid : Grid
        Where values are wanted.
    plane : pyproj.CRS
        Its projection.
    lon, lat : ndarray
        Its places (degrees), (ny, nx).
    finer : float
        Area means from so many source cells on to a side of a cell.

    Returns
    -------
    Transfer
        From the source's values to the places, in their order.
    """
    corners = corners_on(source, plane)
    size = typical_size(corners, grid)
    if size is not None and size * finer < 0.99 * grid.spacing:
        return area_means(source, grid, corners, size)
    if isinstance(source, Curvilinear):
        return triangle_weights(source, plane, lon, lat)
    return weights(source, lon, lat)


def corners_on(source: AnySource, plane: pyproj.CRS) -> tuple[Array, Array]:
    """Corners of a source's cells on a map (m), x and y, each (ny + 1, nx + 1).

    Parameters
    ----------
    source : AnySource
        Grid of a file.
    plane : pyproj.CRS
        Projection.

    Returns
    -------
    tuple of ndarray
        NaN where a corner has no place on the map.
    """
    if isinstance(source, Curvilinear):
        x, y = from_lonlat(plane, source.lon, source.lat)
        return _between(x), _between(y)
    edges = _edges(source.x), _edges(source.y)
    if source.crs is not None:
        x, y = np.meshgrid(*edges)
        if source.crs == plane:
            return x, y
        turned = pyproj.Transformer.from_crs(source.crs, plane, always_xy=True)
        unit = metres_per_unit(source.crs)
        px, py = turned.transform(x / unit, y / unit)
        return np.asarray(px, float), np.asarray(py, float)
    lon, lat = np.meshgrid(edges[0], np.clip(edges[1], -90.0, 90.0))
    return from_lonlat(plane, lon, lat)


def _edges(axis: Array) -> Array:
    middle = 0.5 * (axis[1:] + axis[:-1])
    return np.concatenate(
        [[1.5 * axis[0] - 0.5 * axis[1]], middle, [1.5 * axis[-1] - 0.5 * axis[-2]]]
    )


def _between(values: Array) -> Array:
    """Means of four neighbours, the rim beyond the last ones extrapolated."""
    wide = np.pad(values, 1, mode="reflect", reflect_type="odd")
    return 0.25 * (wide[1:, 1:] + wide[1:, :-1] + wide[:-1, 1:] + wide[:-1, :-1])


def typical_size(corners: tuple[Array, Array], grid: Grid) -> float | None:
    """Median of the longer sides of the source cells that meet the grid (m), None without any.

    Parameters
    ----------
    corners : tuple of ndarray
        x and y (m), (ny + 1, nx + 1) each.
    grid : Grid
        Cells.

    Returns
    -------
    float or None
        m.
    """
    ring = _rings(corners)
    near = _near(ring, grid)
    if not near.any():
        return None
    here = ring[near]
    sides = np.hypot(*np.moveaxis(here - np.roll(here, -1, axis=1), -1, 0))
    return float(np.median(sides.max(axis=1)))


def _rings(corners: tuple[Array, Array]) -> Array:
    """Corners of each cell, (cells, 4, 2)."""
    x, y = corners
    parts = [
        np.stack([part[rows, columns].ravel() for part in (x, y)], axis=-1)
        for rows, columns in (
            (slice(None, -1), slice(None, -1)),
            (slice(None, -1), slice(1, None)),
            (slice(1, None), slice(1, None)),
            (slice(1, None), slice(None, -1)),
        )
    ]
    return np.stack(parts, axis=1)


def _near(ring: Array, grid: Grid) -> NDArray[np.bool_]:
    low, high = ring.min(axis=1), ring.max(axis=1)
    x, y = grid.x_edges, grid.y_edges
    with np.errstate(invalid="ignore"):
        meets = (high[:, 0] > x[0]) & (low[:, 0] < x[-1]) & (high[:, 1] > y[0])
        return np.asarray(meets & (low[:, 1] < y[-1]))


def area_means(
    source: AnySource, grid: Grid, corners: tuple[Array, Array], size: float
) -> AreaMeans:
    """Weights by the area that source cells share with the cells of a grid.

    Parameters
    ----------
    source : AnySource
        Grid of a file.
    grid : Grid
        Cells.
    corners : tuple of ndarray
        x and y (m), (ny + 1, nx + 1) each.
    size : float
        Typical size of the source's cells (m).

    Returns
    -------
    AreaMeans
        Weights of the source's cells for each cell of the grid.
    """
    ring = _rings(corners)
    with np.errstate(invalid="ignore"):
        wide = (ring.max(axis=1) - ring.min(axis=1)).max(axis=1) > WIDEST * max(size, grid.spacing)
        kept = np.flatnonzero(_near(ring, grid) & ~wide)
    ring = ring[kept]
    first, last = (
        np.stack(grid.cell_of(part[:, 0], part[:, 1])[::-1], axis=1)
        for part in (ring.min(axis=1), ring.max(axis=1))
    )
    across, along = (last - first + 1).T
    count = across * along
    cell = np.repeat(np.arange(len(kept)), count)
    step = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    column = first[cell, 0] + step % across[cell]
    row = first[cell, 1] + step // across[cell]
    area = _shared(ring, cell, grid, row, column)
    ny, nx = grid.shape
    rows, columns = shape_of(source)
    matrix = sparse.csr_matrix(
        (area, (row * nx + column, kept[cell])), shape=(ny * nx, rows * columns)
    )
    matrix.eliminate_zeros()
    total = np.asarray(matrix.sum(axis=1)).ravel()
    inside = total >= LEAST_COVERED * grid.spacing**2
    scale = sparse.diags(np.divide(1.0, total, out=np.zeros_like(total), where=total > 0))
    return AreaMeans((scale @ matrix).tocsr(), inside)


def _shared(ring: Array, cell: Index, grid: Grid, row: Index, column: Index) -> Array:
    """Area (m2) that pairs of a quadrilateral and a square of the grid share, (pairs,)."""
    nxt = np.roll(ring, -1, axis=1)
    twice = (ring[..., 0] * nxt[..., 1] - nxt[..., 0] * ring[..., 1]).sum(axis=1)
    ring = np.where((twice < 0)[:, None, None], ring[:, ::-1], ring)
    low = np.stack([grid.x_edges[column], grid.y_edges[row]], axis=1)
    unit = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]) * grid.spacing
    squares = (low[:, None] + unit).reshape(-1, 2)
    area, _ = shared(
        4 * np.arange(len(ring) + 1),
        np.ascontiguousarray(ring.reshape(-1, 2)),
        4 * np.arange(len(cell) + 1),
        squares,
        cell,
        np.arange(len(cell)),
    )
    return area
