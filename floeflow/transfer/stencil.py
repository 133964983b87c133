# SPDX-License-Identifier: GPL-2.0-or-later
"""Pairs of a node and an element in reach of it, and what a node sums over its elements.

Pairs are sorted by node, so that they have the shape of a sparse matrix already. Within a node they
are sorted by the cell in which the element lies (regular grids) and by element.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numba
import numpy as np
from numpy.typing import NDArray

from floeflow.core.errors import FloeError

Array = NDArray[np.float64]
Index = NDArray[np.int64]

jit: Any = numba.njit(cache=True, nogil=True, error_model="numpy")

# An element this near to the rim of a hat counts as out of reach: its share of a node is nothing,
# but alone in a hat it would still decide what the node gets.
LEAST_HAT = 1e-12


@dataclass(frozen=True)
class Stencil:
    """Pairs of a node and an element in reach of it.

    Parameters
    ----------
    start : ndarray of int
        First pair of each node, and the end, (nodes + 1,).
    element : ndarray of int
        Index of the element, (pairs,).
    hat : ndarray
        The node's hat function at the element, in (0, 1], (pairs,).
    xi, eta : ndarray
        Element minus node, scaled by the reach of the hat, (pairs,).
    elements : int
        Number of elements, with and without a node.
    """

    start: Index
    element: NDArray[np.int32]
    hat: Array
    xi: Array
    eta: Array
    elements: int


class Planes(NamedTuple):
    """What the plane of each node is fitted by; arrays of shape (nodes,).

    Parameters
    ----------
    mass : ndarray
        Sum of hat times weight; 1 where there is none.
    centre_x, centre_y : ndarray
        Mean of xi and of eta.
    tilt_x, tilt_y : ndarray
        Inverse of the covariance times the centre; 0 for Shepard's average.
    """

    mass: Array
    centre_x: Array
    centre_y: Array
    tilt_x: Array
    tilt_y: Array


class Target(Protocol):
    """What fields can go to: nodes with hat functions."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of a field on the nodes."""

    @property
    def crs(self) -> str:
        """Projection of its places; empty where not said."""

    def places(self) -> tuple[Array, Array]:
        """Nodes, x and y (m), (nodes,) each."""

    def pairs(self, x: Array, y: Array, reach: int = 1) -> Stencil:
        """Find the nodes in reach of each element.

        Parameters
        ----------
        x : ndarray
            Places of the elements, (n,), m.
        y : ndarray
            Places of the elements, (n,), m.
        reach : int, optional
            Half-width of the hats in spacings of the nodes.

        Returns
        -------
        Stencil
            Pairs sorted by node.
        """


def check_places(x: Array, y: Array, target: Target) -> None:
    """Refuse places that cannot be, by the number of the first.

    Parameters
    ----------
    x : ndarray
        Places of the elements, (n,), m.
    y : ndarray
        Places of the elements, (n,), m.
    target : Target
        Nodes.

    Raises
    ------
    FloeError
        For a wrong shape, a place that is not finite, or nodes that look like degrees.
    """
    if x.shape != y.shape or x.ndim != 1:
        raise FloeError(f"remap: x has shape {x.shape} and y {y.shape}; both must be (n,)")
    bad = ~(np.isfinite(x) & np.isfinite(y))
    if bad.any():
        e = int(np.argmax(bad))
        raise FloeError(f"remap: element {e} lies at x = {x[e]}, y = {y[e]}")
    node_x, node_y = target.places()
    wide, high = (np.abs(axis[np.isfinite(axis)]).max(initial=0.0) for axis in (node_x, node_y))
    if wide <= 360.0 and high <= 90.0 and len(x) and min(np.abs(x).max(), np.abs(y).max()) > 1e4:
        raise FloeError(
            "remap: 'x' and 'y' of the grid look like degrees (up to "
            f"{wide:g} and {high:g}), but the elements lie at "
            f"metres (element 0 at x = {x[0]:g}, y = {y[0]:g}): project the grid first"
        )


