# SPDX-License-Identifier: GPL-2.0-or-later
"""Adding up extensive quantities in the cells of a grid, without loss.

Moving least squares knows what the ice is like, not how much of a cell it fills. Here every
element deals out its amounts (area, ice volume, mass) to the cells in reach, in proportion to
their hat functions times the room (area of sea) in them: nothing goes to land, and the cells' sum
is the elements' sum. Where elements fill the sea, up to a coast too, the cells come out full.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from floeflow.errors import FloeError
from floeflow.postprocess.remap.grid import Array, Grid, stencil


@dataclass(frozen=True)
class Bins:
    """Shares of the elements in the cells of a grid.

    Parameters
    ----------
    matrix : scipy.sparse.csr_array
        (ny nx, n): columns add up to 1, those of elements without a cell in reach to 0.
    grid : Grid
        The grid.
    room : ndarray
        Area of sea in each cell (m2), (ny, nx).
    """

    matrix: csr_array
    grid: Grid
    room: Array

    def total(self, amount: Array) -> Array:
        """Add up an extensive quantity of the elements, (n,), in each cell, (ny, nx)."""
        if amount.shape != (self.matrix.shape[1],):
            raise FloeError(
                f"remap: the amounts have shape {amount.shape}, the bins are for "
                f"{self.matrix.shape[1]} elements"
            )
        return np.asarray(self.matrix @ amount).reshape(self.grid.shape)

    def coverage(self, area: Array) -> Array:
        """Area dealt to each cell over its room, (ny, nx); NaN where there is no room.

        It exceeds 1 where elements overlap.
        """
        room = np.where(self.room > 0.0, self.room, 1.0)
        return np.where(self.room > 0.0, self.total(area) / room, np.nan)

    def unplaced(self, amount: Array) -> float:
        """Amount in elements that have no cell with room in reach."""
        placed = np.bincount(self.matrix.indices, minlength=self.matrix.shape[1]) > 0
        return float(amount[~placed].sum())


def build_bins(x: Array, y: Array, grid: Grid, room: Array, *, reach: int = 1) -> Bins:
    """Build the shares of elements in the cells of a grid.

    Parameters
    ----------
    x, y : ndarray
        Element centres (m), (n,).
    grid : Grid
        The grid.
    room : ndarray
        Area of sea in each cell (m2), (ny, nx); zero on land.
    reach : int
        Half-width of the hats in grid spacings.

    Raises
    ------
    FloeError
        For places or room that are not finite, negative room, or shapes that differ.
    """
    if room.shape != grid.shape:
        raise FloeError(f"remap: room has shape {room.shape}, the grid {grid.shape}")
    if not (np.isfinite(room) & (room >= 0.0)).all():
        raise FloeError("remap: room must be finite and not negative")
    pairs = stencil(x, y, grid, reach)
    share = pairs.hat * room.ravel()[pairs.node]
    dealt = np.bincount(pairs.element, share, len(x))
    used = np.flatnonzero(share > 0.0)
    node, element = pairs.node[used], pairs.element[used]
    share = share[used] / dealt[element]
    matrix = csr_array((share, (node, element)), shape=(room.size, len(x)))
    matrix.sort_indices()
    return Bins(matrix, grid, room)
