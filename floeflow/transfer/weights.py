# SPDX-License-Identifier: GPL-2.0-or-later
"""Moving least squares from elements to nodes, Shepard's average where that is ill-conditioned.

Each node fits a plane to the elements in its hat, weighted by the hat and by the amount of the
field's parent (ice area for thickness, mass for velocity), and takes the plane's value at itself.
Sums over elements (`node_moments`) add up over slices of them; all else is local to a node or to
a pair, so ranks can share the elements.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from floeflow.core.errors import FloeError
from floeflow.transfer.bounded import Ranks
from floeflow.transfer.stencil import (
    Array,
    Index,
    Planes,
    Stencil,
    Target,
    plane_weights,
    row_bounds,
    sum_moments,
)

EMPTY, SHEPARD, MLS, FILLED, NEAREST = 0, 1, 2, 3, 4

CONDITION_LIMIT = 1e3
# Elements with less than this share of the heaviest one's weight count as having none: the square
# of what is left cannot underflow.
LEAST_SHARE = 1e-100


@dataclass(frozen=True)
class Weights:
    """Weights of the elements at the nodes of a target.

    Parameters
    ----------
    matrix : scipy.sparse.csr_array
        (nodes, n): rows of nodes in reach of an element add up to 1, the others are empty.
    target : Target
        The grid or mesh.
    status : ndarray of int8
        (target.shape): EMPTY, SHEPARD, MLS, FILLED from the nearest node that is not empty, or
        NEAREST element alone.
    condition : ndarray
        (target.shape): condition number of the scaled moment matrix; inf where it is singular.
    reach : int
        Half-width of the hats in grid spacings.
    """

    matrix: csr_array
    target: Target
    status: NDArray[np.int8]
    condition: Array
    reach: int

    def apply(self, field: Array, bounded: bool = False, ranks: Ranks | None = None) -> Array:
        """Average an intensive field of the elements at the nodes.

        Parameters
        ----------
        field : ndarray
            (n,). Elements without weight may hold NaN.
        bounded : bool
            Cut the value at the least and the largest of the node's own elements, which a plane
            oversteps where all elements lie on one side of the node.
        ranks : Ranks, optional
            Where the elements are a slice: how to add up over ranks.

        Returns
        -------
        ndarray
            (target.shape), NaN where no element is in reach.

        Raises
        ------
        FloeError
            For a field of another length, or not finite where it has weight.
        """
        self._check(field)
        values = np.asarray(self.matrix @ field)
        values = ranks.add(values) if ranks else values
        if bounded:
            low, high = self.bounds(field, ranks)
            values = np.minimum(np.maximum(values, low.ravel()), high.ravel())
        values[self.status.ravel() == EMPTY] = np.nan
        return values.reshape(self.status.shape)

    def bounds(self, field: Array, ranks: Ranks | None = None) -> tuple[Array, Array]:
        """Least and largest value among the elements of each node, (target.shape) each.

        Infinite (least above largest) where no element is in reach.

        Parameters
        ----------
        field : ndarray
            Of each element, (n,).
        ranks : Ranks, optional
            Bounds over all ranks.

        Returns
        -------
        tuple of ndarray
            In the unit of the field.

        Raises
        ------
        FloeError
            For a wrong shape, or a value that is not finite.
        """
        self._check(field)
        low, high = row_bounds(self.matrix.indptr, self.matrix.indices, field)
        if ranks:
            low, high = -ranks.largest(-low), ranks.largest(high)
        return low.reshape(self.status.shape), high.reshape(self.status.shape)

    def filled(self, distance: float) -> Weights:
        """Give empty nodes the weights of the nearest node that has some, up to a distance (m).

        Parameters
        ----------
        distance : float
            m.

        Returns
        -------
        Weights
            With status `FILLED` at nodes that were empty; what is further away stays empty.
        """
        status = self.status.ravel().copy()
        empty, known = np.flatnonzero(status == EMPTY), np.flatnonzero(status != EMPTY)
        if not (len(empty) and len(known)):
            return self
        places = np.stack(self.target.places(), axis=1)
        empty = empty[np.isfinite(places[empty]).all(axis=1)]
        away, nearest = cKDTree(places[known]).query(places[empty])
        near = away <= distance
        row = np.arange(len(status))
        row[empty[near]] = known[nearest[near]]
        status[empty[near]] = FILLED
        matrix = csr_array(self.matrix[row])
        return replace(self, matrix=matrix, status=status.reshape(self.status.shape))

    def _check(self, field: Array) -> None:
        n = self.matrix.shape[1]
        if field.shape != (n,):
            raise FloeError(
                f"remap: the field has shape {field.shape}, the weights are for {n} elements"
            )
        bad = np.flatnonzero(~np.isfinite(field))
        if len(bad):
            used = bad[np.isin(bad, self.matrix.indices)]
            if len(used):
                e = int(used[0])
                raise FloeError(f"remap: the field is {field[e]} at element {e}, which has weight")


def node_moments(pairs: Stencil, weight: Array) -> Array:
    """Moments of the elements around each node, which add up over slices of the elements.

    Parameters
    ----------
    pairs : Stencil
        Pairs of node and element.
    weight : ndarray
        Amount of the parent in each element, (n,).

    Returns
    -------
    ndarray
        (6, nodes): sums of 1, xi, eta, xi^2, xi eta, eta^2 times hat and weight.
    """
    s = pairs
    return np.asarray(sum_moments(s.start, s.element, s.hat, s.xi, s.eta, weight))


def moment_condition(moments: Array) -> Array:
    """Condition number of each node's moment matrix, scaled by its mass; inf if singular.

    The eigenvalues of a symmetric 3 x 3 matrix in closed form (Smith 1961, Commun. ACM 4, 168).

    Parameters
    ----------
    moments : ndarray
        Of each node, (n, 3, 3).

    Returns
    -------
    ndarray
        1, (n,).
    """
    some = np.flatnonzero(moments[0] > 0.0)
    a, b, aa, ab, bb = moments[1:, some] / moments[0, some]
    mean = (1.0 + aa + bb) / 3.0
    d0, d1, d2 = 1.0 - mean, aa - mean, bb - mean
    spread = np.sqrt((d0**2 + d1**2 + d2**2 + 2.0 * (a * a + b * b + ab * ab)) / 6.0)
    safe = np.where(spread > 0.0, spread, 1.0)
    determinant = d0 * (d1 * d2 - ab * ab) - a * (a * d2 - ab * b) + b * (a * ab - d1 * b)
    angle = np.arccos(np.clip(0.5 * determinant / safe**3, -1.0, 1.0)) / 3.0
    largest = mean + 2.0 * spread * np.cos(angle)
    least = mean + 2.0 * spread * np.cos(angle + 2.0 * np.pi / 3.0)
    # Below round-off of the largest, the smallest eigenvalue is noise of either sign.
    regular = least > 1e-13 * largest
    condition = np.full(moments.shape[1], np.inf)
    condition[some[regular]] = largest[regular] / least[regular]
    return condition


def _planes(moments: Array, fits: NDArray[np.bool_]) -> Planes:
    """Mass and centre of each node's elements, and g of C g = centre.

    With the coordinates counted from the centre of the elements, the moment matrix falls apart
    into their mass and a 2 x 2 covariance C, and the weight of an element is
    (1 - g (xi - centre)) hat weight / mass: the same plane with less round-off. Shepard: g = 0.
    """
    mass = np.where(moments[0] > 0.0, moments[0], 1.0)
    cx, cy = moments[1:3] / mass
    xx, xy, yy = moments[3:6] / mass - np.stack([cx * cx, cx * cy, cy * cy])
    determinant = np.where(fits, xx * yy - xy * xy, 1.0)
    g = np.stack([yy * cx - xy * cy, xx * cy - xy * cx]) / determinant
    return Planes(mass, cx, cy, *np.where(fits, g, 0.0))


def build_weights(
    x: Array,
    y: Array,
    area: Array,
    target: Target,
    *,
    reach: int = 1,
    condition_limit: float = CONDITION_LIMIT,
    pairs: Stencil | None = None,
    ranks: Ranks | None = None,
) -> Weights:
    """Build the weights of elements at the nodes of a target.

    Parameters
    ----------
    x, y : ndarray
        Element centres (m), (n,).
    area : ndarray
        What the field is averaged over: the amount of its parent in each element (area, ice area,
        mass ...), (n,), not negative. Elements with none get no weight.
    target : Target
        The grid or mesh.
    reach : int
        Half-width of the hats in grid spacings; about two spacings of the elements is best.
    condition_limit : float
        Nodes whose scaled moment matrix has a larger condition number (6 for evenly spread
        elements) get Shepard's average. It bounds how far a plane is extrapolated, and its
        round-off.
    pairs : Stencil, optional
        ``target.pairs(x, y, reach)``, where it is known already.
    ranks : Ranks, optional
        Where the elements are a slice: how to add up over ranks. Every rank calls; the matrix
        then holds the rank's own elements, all else is the same on every rank.

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
    ranks = ranks or Ranks()
    pairs = pairs or target.pairs(x, y, reach)
    heaviest = float(ranks.largest(np.array([area.max(initial=0.0)]))[0])
    weight = area / heaviest if heaviest > 0.0 else area
    light = weight <= LEAST_SHARE
    if light.any():
        pairs = select_pairs(pairs, ~light[pairs.element])
    moments = ranks.add(node_moments(pairs, weight))
    condition = moment_condition(moments)
    fits = condition <= condition_limit
    status = np.where(moments[0] > 0.0, np.where(fits, MLS, SHEPARD), EMPTY).astype(np.int8)
    s, planes = pairs, _planes(moments, fits)
    psi = plane_weights(s.start, s.element, s.hat, s.xi, s.eta, weight, planes)
    matrix = sparse(s.start, s.element, psi, len(x))
    shape = target.shape
    return Weights(matrix, target, status.reshape(shape), condition.reshape(shape), reach)


