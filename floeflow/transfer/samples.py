# SPDX-License-Identifier: GPL-2.0-or-later
"""From a grid to elements, and back what the elements answer.

A sampler is a sparse matrix whose rows add up to 1: an element's value is a mean of the nodes
around it, at its centre (bilinear) or over its cell. Its transpose gives the elements' amounts
(stress or heat flux times area) back to those nodes in the same shares, so that the grid's total
is the elements' total and the work of a stress is the same on both sides.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array
from scipy.spatial import cKDTree

from floeflow.core.errors import FloeError
from floeflow.core.vectors import rotate
from floeflow.transfer.grid import Grid
from floeflow.transfer.quadrature import Points
from floeflow.transfer.stencil import Array, Target


@dataclass(frozen=True)
class Sampler:
    """Shares of the nodes in the elements' values.

    Parameters
    ----------
    matrix : scipy.sparse.csr_array
        (n, nodes): rows add up to 1; those of elements without a node that counts are empty.
    target : Target
        The grid or mesh.
    """

    matrix: csr_array
    target: Target

    def known(self) -> NDArray[np.bool_]:
        """Whether an element has a node that counts, (n,)."""
        return np.diff(self.matrix.indptr) > 0

    def at(self, field: Array, name: str = "field") -> Array:
        """Values of a field at the elements.

        Parameters
        ----------
        field : ndarray
            (..., *target.shape); nodes that are masked may hold anything.
        name : str
            What it is, for messages.

        Returns
        -------
        ndarray
            (..., n), NaN at elements without a node.

        Raises
        ------
        FloeError
            For a field of another shape, or not finite at a node that counts.
        """
        shape = self.target.shape
        if field.shape[-len(shape) :] != shape:
            raise FloeError(f"{name}: it has shape {field.shape}, the grid {shape}")
        flat = field.reshape(-1, self.matrix.shape[1])
        used = np.zeros(self.matrix.shape[1], bool)
        used[self.matrix.indices] = True
        bad = used & ~np.isfinite(flat).all(axis=0)
        if bad.any():
            node = int(np.argmax(bad))
            x, y = (float(axis[node]) for axis in self.target.places())
            raise FloeError(f"{name}: it is not finite at x = {x:g} m, y = {y:g} m")
        values = np.asarray(self.matrix @ np.where(used, flat, 0.0).T).T
        values = np.where(self.known(), values, np.nan)
        return values.reshape(*field.shape[: -len(shape)], self.matrix.shape[0])

    def give_back(self, amount: Array, name: str = "amount") -> Array:
        """Share out amounts of the elements, (n,), to the nodes, (target.shape).

        The sum over the nodes is the sum over the elements that have nodes; slices add up.

        Parameters
        ----------
        amount : ndarray
            (n,).
        name : str, optional
            For messages.

        Returns
        -------
        ndarray
            In the unit of the amounts, (target.shape).

        Raises
        ------
        FloeError
            For a field of another length, or not finite.
        """
        n = self.matrix.shape[0]
        if amount.shape != (n,):
            raise FloeError(f"{name}: it has shape {amount.shape}, but there are {n} elements")
        if not np.isfinite(amount[self.known()]).all():
            e = int(np.argmax(self.known() & ~np.isfinite(amount)))
            raise FloeError(f"{name}: it is {amount[e]} at element {e}")
        return np.asarray(self.matrix.T @ np.where(self.known(), amount, 0.0)).reshape(
            self.target.shape
        )


def build_sampler(
    x: Array,
    y: Array,
    target: Target,
    *,
    points: Points | None = None,
    valid: NDArray[np.bool_] | None = None,
    fill: float = 0.0,
) -> Sampler:
    """Build the shares of the nodes in the values of elements.

    Parameters
    ----------
    x, y : ndarray
        Element centres (m), (n,); a slice of the elements will do. Up to one grid spacing outside
        of the outermost nodes the rim's values hold.
    target : Target
        The grid or mesh.
    points : Points, optional
        Points over the elements' cells, for means over them (`quadrature`); without it values are
        those at the centres. Points outside of the grid do not count.
    valid : ndarray of bool, optional
        Nodes that count, (target.shape): sea for a field of the ocean, all without it. The others
        get and give nothing, whatever they hold.
    fill : float
        An element without a node that counts takes the nearest that does, up to this far (m).

    Returns
    -------
    Sampler
        Matrix (n, nodes) whose rows add up to 1, or to 0 where an element has no node.

    Raises
    ------
    FloeError
        For places that are not finite, a mask of another shape, or an element outside of the grid,
        by its number.
    """
    shape = target.shape
    if valid is not None and valid.shape != shape:
        raise FloeError(f"remap: the mask has shape {valid.shape}, the grid {shape}")
    matrix = _shares(x, y, target)
    inside = np.diff(matrix.indptr) > 0
    if not inside.all():
        e = int(np.argmin(inside))
        raise FloeError(
            f"remap: element {e} at x = {x[e]:g} m, y = {y[e]:g} m lies outside of the grid"
        )
    if points is not None:
        matrix = csr_array(points.mean @ _shares(points.x, points.y, target))
    if valid is not None:
        matrix = csr_array(matrix @ diags_array(valid.ravel().astype(np.float64)))
    matrix.eliminate_zeros()
    sums = np.asarray(matrix.sum(axis=1))
    matrix = csr_array(diags_array(1.0 / np.where(sums > 0.0, sums, 1.0)) @ matrix)
    if fill > 0.0 and valid is not None and valid.any():
        matrix = _fill(matrix, x, y, target, valid.ravel(), fill)
    matrix.sort_indices()
    return Sampler(matrix, target)


def _shares(x: Array, y: Array, target: Target) -> csr_array:
    """Hats of the nodes at places, (places, nodes); empty rows outside of the grid."""
    if isinstance(target, Grid):
        (x0, x1), (y0, y1) = target.x[[0, -1]], target.y[[0, -1]]
        dx, dy = target.spacing
        near = (x >= x0 - dx) & (x <= x1 + dx) & (y >= y0 - dy) & (y <= y1 + dy)
        # Far places stay where they are and find no node.
        x, y = np.where(near, np.clip(x, x0, x1), x), np.where(near, np.clip(y, y0, y1), y)
    pairs = target.pairs(x, y)
    nodes = len(pairs.start) - 1
    return csr_array(csr_array((pairs.hat, pairs.element, pairs.start), shape=(nodes, len(x))).T)


def _fill(
    matrix: csr_array, x: Array, y: Array, target: Target, valid: NDArray[np.bool_], far: float
) -> csr_array:
    """Give elements without a node the nearest valid one, up to a distance (m)."""
    bare = np.flatnonzero(np.diff(matrix.indptr) == 0)
    if not len(bare):
        return matrix
    places = np.stack(target.places(), axis=1)
    known = np.flatnonzero(valid & np.isfinite(places).all(axis=1))
    away, nearest = cKDTree(places[known]).query(np.stack([x[bare], y[bare]], axis=1))
    near = away <= far
    rows, columns = bare[near], known[nearest[near]]
    extra = csr_array((np.ones(len(rows)), (rows, columns)), shape=matrix.shape)
    return csr_array(matrix + extra)


def vector_at(
    sampler: Sampler, u: Array, v: Array, turn: Array | None = None, name: str = "vector"
) -> tuple[Array, Array]:
    """Components of a vector along the scene's axes at the elements, (..., n) each.

    Parameters
    ----------
    sampler : Sampler
        Shares of the nodes.
    u, v : ndarray
        Components along the grid's own axes, (..., *target.shape).
    turn : ndarray, optional
        Angle from the scene's x axis to the grid's first axis at the nodes, anticlockwise (rad),
        (target.shape): for east and north `preprocess.vectors.north_angle` less a quarter turn.
        Vectors are turned at the nodes, so that nothing breaks at the pole. Without it the axes
        are the scene's.
    name : str
        What it is, for messages.

    Returns
    -------
    x, y : ndarray
        In the unit of the components, (..., n) each.
    """
    if turn is not None:
        u, v = rotate(u, v, turn)
    return sampler.at(u, f"{name}_x"), sampler.at(v, f"{name}_y")


def vector_back(
    sampler: Sampler, u: Array, v: Array, turn: Array | None = None, name: str = "vector"
) -> tuple[Array, Array]:
    """Amounts of a vector (force) given back to the nodes, along the grid's own axes.

    Parameters
    ----------
    sampler : Sampler
        Shares of the nodes.
    u, v : ndarray
        Components along the scene's axes, (n,).
    turn, name
        As `vector_at` takes them.

    Returns
    -------
    u, v : ndarray
        In the unit of the amounts, (target.shape) each.
    """
    back_u, back_v = sampler.give_back(u, f"{name}_x"), sampler.give_back(v, f"{name}_y")
    return (back_u, back_v) if turn is None else rotate(back_u, back_v, -turn)


def mean_wind(sampler: Sampler, u: Array, v: Array, name: str = "wind") -> tuple[Array, Array]:
    """Wind (or current) whose stress is the mean of the stress over the nodes' shares.

    Stress goes with speed times velocity. The mean of velocities loses what its gusts and turns
    within a cell do; here |w| w is the mean of |u| u, so that the elements get the grid's stress.

    Parameters
    ----------
    sampler : Sampler
        Best with points over the elements' cells.
    u, v : ndarray
        Components along the scene's axes (m/s), (..., *target.shape).
    name : str
        What it is, for messages.

    Returns
    -------
    tuple of ndarray
        Components (m/s), (..., n).
    """
    speed = np.hypot(u, v)
    tx, ty = sampler.at(speed * u, name), sampler.at(speed * v, name)
    root = np.sqrt(np.hypot(tx, ty))
    safe = np.where(root > 0.0, root, 1.0)
    return tx / safe, ty / safe
