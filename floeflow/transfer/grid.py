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

from floeflow.core.errors import FloeError
from floeflow.transfer.stencil import (
    Array,
    Index,
    Stencil,
    check_places,
    lattice_pairs,
    sort_by_cell,
)


@dataclass(frozen=True)
class Grid:
    """A regular grid.

    Parameters
    ----------
    x, y : ndarray
        Nodes (cell centres) along each axis (m), ascending, evenly spaced, two or more.
    crs : str
        Projection of the axes; empty where not said.

    Raises
    ------
    FloeError
        For an axis that is not so.
    """

    x: Array
    y: Array
    crs: str = ""

    def __post_init__(self) -> None:
        for name, axis in (("x", self.x), ("y", self.y)):
            steps = np.diff(axis)
            if axis.ndim != 1 or len(axis) < 2 or not np.isfinite(axis).all():
                raise FloeError(f"grid: axis '{name}' needs two or more finite nodes")
            if not (steps > 0).all() or np.ptp(steps) > 1e-6 * steps[0]:
                k = int(np.argmax((steps <= 0) | (np.abs(steps - steps[0]) > 1e-6 * steps[0])))
                raise FloeError(
                    f"grid: axis '{name}' must ascend in even steps, but goes from "
                    f"{axis[k]:g} to {axis[k + 1]:g} at node {k + 1}"
                )

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns, (ny, nx)."""
        return len(self.y), len(self.x)

    @property
    def spacing(self) -> tuple[float, float]:
        """Grid spacing along x and y (m)."""
        nx, ny = len(self.x) - 1, len(self.y) - 1
        return (self.x[-1] - self.x[0]) / nx, (self.y[-1] - self.y[0]) / ny

    def places(self) -> tuple[Array, Array]:
        """Nodes, x and y (m), (nodes,) each."""
        x, y = np.meshgrid(self.x, self.y)
        return x.ravel(), y.ravel()

    def cell_of(self, x: Array, y: Array) -> Index:
        """Flat index of the cell that holds each place, -1 outside of all cells, (n,).

        Parameters
        ----------
        x : ndarray
            Places (m), (n,).
        y : ndarray
            Places (m), (n,).

        Returns
        -------
        Index
            Rows counted first, from the lower left.
        """
        (ny, nx), (dx, dy) = self.shape, self.spacing
        column, row = (x - self.x[0]) / dx + 0.5, (y - self.y[0]) / dy + 0.5
        # Places on the outer edges belong to the grid, up to round-off.
        slack = 1e-9
        inside = (column > -slack) & (column < nx + slack) & (row > -slack) & (row < ny + slack)
        column, row = np.where(inside, column, 0.0), np.where(inside, row, 0.0)
        i = np.clip(np.floor(column).astype(np.int64), 0, nx - 1)
        j = np.clip(np.floor(row).astype(np.int64), 0, ny - 1)
        return np.where(inside, j * nx + i, -1)

    def touches(self, x: Array, y: Array, radius: Array) -> NDArray[np.bool_]:
        """Whether discs (m) overlap the rectangle of the cells or have their centre in it, (n,).

        Parameters
        ----------
        x : ndarray
            Centres (m), (n,).
        y : ndarray
            Centres (m), (n,).
        radius : ndarray
            m, (n,).

        Returns
        -------
        ndarray
            (n,).
        """
        (dx, dy), inside = self.spacing, self.cell_of(x, y) >= 0
        away_x = np.abs(x - 0.5 * (self.x[0] + self.x[-1])) - 0.5 * dx * len(self.x)
        away_y = np.abs(y - 0.5 * (self.y[0] + self.y[-1])) - 0.5 * dy * len(self.y)
        return inside | (np.hypot(np.maximum(away_x, 0.0), np.maximum(away_y, 0.0)) < radius)

    def pairs(self, x: Array, y: Array, reach: int = 1) -> Stencil:
        """Find the nodes in reach of each element.

        Parameters
        ----------
        x, y : ndarray
            Element centres (m), (n,); a slice of the elements will do. Those outside the grid
            find no node.
        reach : int
            Half-width of the hats in grid spacings.

        Returns
        -------
        Stencil
            Pairs sorted by node, with the hat's value (1) and the place of the element relative to
            the node (spacings).

        Raises
        ------
        FloeError
            For places that are not finite, lengths that differ, or a reach below 1.
        """
        if reach < 1:
            raise FloeError(
                f"remap: a reach of {reach} grid spacings finds nothing; give 1 or more"
            )
        check_places(x, y, self)
        (ny, nx), (dx, dy) = self.shape, self.spacing
        column, row = (x - self.x[0]) / dx, (y - self.y[0]) / dy
        cells = sort_by_cell(column, row, nx, ny, reach)
        start, element, hat, xi, eta = lattice_pairs(*cells, nx, ny, reach)
        return Stencil(start, element, hat, xi, eta, len(x))