def select_pairs(pairs: Stencil, chosen: NDArray[np.bool_]) -> Stencil:
    """Some of the pairs of a stencil.

    Parameters
    ----------
    pairs : Stencil
        Sorted by node.
    chosen : ndarray
        Which of the pairs stay, (pairs,).

    Returns
    -------
    Stencil
        Sorted by node, for the same nodes.
    """
    before = np.concatenate([[0], np.cumsum(chosen)])
    hat, xi, eta = (column[chosen] for column in (pairs.hat, pairs.xi, pairs.eta))
    return Stencil(before[pairs.start], pairs.element[chosen], hat, xi, eta, pairs.elements)


def sparse(start: Index, element: NDArray[np.int32], data: Array, elements: int) -> csr_array:
    """Sparse matrix (nodes, elements) of sorted pairs, with 32-bit indices where they suffice.

    Parameters
    ----------
    start : Index
        First pair of each node, (nodes + 1,).
    element : ndarray
        Element of each pair, (pairs,).
    data : ndarray
        Value of each pair, (pairs,).
    elements : int
        Number of elements.

    Returns
    -------
    csr_array
        The pairs' values.
    """
    if start[-1] < np.iinfo(np.int32).max:
        start = start.astype(np.int32)
    return csr_array((data, element, start), shape=(len(start) - 1, elements))
