# SPDX-License-Identifier: GPL-2.0-or-later
"""Slopes of properties from the elements around, and reductions of rows that belong together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Index = NDArray[np.int64]

# Elements whose differences make a slope, and how far from a line they must lie for one.
NEIGHBOURS = 8
ROUNDNESS = 0.02


@dataclass(frozen=True)
class Groups:
    """Sums, minima and maxima of rows that belong together.

    Parameters
    ----------
    order : ndarray
        Rows, sorted by group, (k,).
    start, group : ndarray
        Where each group that has rows begins in that order, and its number.
    count : int
        Number of groups.
    """

    order: Index
    start: Index
    group: Index
    count: int

    @classmethod
    def of(cls, index: Index, count: int) -> Groups:
        """Groups of rows by the number of each row's group.

        Parameters
        ----------
        index : Index
            Group of each row, (k,).
        count : int
            Number of groups.

        Returns
        -------
        Groups
            Rows sorted by group.
        """
        order = np.argsort(index, kind="stable")
        group, start = np.unique(index[order], return_index=True)
        return cls(order, start, group, count)

    def reduce(self, how: np.ufunc, rows: Array, empty: float) -> Array:
        """Reduce rows (k, c) to groups (count, c); groups without rows get ``empty``.

        Parameters
        ----------
        how : numpy.ufunc
            Such as ``np.add`` or ``np.minimum``.
        rows : ndarray
            (k, c).
        empty : float
            Value of groups without rows.

        Returns
        -------
        ndarray
            In the unit of the rows.
        """
        out = np.full((self.count, *rows.shape[1:]), empty)
        if len(self.start):
            out[self.group] = how.reduceat(rows[self.order], self.start, axis=0)
        return out

    def sum(self, rows: Array) -> Array:
        """Sum of each group.

        Parameters
        ----------
        rows : ndarray
            Values of the rows, (m, ...).

        Returns
        -------
        ndarray
            (groups, ...).
        """
        return self.reduce(np.add, rows, 0.0)


@dataclass(frozen=True)
class Stencil:
    """Neighbours (n, q) of elements, the way to them (m) and their weights."""

    row: Index
    dx: Array
    dy: Array
    weight: Array


def make_stencil(centre: Array) -> Stencil:
    """Neighbours of elements with these centres (m), (n, 2).

    Parameters
    ----------
    centre : ndarray
        m, (n, 2).

    Returns
    -------
    Stencil
        Rows of the neighbours, the way to them (m) and weights (1/m2), (n, k) each; k is smaller
        where there are few elements.
    """
    count = min(NEIGHBOURS + 1, len(centre))
    row = cKDTree(centre).query(centre, k=count)[1].reshape(len(centre), count)[:, 1:]
    away = centre[row] - centre[:, None, :]
    square = (away**2).sum(axis=2)
    # Twins at one place weigh no more than neighbours a tenth of the way off.
    floor = 0.01 * square.mean(axis=1, keepdims=True) if count > 1 else square
    return Stencil(row, away[..., 0], away[..., 1], 1.0 / np.maximum(square, floor))


def gradient(stencil: Stencil, ratio: Array, there: Flags) -> tuple[Array, Array]:
    """Least-squares slopes (per m) of a property in each element, (n, c); 0 where undetermined.

    Parameters
    ----------
    stencil : Stencil
        Neighbours of the n elements, with weights and offsets (m).
    ratio : ndarray
        Properties, (n, c).
    there : Flags
        Where they are defined, (n, c).

    Returns
    -------
    tuple of ndarray
        Slopes in x and in y, in the unit of the property per m.
    """
    xx, xy, yy, xr, yr = (np.zeros_like(ratio) for _ in range(5))
    for q in range(stencil.row.shape[1]):
        row = stencil.row[:, q]
        weight = stencil.weight[:, q, None] * (there & there[row])
        dx, dy = stencil.dx[:, q, None], stencil.dy[:, q, None]
        change = weight * (ratio[row] - ratio)
        xx += weight * dx * dx
        xy += weight * dx * dy
        yy += weight * dy * dy
        xr += dx * change
        yr += dy * change
    det = xx * yy - xy * xy
    good = det > ROUNDNESS * (0.5 * (xx + yy)) ** 2
    det = np.where(good, det, 1.0)
    gx = np.where(good, (xr * yy - yr * xy) / det, 0.0)
    gy = np.where(good, (yr * xx - xr * xy) / det, 0.0)
    return gx, gy
