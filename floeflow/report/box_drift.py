# SPDX-License-Identifier: GPL-2.0-or-later
"""Mean drift of boxes of cells, for arrows on maps of many cells."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Along the longer side of a map.
ARROWS = 16


@dataclass(frozen=True)
class BoxDrift:
    """Mean drift of boxes of cells.

    Parameters
    ----------
    u, v : ndarray
        Along x and y (m/s), 0 without ice, (time, row, column) from the top down.
    cells : int
        Cells along a side of a box.
    shape : tuple of int
        Rows and columns of the grid; the boxes begin at its lower left corner.
    """

    u: Array
    v: Array
    cells: int
    shape: tuple[int, int]

    @property
    def top(self) -> float:
        """Speed that hardly any exceeds (m/s)."""
        speed = np.hypot(self.u, self.v)
        return float(np.quantile(speed[speed > 0], 0.98)) if speed.any() else 1.0

    @property
    def above(self) -> int:
        """Rows of cells by which the boxes stand over the grid's upper edge."""
        return int(self.u.shape[1]) * self.cells - self.shape[0]

    def places(self, extent: tuple[float, float, float, float]) -> tuple[Array, Array]:
        """Columns and rows of the boxes' centres on a map from left, right, bottom to top.

        Parameters
        ----------
        extent : tuple of float
            Left, right, bottom, top of the map.

        Returns
        -------
        x, y : ndarray
            In the unit of the extent, (columns,) and (rows,).
        """
        left, right, bottom, top = extent
        wide = self.cells * (right - left) / self.shape[1]
        high = self.cells * (top - bottom) / self.shape[0]
        _, rows, columns = self.u.shape
        across, up = np.arange(columns) + 0.5, rows - 0.5 - np.arange(rows)
        return np.asarray(left + wide * across), np.asarray(bottom + high * up)

    def at(self, time: int) -> tuple[Array, Array]:
        """Drift at a time, NaN without ice, each (row, column).

        Parameters
        ----------
        time : int
            Index of the time.

        Returns
        -------
        u, v : ndarray
            m/s along the map's axes, (row, column) each.
        """
        still = (self.u[time] == 0.0) & (self.v[time] == 0.0)
        return np.where(still, np.nan, self.u[time]), np.where(still, np.nan, self.v[time])


def box_drift(grid: xr.Dataset) -> BoxDrift | None:
    """Drift of boxes of cells at all times, weighted by concentration; None without drift.

    Parameters
    ----------
    grid : xarray.Dataset
        On ``time``, ``y`` and ``x``.

    Returns
    -------
    BoxDrift or None
        m/s, (time, row, column), rows from the top of the map down.
    """
    if "siu" not in grid or "siv" not in grid:
        return None
    times, ny, nx = grid["siu"].shape
    size = max(1, int(np.ceil(max(ny, nx) / ARROWS)))
    rows, columns = -(-ny // size), -(-nx // size)
    boxes = []
    weight = np.nan_to_num(np.asarray(grid["siconc"].values, dtype=float))
    for name in ("siu", "siv"):
        values = np.nan_to_num(np.asarray(grid[name].values, dtype=float)) * weight
        sums = (np.zeros((times, rows * size, columns * size)) for _ in range(2))
        parts = []
        for whole, source in zip(sums, (values, weight), strict=True):
            whole[:, -ny:, :nx] = source[:, ::-1]
            parts.append(whole.reshape(times, rows, size, columns, size).sum(axis=(2, 4)))
        boxes.append(np.divide(parts[0], parts[1], out=np.zeros_like(parts[0]), where=parts[1] > 0))
    return BoxDrift(boxes[0], boxes[1], size, (ny, nx))
