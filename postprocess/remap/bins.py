# SPDX-License-Identifier: GPL-2.0-or-later
"""Adding up extensive quantities in the cells of a grid, without loss.

Moving least squares knows what the ice is like, not how much of a cell it fills. Here every
element deals out its amounts (area, ice volume, mass) to the cells in reach, in proportion to
their hat functions times a pull that each cell has. Shares add up to 1, so the cells' sum is the
elements' sum; land has no pull. The pulls are such that a sea full of elements fills every cell,
however its coast cuts them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from floeflow.errors import FloeError
from floeflow.postprocess.remap.grid import Array, Grid, stencil

BALANCE_ROUNDS = 200
BALANCE_TOLERANCE = 1e-3


@dataclass(frozen=True)
class Room:
    """The sea in the cells of a grid.

    Parameters
    ----------
    grid : Grid
        The grid.
    area : ndarray
        Area of sea in each cell (m2), (ny, nx).
    pull : ndarray
        Weight of each cell when elements deal out their amounts (m2), (ny, nx): its area where
        all is sea around it, zero on land.
    reach : int
        Half-width of the hats in grid spacings.
    """

    grid: Grid
    area: Array
    pull: Array
    reach: int


@dataclass(frozen=True)
class Bins:
    """Shares of the elements in the cells of a grid.

    Parameters
    ----------
    matrix : scipy.sparse.csr_array
        (ny nx, n): columns add up to 1, those of elements without sea in reach to 0.
    room : Room
        The sea.
    """

    matrix: csr_array
    room: Room

    def total(self, amount: Array) -> Array:
        """Add up an extensive quantity of the elements, (n,), in each cell, (ny, nx)."""
        if amount.shape != (self.matrix.shape[1],):
            raise FloeError(
                f"remap: the amounts have shape {amount.shape}, the bins are for "
                f"{self.matrix.shape[1]} elements"
            )
        return np.asarray(self.matrix @ amount).reshape(self.room.grid.shape)

    def coverage(self, area: Array) -> Array:
        """Area dealt to each cell over its sea, (ny, nx); NaN on land.

        It exceeds 1 where elements overlap.
        """
        sea = self.room.area > 0.0
        dealt = self.total(area) / np.where(sea, self.room.area, 1.0)
        return np.where(sea, dealt, np.nan)

    def unplaced(self, amount: Array) -> float:
        """Amount in elements that have no sea in reach."""
        placed = np.bincount(self.matrix.indices, minlength=self.matrix.shape[1]) > 0
        return float(amount[~placed].sum())


def build_room(x: Array, y: Array, area: Array, grid: Grid, *, reach: int = 1) -> Room:
    """Find how much sea the cells hold and how strongly each must pull.

    The pulls are found by balancing (Sinkhorn and Knopp 1967): pieces that fill the sea deal out
    their areas, every cell's pull is divided by its coverage, and so on until the coverage is 1
    to a thousandth, or for `BALANCE_ROUNDS` rounds.

    Parameters
    ----------
    x, y : ndarray
        Centres of pieces that together are the sea (m), (m,): sea cells of a grid finer than
        this one.
    area : ndarray
        Their areas (m2), (m,).
    grid : Grid
        The grid.
    reach : int
        Half-width of the hats in grid spacings.

    Raises
    ------
    FloeError
        For pieces outside the grid, or areas that are not finite or negative.
    """
    if area.shape != x.shape or not (np.isfinite(area) & (area >= 0.0)).all():
        raise FloeError("remap: the sea's pieces need one finite area each, not negative")
    pairs = stencil(x, y, grid, reach)
    (ny, nx), (dx, dy) = grid.shape, grid.spacing
    column = np.floor((x - grid.x[0]) / dx + 0.5).astype(np.int64)
    row = np.floor((y - grid.y[0]) / dy + 0.5).astype(np.int64)
    if len(x) and not (min(row.min(), column.min()) >= 0 and row.max() < ny and column.max() < nx):
        raise FloeError("remap: some of the sea's pieces lie outside the grid")
    sea: Array = np.bincount(row * nx + column, area, ny * nx).astype(np.float64)
    hats = csr_array((pairs.hat, (pairs.node, pairs.element)), shape=(ny * nx, len(x)))
    holds = sea > 0.0
    pull: Array = sea.copy()
    for _ in range(BALANCE_ROUNDS):
        dealt = pull * (hats @ (area / np.where(area > 0.0, hats.T @ pull, 1.0)))
        coverage = np.where(holds, dealt / np.where(holds, sea, 1.0), 1.0)
        if np.abs(coverage - 1.0).max() < BALANCE_TOLERANCE:
            break
        pull = pull / coverage
    return Room(grid, sea.reshape(grid.shape), pull.reshape(grid.shape), reach)


def build_bins(x: Array, y: Array, room: Room) -> Bins:
    """Build the shares of elements in the cells of a grid.

    Parameters
    ----------
    x, y : ndarray
        Element centres (m), (n,).
    room : Room
        The sea in the cells.

    Raises
    ------
    FloeError
        For places that are not finite.
    """
    pairs = stencil(x, y, room.grid, room.reach)
    share = pairs.hat * room.pull.ravel()[pairs.node]
    dealt = np.bincount(pairs.element, share, len(x))
    used = np.flatnonzero(share > 0.0)
    node, element = pairs.node[used], pairs.element[used]
    share = share[used] / dealt[element]
    matrix = csr_array((share, (node, element)), shape=(room.pull.size, len(x)))
    matrix.sort_indices()
    return Bins(matrix, room)
