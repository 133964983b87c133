# SPDX-License-Identifier: GPL-2.0-or-later
"""Moving least squares from elements to nodes, Shepard's average where that is ill-conditioned.

Each node fits a plane to the elements in its hat, weighted by the hat and by the amount of the
field's parent (ice area for thickness, mass for velocity), and takes the plane's value at itself.
Sums over elements (`node_moments`) add up over slices of them; all else is local to a node or to
a pair, so ranks can share the elements.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from floeflow.errors import FloeError
from floeflow.postprocess.remap.grid import Array, Grid, Index, Stencil, stencil

EMPTY, SHEPARD, MLS = 0, 1, 2

CONDITION_LIMIT = 1e3
# Elements with less than this share of the heaviest one's weight count as having none: the square
# of what is left cannot underflow.
LEAST_SHARE = 1e-100
FORMAT = 1


@dataclass(frozen=True)
class Weights:
    """Weights of the elements at the nodes of a grid.

    Parameters
    ----------
    matrix : scipy.sparse.csr_array
        (ny nx, n): rows of nodes in reach of an element add up to 1, the others are empty.
    grid : Grid
        The grid.
    status : ndarray of int8
        (ny, nx): EMPTY, SHEPARD or MLS.
    condition : ndarray
        (ny, nx): condition number of the scaled moment matrix; inf where it is singular.
    reach : int
        Half-width of the hats in grid spacings.
    """

    matrix: csr_array
    grid: Grid
    status: NDArray[np.int8]
    condition: Array
    reach: int

    def apply(self, field: Array, bounded: bool = False) -> Array:
        """Average an intensive field of the elements at the nodes.

        Parameters
        ----------
        field : ndarray
            (n,). Elements without weight may hold NaN.
        bounded : bool
            Cut the value at the least and the largest of the node's own elements, which a plane
            oversteps where all elements lie on one side of the node.

        Returns
        -------
        ndarray
            (ny, nx), NaN where no element is in reach.

        Raises
        ------
        FloeError
            For a field of another length, or not finite where it has weight.
        """
        matrix = self.matrix
        if field.shape != (matrix.shape[1],):
            raise FloeError(
                f"remap: the field has shape {field.shape}, the weights are for "
                f"{matrix.shape[1]} elements"
            )
        source = field[matrix.indices]
        if not np.isfinite(source).all():
            e = int(matrix.indices[np.argmin(np.isfinite(source))])
            raise FloeError(f"remap: the field is {field[e]} at element {e}, which has weight")
        filled = np.flatnonzero(self.status.ravel() != EMPTY)
        values = (matrix @ field)[filled]
        if bounded and len(filled):
            starts = matrix.indptr[filled]
            low, high = np.minimum.reduceat(source, starts), np.maximum.reduceat(source, starts)
            values = np.clip(values, low, high)
        out = np.full(self.status.size, np.nan)
        out[filled] = values
        return out.reshape(self.status.shape)


def node_moments(pairs: Stencil, weight: Array, nodes: int) -> Array:
    """Moments of the elements around each node, which add up over slices of the elements.

    Parameters
    ----------
    pairs : Stencil
        Pairs of node and element.
    weight : ndarray
        Amount of the parent in each element, (n,).
    nodes : int
        Number of nodes.

    Returns
    -------
    ndarray
        (6, nodes): sums of 1, xi, eta, xi^2, xi eta, eta^2 times hat and weight.
    """
    share = pairs.hat * weight[pairs.element]
    xi, eta = pairs.xi, pairs.eta
    terms = (share, share * xi, share * eta, share * xi**2, share * xi * eta, share * eta**2)
    return np.stack([np.bincount(pairs.node, term, nodes) for term in terms])


def moment_condition(moments: Array) -> Array:
    """Condition number of each node's moment matrix, scaled by its mass; inf if singular."""
    mass = moments[0]
    condition = np.full(mass.shape, np.inf)
    some = np.flatnonzero(mass > 0.0)
    m = moments[:, some] / mass[some]
    matrices = m[[0, 1, 2, 1, 3, 4, 2, 4, 5]].T.reshape(-1, 3, 3)
    values = np.linalg.eigvalsh(matrices)
    # Below round-off of the largest, the smallest eigenvalue is noise of either sign.
    regular = values[:, 0] > 1e-15 * values[:, 2]
    condition[some[regular]] = values[regular, 2] / values[regular, 0]
    return condition


