# SPDX-License-Identifier: GPL-2.0-or-later
"""Make room: cells hold no more area than they have, and none is hardly filled.

Where elements overlapped, more area arrives in a cell than it has. The excess goes to neighbours
that have room, over as many cells as it takes, and takes along what sits on it. The flux between
cells is the gradient of a potential that is above 0 only where cells are full: the divisible
sandpile (Levine & Peres 2009), whose flux is the least that does it. So nothing goes further
than it must.
"""

from __future__ import annotations

import logging
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Index = NDArray[np.int64]

Move = Callable[[Array], Array]

log = logging.getLogger(__name__)

# Excess below this share of a cell is round-off.
ROUND_OFF = 1.0e-12
# Cells filled to less than this get no element of their own, which would shorten the time step.
LEAST_FILL = 0.25
# How many cells away what they hold may find a place.
FARTHEST = 3


def attainable(area: Array, capacity: Array, beside: sparse.csr_matrix) -> Array:
    """Capacities, raised evenly where a bay or basin has less room than it must hold (m2).

    Parameters
    ----------
    area : ndarray
        That each of m cells must hold (m2), (m,).
    capacity : ndarray
        That each can hold (m2), (m,).
    beside : scipy.sparse.csr_matrix
        Which cells have a common edge, (m, m).

    Returns
    -------
    ndarray
        m2, (m,).
    """
    count, basin = connected_components(beside, directed=False)
    held = np.bincount(basin, weights=area, minlength=count)
    room = np.bincount(basin, weights=capacity, minlength=count)
    over = np.maximum(held / room * (1.0 + ROUND_OFF), 1.0)
    if over.max(initial=1.0) > 1.0 + 1e-9:
        log.warning(
            "a basin must hold %.3g times its area: its cells are overfull alike", over.max()
        )
    return np.asarray(capacity * over[basin])


def spread(area: Array, capacity: Array, beside: sparse.csr_matrix) -> Move:
    """How content goes to other cells, so that none is overfull.

    Parameters
    ----------
    area : ndarray
        What the cells hold (m2), (m,).
    capacity : ndarray
        Most that they may hold (m2), (m,).
    beside : csr_matrix
        How easily area goes between neighbours, symmetric, (m, m).

    Returns
    -------
    callable
        Gives amounts (m, ...) after from amounts before; totals stay. A cell hands on a mixture
        of what it held and what it got, so properties stay within those of the sources.
    """
    count = len(area)
    capacity = attainable(area, capacity, beside)
    full = area > capacity * (1.0 + ROUND_OFF)
    if not full.any():
        return lambda amount: amount
    laplacian = sparse.csr_matrix(sparse.diags(np.asarray(beside.sum(axis=1)).ravel()) - beside)
    potential = np.zeros(count)
    while True:
        rows = np.flatnonzero(full)
        inner = sparse.csc_matrix(laplacian[rows][:, rows])
        potential[rows] = np.maximum(splu(inner).solve((area - capacity)[rows]), 0.0)
        after = area - laplacian @ potential
        more = ~full & (after > capacity * (1.0 + ROUND_OFF))
        if not more.any() or (full | more).all():
            break
        full |= more
    return _mixing(area, potential, beside)


def _mixing(area: Array, potential: Array, beside: sparse.csr_matrix) -> Move:
    pairs = beside.tocoo()
    flux = pairs.data * (potential[pairs.row] - potential[pairs.col])
    down = flux > 0
    start, end, flux = pairs.row[down], pairs.col[down], flux[down]
    count = len(area)
    through = area + np.bincount(end, weights=flux, minlength=count)
    stays = through - np.bincount(start, weights=flux, minlength=count)
    moved = np.unique(np.concatenate([start, end]))
    # What passes through a cell is its own and what comes in, X = Q + P X, with P the share of
    # what passes through the one that goes on to the other.
    share = sparse.csr_matrix((flux / through[start], (end, start)), shape=(count, count))
    system = splu(
        sparse.identity(len(moved), format="csc") - sparse.csc_matrix(share[moved][:, moved])
    )
    left = (stays / np.where(through > 0, through, 1.0))[moved, None]

    def move(amount: Array) -> Array:
        flat = amount.reshape(count, -1).copy()
        flat[moved] = left * system.solve(flat[moved])
        return flat.reshape(amount.shape)

    return move


def join_sparse_cells(area: Array, capacity: Array, beside: sparse.csr_matrix) -> sparse.csr_matrix:
    """Join what cells hold that are hardly filled with what others hold.

    From the smallest on, what such a cell holds goes to the filled neighbour along the longest
    side. If there is none, as where a lone floe came to lie on several cells, it goes to the
    neighbour that holds most, or to whatever is within `FARTHEST` cells.

    Parameters
    ----------
    area, capacity, beside
        As for `spread`; ``beside`` the length of the sides.

    Returns
    -------
    csr_matrix
        (m, m), with which amounts are to be multiplied from the left; its columns add up to 1.
        Such a cell with nothing around it stays.
    """
    held, count = area.copy(), len(area)
    goes = np.arange(count)
    few = np.flatnonzero((area > 0) & (area < LEAST_FILL * capacity))
    for j in few[np.argsort(area[few], kind="stable")].tolist():
        if held[j] >= LEAST_FILL * capacity[j]:
            continue  # others have filled it
        k = _host(j, held, capacity, beside)
        if k != j:
            goes[j] = k
            held[k] += held[j]
            held[j] = 0.0
    while not np.array_equal(goes, goes[goes]):
        goes = goes[goes]
    ones = np.ones(count)
    return sparse.csr_matrix((ones, (goes, np.arange(count))), shape=(count, count))


def _host(j: int, held: Array, capacity: Array, beside: sparse.csr_matrix) -> int:
    """Cell that takes what cell j holds; j itself where there is none."""
    row = slice(beside.indptr[j], beside.indptr[j + 1])
    near, side = beside.indices[row], beside.data[row]
    filled = held[near] >= LEAST_FILL * capacity[near]
    if filled.any():
        near, side = near[filled], side[filled]
        return int(near[np.lexsort((near, -side))[0]])
    seen = np.array([j])
    for _ in range(FARTHEST):
        seen = np.union1d(seen, beside[seen].indices)
        others = seen[(held[seen] > 0) & (seen != j)]
        if len(others):
            return int(others[np.argmax(held[others])])
    return j


def enclosed(held: Flags, beside: sparse.csr_matrix) -> Flags:
    """Cells all of whose neighbours hold an element; a cell without neighbours is none, (m,).

    Parameters
    ----------
    held : Flags
        Cells that hold an element, (m,).
    beside : scipy.sparse.csr_matrix
        Which cells have a common edge, (m, m).

    Returns
    -------
    Flags
        (m,).
    """
    near = np.asarray((beside > 0).sum(axis=1)).ravel()
    filled = np.asarray((beside > 0) @ held.astype(float)).ravel()
    return np.asarray((near > 0) & (filled == near))