@jit
def sort_by_cell(
    column: np.ndarray, row: np.ndarray, nx: int, ny: int, reach: int
) -> tuple[np.ndarray, ...]:
    """Elements between the nodes of a lattice in order of the cells between them.

    The rim of the lattice has ``reach`` more cells on each side. Returns the first element of each
    cell, and index, column and row of the elements. What lies side by side is so looked at in
    turn, however the elements are numbered.

    Parameters
    ----------
    column : ndarray
        Places in units of the spacing, counted from the first node, (n,).
    row : ndarray
        Places in units of the spacing, counted from the first node, (n,).
    nx : int
        Numbers of nodes.
    ny : int
        Numbers of nodes.
    reach : int
        Half-width of the hats in spacings.

    Returns
    -------
    tuple of ndarray
        First element of each cell (cells + 1,); index, column and row of the m elements in reach,
        (m,).
    """
    width, height = nx - 1 + 2 * reach, ny - 1 + 2 * reach
    n = len(column)
    cell = np.empty(n, np.int32)
    start = np.zeros(width * height + 1, np.int64)
    for e in range(n):
        c, r = column[e], row[e]
        if -reach < c < nx - 1 + reach and -reach < r < ny - 1 + reach:
            cell[e] = (int(np.floor(r)) + reach) * width + int(np.floor(c)) + reach
            start[cell[e] + 1] += 1
        else:
            cell[e] = -1
    for k in range(width * height):
        start[k + 1] += start[k]
    place = start[:-1].copy()
    element = np.empty(start[-1], np.int32)
    columns, rows = np.empty(start[-1]), np.empty(start[-1])
    for e in range(n):
        if cell[e] >= 0:
            k = place[cell[e]]
            place[cell[e]] += 1
            element[k], columns[k], rows[k] = e, column[e], row[e]
    return start, element, columns, rows


@jit
def lattice_pairs(
    cell_start: np.ndarray,
    order: np.ndarray,
    column: np.ndarray,
    row: np.ndarray,
    nx: int,
    ny: int,
    reach: int,
) -> tuple[np.ndarray, ...]:
    """Pairs of a regular grid from elements that `sort_by_cell` has sorted; see `Stencil`.

    Parameters
    ----------
    cell_start : ndarray
        First element of each cell (cells + 1,), and index of the elements, (m,).
    order : ndarray
        First element of each cell (cells + 1,), and index of the elements, (m,).
    column : ndarray
        Places of the sorted elements in units of the spacing, (m,).
    row : ndarray
        Places of the sorted elements in units of the spacing, (m,).
    nx : int
        Numbers of nodes.
    ny : int
        Numbers of nodes.
    reach : int
        Half-width of the hats in spacings.

    Returns
    -------
    tuple of ndarray
        First pair of each node (nodes + 1,); element, hat, xi and eta of the pairs, (pairs,).
    """
    width = nx - 1 + 2 * reach
    most = len(order) * (2 * reach) ** 2
    start = np.zeros(nx * ny + 1, np.int64)
    element = np.empty(most, np.int32)
    hat, xi, eta = np.empty(most), np.empty(most), np.empty(most)
    found = 0
    for j in range(ny):
        for i in range(nx):
            for below in range(j, j + 2 * reach):
                # Cells of a row lie one after the other, and so do their elements.
                first = below * width + i
                for k in range(cell_start[first], cell_start[first + 2 * reach]):
                    a, b = (column[k] - i) / reach, (row[k] - j) / reach
                    n = (1.0 - abs(a)) * (1.0 - abs(b))
                    if n > LEAST_HAT:
                        element[found], hat[found] = order[k], n
                        xi[found], eta[found] = a, b
                        found += 1
            start[j * nx + i + 1] = found
    return start, element[:found], hat[:found], xi[:found], eta[:found]


