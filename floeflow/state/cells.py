# SPDX-License-Identifier: GPL-2.0-or-later
"""Fresh cells: the tessellation of the sea into which distorted elements are remapped."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
import xarray as xr
from numpy.typing import NDArray
from scipy import sparse

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True)
class Cells:
    """Cells that tile the sea, sorted by id.

    Parameters
    ----------
    id : ndarray
        Ids of the elements that live in them, (m,).
    x, y, radius : ndarray
        Discs inside of the cells (m), (m,); no two overlap.
    area : ndarray
        Sea area on the earth (m2), (m,).
    polygons : ndarray of shapely.Polygon
        Outlines on the map, (m,).
    lo, hi : ndarray
        Rows of cells that share a side, lo < hi, (k,).
    ends : ndarray
        Ends of the shared sides (m), (k, 2, 2).
    """

    id: Index
    x: Array
    y: Array
    radius: Array
    area: Array
    polygons: NDArray[np.object_]
    lo: Index
    hi: Index
    ends: Array

    @property
    def scale(self) -> Array:
        """Area on the earth over area on the map, (m,)."""
        return np.asarray(self.area / shapely.area(self.polygons))

    def neighbours(self) -> sparse.csr_matrix:
        """Length of the side (m) that two cells share, symmetric, (m, m)."""
        return self._symmetric(np.hypot(*(self.ends[:, 1] - self.ends[:, 0]).T))

    def ease(self) -> sparse.csr_matrix:
        """How easily area goes between neighbours: that length over their distance, (m, m)."""
        length = np.hypot(*(self.ends[:, 1] - self.ends[:, 0]).T)
        dx, dy = self.x[self.hi] - self.x[self.lo], self.y[self.hi] - self.y[self.lo]
        return self._symmetric(length / np.hypot(dx, dy))

    def _symmetric(self, values: Array) -> sparse.csr_matrix:
        count = len(self.id)
        half = sparse.coo_matrix((values, (self.lo, self.hi)), shape=(count, count))
        return sparse.csr_matrix(half + half.T)


def read_cells(data: xr.Dataset) -> Cells:
    """Cells from the dataset that `floeflow.packings.fresh_cells` wrote.

    Parameters
    ----------
    data : xarray.Dataset
        Cells of a packing.

    Returns
    -------
    Cells
        Outlines, areas (m2), neighbours and common sides (m) of the cells.
    """
    start, ring = data["cell_start"].values, np.stack([data["cell_x"], data["cell_y"]], axis=1)
    return Cells(
        **{name: data[name].values for name in ("id", "x", "y", "radius", "area")},
        polygons=polygons_of(start, ring),
        lo=data["edge_lo"].values,
        hi=data["edge_hi"].values,
        ends=np.stack(
            [np.stack([data[f"edge_{e}x"], data[f"edge_{e}y"]], axis=1) for e in "ab"], axis=1
        ),
    )


def polygons_of(start: Index, ring: Array) -> NDArray[np.object_]:
    """Anticlockwise polygons from open rings: starts (n + 1,), three corners or more (c, 2).

    Parameters
    ----------
    start : Index
        First corner of each ring, (n + 1,).
    ring : ndarray
        Corners (m), (c, 2).

    Returns
    -------
    ndarray
        (n,).
    """
    of = np.repeat(np.arange(len(start) - 1), np.diff(start))
    if not len(of):
        return np.empty(0, dtype=object)
    return np.asarray(
        shapely.orient_polygons(shapely.polygons(shapely.linearrings(ring, indices=of)))
    )


def rings_of(polygons: NDArray[np.object_]) -> tuple[Index, Array]:
    """Open rings of polygons without holes: starts (n + 1,) and corners (c, 2).

    Parameters
    ----------
    polygons : ndarray
        Of shapely, (n,).

    Returns
    -------
    start, corner : ndarray
        Row of each ring's first corner, (n + 1,), and x and y (m), (c, 2); the first corner is not
        repeated.
    """
    xy, of = shapely.get_coordinates(polygons, return_index=True)
    last = np.append(of[1:] != of[:-1], True) if len(of) else np.zeros(0, dtype=bool)
    start = np.searchsorted(of[~last], np.arange(len(polygons) + 1))
    return start.astype(np.int64), xy[~last]
