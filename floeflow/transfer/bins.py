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
from numpy.typing import NDArray
from scipy.sparse import csr_array

from floeflow.core.errors import FloeError
from floeflow.transfer.bounded import Ranks
from floeflow.transfer.grid import Grid
from floeflow.transfer.mesh import Mesh
from floeflow.transfer.stencil import Array, Stencil, Target
from floeflow.transfer.weights import select_pairs, sparse

BALANCE_ROUNDS = 200
BALANCE_TOLERANCE = 1e-3


@dataclass(frozen=True)
class Room:
    """The sea in the cells of a grid or mesh.

    Parameters
    ----------
    target : Target
        The grid or mesh.
    area : ndarray
        Area of sea in each cell (m2), (target.shape).
    pull : ndarray
        Weight of each cell when elements deal out their amounts (m2), (target.shape): its area
        where all is sea around it, zero on land.
    reach : int
        Half-width of the hats in grid spacings.
    """

    target: Target
    area: Array
    pull: Array
    reach: int


@dataclass(frozen=True)
class Bins:
    """Shares of the elements in the cells of a grid.

    Parameters
    ----------
    matrix : scipy.sparse.csr_array
        (nodes, n): columns add up to 1, those of elements outside of the grid, or without sea in
        reach, to 0.
    room : Room
        The sea.
    """

    matrix: csr_array
    room: Room

    def total(self, amount: Array, ranks: Ranks | None = None) -> Array:
        """Add up an extensive quantity of the elements, (n,), in each cell, (target.shape).

        Parameters
        ----------
        amount : ndarray
            Of each element, (n,).
        ranks : Ranks, optional
            Sums over all ranks, each of which has elements of its own.

        Returns
        -------
        ndarray
            In the unit of the amount, (target.shape).

        Raises
        ------
        FloeError
            For a wrong shape, or an amount that is not finite.
        """
        n = self.matrix.shape[1]
        if amount.shape != (n,):
            raise FloeError(
                f"remap: the amounts have shape {amount.shape}, the bins are for {n} elements"
            )
        if not np.isfinite(amount).all():
            e = int(np.argmin(np.isfinite(amount)))
            raise FloeError(f"remap: the amount of element {e} is {amount[e]}")
        sums = np.asarray(self.matrix @ amount)
        return (ranks.add(sums) if ranks else sums).reshape(self.room.area.shape)

    def coverage(self, area: Array, ranks: Ranks | None = None) -> Array:
        """Area dealt to each cell over its sea, (target.shape); NaN on land.

        It exceeds 1 where elements overlap.

        Parameters
        ----------
        area : ndarray
            Of each element (m2), (n,).
        ranks : Ranks, optional
            Sums over all ranks.

        Returns
        -------
        ndarray
            m2/m2.

        Raises
        ------
        FloeError
            For a wrong shape, or an area that is not finite.
        """
        sea = self.room.area > 0.0
        dealt = self.total(area, ranks) / np.where(sea, self.room.area, 1.0)
        return np.where(sea, dealt, np.nan)

    def placed(self) -> NDArray[np.bool_]:
        """Whether an element has a cell, (n,)."""
        return np.bincount(self.matrix.indices, minlength=self.matrix.shape[1]) > 0

    def unplaced(self, amount: Array) -> float:
        """Amount in elements that lie outside of the grid or have no sea in reach.

        Parameters
        ----------
        amount : ndarray
            Of each element, (n,), in any unit.

        Returns
        -------
        float
            In the unit of the amounts; 0 where all are placed.
        """
        return float(amount[~self.placed()].sum())


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

    Returns
    -------
    Room
        Area of sea (m2) and pull (1) of each cell, of the grid's shape.

    Raises
    ------
    FloeError
        For pieces outside the grid, or areas that are not finite or negative.
    """
    if area.shape != x.shape or not (np.isfinite(area) & (area >= 0.0)).all():
        raise FloeError("remap: the sea's pieces need one finite area each, not negative")
    pairs = grid.pairs(x, y, reach)
    nodes = grid.shape[0] * grid.shape[1]
    cell = grid.cell_of(x, y)
    if (cell < 0).any():
        raise FloeError("remap: some of the sea's pieces lie outside the grid")
    sea: Array = np.bincount(cell, area, nodes).astype(np.float64)
    hats = sparse(pairs.start, pairs.element, pairs.hat, len(x))
    across = csr_array(hats.T)
    holds = sea > 0.0
    pull: Array = sea.copy()
    for _ in range(BALANCE_ROUNDS):
        dealt = pull * (hats @ (area / np.where(area > 0.0, across @ pull, 1.0)))
        coverage = np.where(holds, dealt / np.where(holds, sea, 1.0), 1.0)
        if np.abs(coverage - 1.0).max() < BALANCE_TOLERANCE:
            break
        pull = pull / coverage
    return Room(grid, sea.reshape(grid.shape), pull.reshape(grid.shape), reach)


def open_room(target: Target, area: Array | None = None, *, reach: int = 1) -> Room:
    """Room of a grid or mesh that is all sea, or has a given area of sea in each cell.

    Parameters
    ----------
    target : Target
        The grid or mesh.
    area : ndarray, optional
        Area of sea that each node stands for (m2), (target.shape); zero on land. Without it all
        is sea.
    reach : int
        Half-width of the hats in grid spacings.

    Returns
    -------
    Room
        Area of sea (m2) of each cell, and a pull of 1 where it has any.

    Raises
    ------
    FloeError
        For a target whose cells have no known area, and for areas of another shape, negative or
        not finite.
    """
    if area is None:
        if isinstance(target, Mesh):
            area = target.area.reshape(target.shape)
        elif isinstance(target, Grid):
            area = np.full(target.shape, target.spacing[0] * target.spacing[1])
        else:
            raise FloeError("remap: the target's cells have no known area; give them")
    if area.shape != target.shape or not (np.isfinite(area) & (area >= 0.0)).all():
        raise FloeError(f"remap: 'area' of the sea must be {target.shape}, finite, not negative")
    return Room(target, area, (area > 0.0).astype(np.float64), reach)


def build_bins(
    x: Array, y: Array, room: Room, radius: Array | None = None, pairs: Stencil | None = None
) -> Bins:
    """Build the shares of elements in the cells of a grid.

    Parameters
    ----------
    x, y : ndarray
        Element centres (m), (n,).
    room : Room
        The sea in the cells.
    radius : ndarray, optional
        Radii of the elements (m), (n,); points without it. An element whose disc no longer touches
        the grid's cells has left the grid and gets no share.
    pairs : Stencil, optional
        ``room.target.pairs(x, y, room.reach)``, where it is known already.

    Returns
    -------
    Bins
        Matrix (cells, n) of shares (1), whose columns add up to 1 for elements that are placed.

    Raises
    ------
    FloeError
        For places that are not finite.
    """
    pairs = pairs or room.target.pairs(x, y, room.reach)
    share = pairs.hat * np.repeat(room.pull.ravel(), np.diff(pairs.start))
    if isinstance(room.target, Grid):
        radius = np.zeros_like(x) if radius is None else radius
        share = np.where(room.target.touches(x, y, radius)[pairs.element], share, 0.0)
    whole = np.bincount(pairs.element, share, len(x))
    share = share / np.where(whole > 0.0, whole, 1.0)[pairs.element]
    used = share > 0.0
    kept = select_pairs(pairs, used)
    return Bins(sparse(kept.start, kept.element, share[used], len(x)), room)