def sort_pairs(
    node: Index, element: Index, columns: tuple[Array, Array, Array], nodes: int, elements: int
) -> Stencil:
    """Stencil from pairs in any order; ``columns`` are hat, xi and eta.

    Parameters
    ----------
    node : Index
        Node of each pair, (pairs,).
    element : Index
        Element of each pair, (pairs,).
    columns : tuple of ndarray
        Hat and local coordinates of each pair, (pairs,) each.
    nodes : int
        Numbers of nodes and of elements.
    elements : int
        Numbers of nodes and of elements.

    Returns
    -------
    Stencil
        Sorted by node, then by element.
    """
    order = np.lexsort((element, node))
    start = np.zeros(nodes + 1, np.int64)
    np.cumsum(np.bincount(node, minlength=nodes), out=start[1:])
    hat, xi, eta = (column[order] for column in columns)
    return Stencil(start, element[order].astype(np.int32), hat, xi, eta, elements)


@jit
def sum_moments(
    start: np.ndarray,
    element: np.ndarray,
    hat: np.ndarray,
    xi: np.ndarray,
    eta: np.ndarray,
    weight: np.ndarray,
) -> np.ndarray:
    """Sums of 1, xi, eta, xi^2, xi eta, eta^2 times hat and weight, (6, nodes).

    Parameters
    ----------
    start : ndarray
        First pair of each node, (nodes + 1,).
    element : ndarray
        Element of each pair, (pairs,).
    hat : ndarray
        Hat and local coordinates of each pair, (pairs,).
    xi : ndarray
        Hat and local coordinates of each pair, (pairs,).
    eta : ndarray
        Hat and local coordinates of each pair, (pairs,).
    weight : ndarray
        Of each element, (n,).

    Returns
    -------
    ndarray
        In the unit of the weight.
    """
    nodes = len(start) - 1
    moments = np.zeros((6, nodes))
    for node in range(nodes):
        s = a = b = aa = ab = bb = 0.0
        for k in range(start[node], start[node + 1]):
            w = hat[k] * weight[element[k]]
            s += w
            a += w * xi[k]
            b += w * eta[k]
            aa += w * xi[k] * xi[k]
            ab += w * xi[k] * eta[k]
            bb += w * eta[k] * eta[k]
        moments[0, node], moments[1, node], moments[2, node] = s, a, b
        moments[3, node], moments[4, node], moments[5, node] = aa, ab, bb
    return moments


@jit
def plane_weights(
    start: np.ndarray,
    element: np.ndarray,
    hat: np.ndarray,
    xi: np.ndarray,
    eta: np.ndarray,
    weight: np.ndarray,
    planes: Planes,
) -> np.ndarray:
    """Weights psi of all pairs, (pairs,); see `floeflow.transfer.weights`.

    Parameters
    ----------
    start, element, hat, xi, eta : ndarray
        Of a `Stencil`.
    weight : ndarray
        Amount of the parent in each element, (n,).
    planes : Planes
        Of the nodes.

    Returns
    -------
    ndarray
        1, (pairs,), in the order of the pairs.
    """
    mass, cx, cy, gx, gy = planes
    psi = np.empty(len(element))
    for node in range(len(start) - 1):
        for k in range(start[node], start[node + 1]):
            tilt = gx[node] * (xi[k] - cx[node]) + gy[node] * (eta[k] - cy[node])
            psi[k] = (1.0 - tilt) * hat[k] * weight[element[k]] / mass[node]
    return psi


@jit
def row_bounds(start: np.ndarray, element: np.ndarray, field: np.ndarray) -> tuple[np.ndarray, ...]:
    """Least and largest value among each node's elements; inf and -inf without any.

    Parameters
    ----------
    start : ndarray
        First pair of each node, (nodes + 1,).
    element : ndarray
        Element of each pair, (pairs,).
    field : ndarray
        Of each element, (n,).

    Returns
    -------
    tuple of ndarray
        (nodes,) each.
    """
    nodes = len(start) - 1
    low, high = np.full(nodes, np.inf), np.full(nodes, -np.inf)
    for node in range(nodes):
        for k in range(start[node], start[node + 1]):
            value = field[element[k]]
            low[node], high[node] = min(low[node], value), max(high[node], value)
    return low, high
