# SPDX-License-Identifier: GPL-2.0-or-later
"""The regular grid that fields go to, and the hat functions of its nodes.

A node is the centre of a cell. Its hat is bilinear and reaches ``reach`` grid spacings each way;
with reach 1 the hats are the usual bilinear functions, which add up to 1 everywhere between the
outermost nodes. A wider hat finds elements that are farther apart than the nodes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floeflow.errors import FloeError

Array = NDArray[np.float64]
Index = NDArray[np.int64]

# An element this near to the rim of a hat counts as out of reach: its share of a node is nothing,
# but alone in a hat it would still decide what the node gets.
LEAST_HAT = 1e-12


@dataclass(frozen=True)
class Grid:
    """A regular grid.

    Parameters
    ----------
    x, y : ndarray
        Nodes (cell centres) along each axis (m), ascending, evenly spaced, two or more.

    Raises
    ------
    FloeError
        For an axis that is not so.
    """

    x: Array
    y: Array

    def __post_init__(self) -> None:
        for name, axis in (("x", self.x), ("y", self.y)):
            steps = np.diff(axis)
            if axis.ndim != 1 or len(axis) < 2 or not np.isfinite(axis).all():
                raise FloeError(f"grid: axis '{name}' needs two or more finite nodes")
            if not (steps > 0).all() or np.ptp(steps) > 1e-6 * steps[0]:
                raise FloeError(f"grid: axis '{name}' must ascend in even steps")

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns, (ny, nx)."""
        return len(self.y), len(self.x)

    @property
    def spacing(self) -> tuple[float, float]:
        """Grid spacing along x and y (m)."""
        nx, ny = len(self.x) - 1, len(self.y) - 1
        return (self.x[-1] - self.x[0]) / nx, (self.y[-1] - self.y[0]) / ny


@dataclass(frozen=True)
class Stencil:
    """Pairs of a node and an element in reach of it.

    Parameters
    ----------
    node, element : ndarray of int
        Flat index of the node (row by row), index of the element.
    hat : ndarray
        The node's hat function at the element, in (0, 1].
    xi, eta : ndarray
        Element minus node, scaled by the reach of the hat, in (-1, 1).
    """

    node: Index
    element: Index
    hat: Array
    xi: Array
    eta: Array


def stencil(x: Array, y: Array, grid: Grid, reach: int = 1) -> Stencil:
    """Find the nodes in reach of each element.

    Parameters
    ----------
    x, y : ndarray
        Element centres (m), (n,); a slice of the elements will do. Those outside the grid find no
        node.
    grid : Grid
        The grid.
    reach : int
        Half-width of the hats in grid spacings.

    Raises
    ------
    FloeError
        For places that are not finite, lengths that differ, or a reach below 1.
    """
    if reach < 1:
        raise FloeError(f"remap: a reach of {reach} grid spacings finds nothing; give 1 or more")
    if x.shape != y.shape or x.ndim != 1:
        raise FloeError(f"remap: x has shape {x.shape} and y {y.shape}; both must be (n,)")
    bad = ~(np.isfinite(x) & np.isfinite(y))
    if bad.any():
        e = int(np.argmax(bad))
        raise FloeError(f"remap: element {e} lies at x = {x[e]}, y = {y[e]}")
    (ny, nx), (dx, dy) = grid.shape, grid.spacing
    column, row = (x - grid.x[0]) / dx, (y - grid.y[0]) / dy
    inside = (column > -reach) & (column < nx - 1 + reach) & (row > -reach) & (row < ny - 1 + reach)
    element = np.flatnonzero(inside)
    column, row = column[element], row[element]
    left, below = np.floor(column).astype(np.int64), np.floor(row).astype(np.int64)

    parts: list[tuple[NDArray, ...]] = []
    offsets = range(1 - reach, reach + 1)
    for j in (below + offset for offset in offsets):
        eta = (row - j) / reach
        for i in (left + offset for offset in offsets):
            xi = (column - i) / reach
            hat = (1.0 - np.abs(xi)) * (1.0 - np.abs(eta))
            near = (i >= 0) & (i < nx) & (j >= 0) & (j < ny) & (hat > LEAST_HAT)
            node = (j * nx + i)[near]
            parts.append((node, element[near], hat[near], xi[near], eta[near]))
    return Stencil(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))