def _planes(moments: Array, fits: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Centre (2, nodes) of each node's elements, and its solution g of C g = centre.

    With the coordinates counted from the centre of the elements, the moment matrix falls apart
    into their mass and a 2 x 2 covariance C, and the weight of an element is
    (1 - g (xi - centre)) hat weight / mass: the same plane with less round-off. Shepard: g = 0.
    """
    mass = np.where(moments[0] > 0.0, moments[0], 1.0)
    cx, cy = centre = moments[1:3] / mass
    xx, xy, yy = moments[3:6] / mass - np.stack([cx * cx, cx * cy, cy * cy])
    determinant = np.where(fits, xx * yy - xy * xy, 1.0)
    g = np.stack([yy * cx - xy * cy, xx * cy - xy * cx]) / determinant
    return centre, np.where(fits, g, 0.0)


def build_weights(
    x: Array,
    y: Array,
    area: Array,
    grid: Grid,
    *,
    reach: int = 1,
    condition_limit: float = CONDITION_LIMIT,
) -> Weights:
    """Build the weights of elements at the nodes of a grid.

    Parameters
    ----------
    x, y : ndarray
        Element centres (m), (n,).
    area : ndarray
        What the field is averaged over: the amount of its parent in each element (area, ice area,
        mass ...), (n,), not negative. Elements with none get no weight.
    grid : Grid
        The grid.
    reach : int
        Half-width of the hats in grid spacings; about two spacings of the elements is best.
    condition_limit : float
        Nodes whose scaled moment matrix has a larger condition number (6 for evenly spread
        elements) get Shepard's average. It bounds how far a plane is extrapolated, and its
        round-off.

    Returns
    -------
    Weights
        To apply to any number of fields with this parent.

    Raises
    ------
    FloeError
        For places or amounts that are not finite or negative, or lengths that differ.
    """
    if area.shape != x.shape:
        raise FloeError(f"remap: {len(x)} elements, but {area.size} amounts to weight them by")
    bad = ~(np.isfinite(area) & (area >= 0.0))
    if bad.any():
        e = int(np.argmax(bad))
        raise FloeError(f"remap: element {e} is weighted by {area[e]}")
    pairs = stencil(x, y, grid, reach)
    heaviest = area.max(initial=0.0)
    weight = area / heaviest if heaviest > 0.0 else area
    pairs = _select(pairs, np.flatnonzero(weight[pairs.element] > LEAST_SHARE))
    moments = node_moments(pairs, weight, grid.shape[0] * grid.shape[1])
    condition = moment_condition(moments)
    fits = condition <= condition_limit
    status = np.where(moments[0] > 0.0, np.where(fits, MLS, SHEPARD), EMPTY).astype(np.int8)
    return Weights(
        matrix=_matrix(pairs, weight, moments, fits, len(x)),
        grid=grid,
        status=status.reshape(grid.shape),
        condition=condition.reshape(grid.shape),
        reach=reach,
    )


def _select(pairs: Stencil, chosen: Index) -> Stencil:
    return Stencil(
        node=pairs.node[chosen],
        element=pairs.element[chosen],
        hat=pairs.hat[chosen],
        xi=pairs.xi[chosen],
        eta=pairs.eta[chosen],
    )


def _matrix(
    pairs: Stencil, weight: Array, moments: Array, fits: NDArray[np.bool_], elements: int
) -> csr_array:
    """Weights of all pairs, elements in ascending order within each node."""
    (cx, cy), (gx, gy) = _planes(moments, fits)
    i = pairs.node
    tilt = gx[i] * (pairs.xi - cx[i]) + gy[i] * (pairs.eta - cy[i])
    psi = (1.0 - tilt) * pairs.hat * weight[pairs.element] / moments[0][i]
    matrix = csr_array((psi, (i, pairs.element)), shape=(len(fits), elements))
    matrix.sort_indices()
    return matrix


def save_weights(weights: Weights, path: str | Path) -> None:
    """Write weights as an .npz file without pickles."""
    matrix = weights.matrix
    with open(path, "wb") as file:
        np.savez(
            file,
            format=np.int64(FORMAT),
            data=matrix.data,
            indices=matrix.indices,
            indptr=matrix.indptr,
            elements=np.int64(matrix.shape[1]),
            x=weights.grid.x,
            y=weights.grid.y,
            status=weights.status,
            condition=weights.condition,
            reach=np.int64(weights.reach),
        )


def load_weights(path: str | Path) -> Weights:
    """Read weights that `save_weights` wrote; they give the same bits.

    Raises
    ------
    FloeError
        Where the file is missing or holds no weights of this format.
    """
    try:
        with open(path, "rb") as file, np.load(file, allow_pickle=False) as stored:
            if stored["format"] != FORMAT:
                raise FloeError(f"{path}: remap weights of format {stored['format']}, not {FORMAT}")
            grid = Grid(stored["x"], stored["y"])
            shape = (grid.shape[0] * grid.shape[1], int(stored["elements"]))
            parts = (stored["data"], stored["indices"], stored["indptr"])
            return Weights(
                matrix=csr_array(parts, shape=shape),
                grid=grid,
                status=stored["status"],
                condition=stored["condition"],
                reach=int(stored["reach"]),
            )
    except FileNotFoundError:
        raise FloeError(f"{path}: there is no such file") from None
    except (OSError, ValueError, TypeError, KeyError, BadZipFile, EOFError):
        raise FloeError(f"{path}: holds no remap weights") from None
