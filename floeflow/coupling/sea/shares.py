# SPDX-License-Identifier: GPL-2.0-or-later
"""Which part of the sea each element stands on.

An element deals out its area to the cells of the grid by hat functions of about its own width.
Cells pull as strongly as it takes for a sea full of ice to fill each of them, also along coasts,
and less where more area is dealt to them than they hold, so that a packed sea leaves no water
between that is not there. What an element
reads is the mean of the sea by these shares; what it gives back goes to the same cells in the same
shares (the adjoint), so that nothing is lost on the way.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array, vstack
from scipy.spatial import cKDTree

from floeflow.transfer import Grid
from floeflow.transfer.weights import sparse

Array = NDArray[np.float64]

# Rounds in which full cells push area to their neighbours. What is left over in a cell then is
# area of elements that overlap.
ROUNDS = 60
# Rounds in which the pull of cells is balanced, at most, and the share of the sea that may be in
# the wrong cell then.
MOST_ROUNDS, ERROR = 300, 1e-4


@dataclass(frozen=True)
class Shares:
    """Shares of the cells in the elements' areas.

    Parameters
    ----------
    matrix : scipy.sparse.csr_array
        (n, cells): rows add up to 1.
    sea : ndarray
        Area of sea in the cells (m2), (cells,).
    claimed : ndarray
        Area of the elements in the cells (m2), (cells,).
    """

    matrix: csr_array
    sea: Array
    claimed: Array

    @property
    def open_area(self) -> Array:
        """Sea that no element stands for (m2), (cells,)."""
        return np.maximum(self.sea - self.claimed, 0.0)

    def read(self, field: Array) -> Array:
        """Mean of a field of the sea below the elements, (n,).

        Parameters
        ----------
        field : ndarray
            (cells,), in any unit.

        Returns
        -------
        ndarray
            In the field's unit, (n,).
        """
        return np.asarray(self.matrix @ field)

    def read_stock(self, stock: Array) -> Array:
        """Mean of what there is of something (per m2 of sea), (n,).

        Where elements overlap, more area is dealt to a cell than it has sea: they share its stock,
        so that together they never see more than there is.

        Parameters
        ----------
        stock : ndarray
            Per m2 of sea, (cells,).

        Returns
        -------
        ndarray
            In the stock's unit, per m2 of the element's area, (n,).
        """
        crowded = np.maximum(self.claimed, self.sea)
        part = np.divide(self.sea, crowded, out=np.ones_like(crowded), where=crowded > 0.0)
        return np.asarray(self.matrix @ (stock * part))

    def give(self, amount: Array) -> Array:
        """Amounts of the elements, (n,), in the cells, (cells,); their sums are the same.

        Parameters
        ----------
        amount : ndarray
            (n,), in any unit.

        Returns
        -------
        ndarray
            In the unit of the amounts, (cells,).
        """
        return np.asarray(self.matrix.T @ amount)


def balanced_pull(x: Array, y: Array, area: Array, grid: Grid) -> Array:
    """Pull of the cells with which ice that covers all sea fills each of them, (cells,).

    A hat at the coast reaches over land, and a bay is reached from the sea beside it: with pulls in
    proportion to the sea the ice of a full basin would leave its bays open, and be crowded
    elsewhere. Rows and columns are scaled in turn (Sinkhorn and Knopp 1967).

    Parameters
    ----------
    x, y, area : ndarray
        Centres (m) and areas (m2) of pieces that make up the sea, smaller than a cell, (m,).
    grid : Grid
        The scene's grid.

    Returns
    -------
    ndarray
        1, (cells,); 0 in cells without sea.
    """
    sea = np.bincount(grid.cell_of(x, y), area, grid.shape[0] * grid.shape[1]).astype(np.float64)
    if not len(x):
        return sea
    hats = _hats(x, y, np.zeros(len(x)), grid)
    across = csr_array(hats.T)
    pull = sea / sea.max()
    for _ in range(MOST_ROUNDS):
        dealt = pull * (across @ (area / (hats @ pull)))
        if np.abs(dealt - sea).sum() <= 2.0 * ERROR * sea.sum():
            break
        pull = np.divide(pull * sea, dealt, out=np.zeros_like(pull), where=dealt > 0.0)
    return pull


def build_shares(
    x: Array, y: Array, area: Array, grid: Grid, sea: Array, pull: Array | None = None
) -> Shares:
    """Deal out the elements' areas to the cells of a grid.

    Parameters
    ----------
    x, y, area : ndarray
        Centres (m) and effective areas (m2) of the elements, (n,). One that stands on no cell with
        sea is given to the nearest that has some.
    grid : Grid
        The scene's grid.
    sea : ndarray
        Area of sea in its cells (m2), (ny, nx); some of it above zero.
    pull : ndarray, optional
        Of the cells, (cells,), as of `balanced_pull`; otherwise in proportion to their sea.

    Returns
    -------
    Shares
        Matrix (n, cells) whose rows add up to 1, area of sea and area that the elements claim in
        each cell (m2).
    """
    water = sea.ravel()
    if not len(x):
        none = csr_array((0, water.size))
        return Shares(none, water, np.zeros(water.size))
    hats = _hats(x, y, area, grid)
    pull = water / water.max() if pull is None else pull
    afloat = hats @ pull > 0.0
    fixed = _nearest(x, y, afloat, grid, water)
    across = csr_array(hats.T)
    kept = csr_array(fixed.T) @ area
    for _ in range(ROUNDS):
        whole = hats @ pull
        dealt = pull * (across @ np.divide(area, whole, out=np.zeros_like(area), where=afloat))
        full = np.divide(dealt + kept, water, out=np.ones_like(dealt), where=water > 0.0)
        if full.max(initial=0.0) <= 1.0 + 1e-6:
            break
        pull = pull / np.maximum(full, 1.0)
    whole = hats @ pull
    per = np.divide(1.0, whole, out=np.zeros_like(whole), where=afloat)
    matrix = csr_array(diags_array(per) @ hats @ diags_array(pull) + fixed)
    matrix.sort_indices()
    return Shares(matrix, water, np.asarray(matrix.T @ area))


def _hats(x: Array, y: Array, area: Array, grid: Grid) -> csr_array:
    """Hat functions at the elements, each about as wide as its element, (n, cells)."""
    # The nodes are centres of cells: within half a cell of the rim its values hold.
    inner_x = np.clip(x, grid.x[0], grid.x[-1])
    inner_y = np.clip(y, grid.y[0], grid.y[-1])
    width = np.maximum(np.round(np.sqrt(area) / min(grid.spacing)), 1).astype(np.int64)
    parts, rows = [], []
    for reach in np.unique(width).tolist():
        mine = np.flatnonzero(width == reach)
        pairs = grid.pairs(inner_x[mine], inner_y[mine], reach)
        parts.append(csr_array(sparse(pairs.start, pairs.element, pairs.hat, len(mine)).T))
        rows.append(mine)
    order = np.argsort(np.concatenate(rows))
    return csr_array(csr_array(vstack(parts))[order])


def _nearest(x: Array, y: Array, afloat: NDArray[np.bool_], grid: Grid, water: Array) -> csr_array:
    """Whole shares of the nearest cells with sea for elements that find none, (n, cells)."""
    lost, known = np.flatnonzero(~afloat), np.flatnonzero(water > 0.0)
    cells = known[:0]
    if len(lost):
        places = np.stack(grid.places(), axis=1)[known]
        cells = known[cKDTree(places).query(np.stack([x[lost], y[lost]], axis=1))[1]]
    return csr_array((np.ones(len(lost)), (lost, cells)), shape=(len(x), water.size))
