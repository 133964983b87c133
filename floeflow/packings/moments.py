# SPDX-License-Identifier: GPL-2.0-or-later
"""Clusters of discs with given centroids and second moments.

The second moments of a cluster are those of its centres, weighted by area, and of the discs
themselves: r^2 / 4 about each axis (its moment of inertia is m r^2 / 2). A linear map about the
centroid takes the centres' part P to what is wanted, Q: x -> Q^(1/2) P^(-1/2) x.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]

# Centres move by no more than this share of their distance from the centroid in one round.
MOST = 0.15


def cluster_moments(
    places: Array, area: Array, radius: Array, of: Index
) -> tuple[Array, Array, Array]:
    """Area, centroid and second moments over area of clusters.

    Parameters
    ----------
    places, area, radius : ndarray
        Discs: centres (m), (n, 2), the areas that they stand for (m2), radii (m), (n,).
    of : ndarray
        Cluster of each, (n,).

    Returns
    -------
    total : ndarray
        m2, (f,).
    middle : ndarray
        m, (f, 2).
    second : ndarray
        m2, (f, 2, 2).
    """
    total = np.bincount(of, area).astype(float)
    middle = np.stack([np.bincount(of, area * places[:, k]) / total for k in (0, 1)], axis=1)
    off = places - middle[of]
    own = np.bincount(of, area * radius**2 / 4.0) / total
    second: Array = np.empty((len(total), 2, 2))
    for a in (0, 1):
        for b in (0, 1):
            second[:, a, b] = np.bincount(of, area * off[:, a] * off[:, b]) / total
        second[:, a, a] += own
    return total, middle, second


def match_moments(
    places: Array, area: Array, radius: Array, of: Index, wanted: tuple[Array, Array]
) -> Array:
    """Centres moved so that each cluster has the wanted centroid and second moments.

    Parameters
    ----------
    places, area, radius, of
        As in `cluster_moments`.
    wanted : tuple of ndarray
        Centroids (m), (f, 2), and second moments over area (m2), (f, 2, 2).

    Returns
    -------
    ndarray
        Centres (m), (n, 2). Clusters of less than three discs are only shifted.
    """
    middle, second = wanted
    _, now, whole = cluster_moments(places, area, radius, of)
    own = np.bincount(of, area * radius**2 / 4.0) / np.bincount(of, area)
    unit = own[:, None, None] * np.eye(2)
    have, want = whole - unit, second - unit
    least = 1e-6 * second.trace(axis1=1, axis2=2)
    fit = (np.bincount(of) >= 3) & (_least(have) > least) & (_least(want) > least)
    change = np.broadcast_to(np.eye(2), have.shape).copy()
    change[fit] = _root(want[fit]) @ np.linalg.inv(_root(have[fit]))
    # A turn does no good: the symmetric part alone, and not too far at once.
    change = 0.5 * (change + change.transpose(0, 2, 1)) - np.eye(2)
    size = np.maximum(np.abs(change).max(axis=(1, 2)), 1e-300)
    change *= np.minimum(1.0, MOST / size)[:, None, None]
    off = places - now[of]
    return middle[of] + off + np.einsum("nab,nb->na", change[of], off)


def match_areas(
    places: Array, area: Array, radius: Array, of: Index, wanted: tuple[Array, Array]
) -> Array:
    """Areas shifted among the discs of a cluster towards the wanted moments; their sums stay.

    The smallest relative changes (least squares) that give centroid and second moments, as far as
    none exceeds `MOST`.

    Parameters
    ----------
    places, area, radius, of, wanted
        As in `match_moments`.

    Returns
    -------
    ndarray
        m2, (n,).
    """
    area = area.copy()
    members = np.split(np.argsort(of, kind="stable"), np.cumsum(np.bincount(of))[:-1])
    for cluster, mine in enumerate(members):
        if len(mine) < 3:
            continue
        total = area[mine].sum()
        second = wanted[1][cluster] / wanted[1][cluster].trace()
        off = (places[mine] - wanted[0][cluster]) / np.sqrt(wanted[1][cluster].trace())
        own = radius[mine] ** 2 / (4.0 * wanted[1][cluster].trace())
        x, y = off.T
        rows = np.stack([np.ones(len(mine)), x, y, x * x + own, x * y, y * y + own])
        rows *= area[mine] / total
        lack = np.array([1.0, 0.0, 0.0, second[0, 0], second[0, 1], second[1, 1]]) - rows.sum(
            axis=1
        )
        change = np.linalg.lstsq(rows, lack, rcond=1e-8)[0]
        change *= min(1.0, MOST / max(float(np.abs(change).max()), 1e-300))
        changed = area[mine] * (1.0 + change)
        area[mine] = changed * (total / changed.sum())
    return area


def _least(matrix: Array) -> Array:
    return np.asarray(np.linalg.eigvalsh(matrix)[:, 0])


def _root(matrix: Array) -> Array:
    """Square root of symmetric positive matrices."""
    values, vectors = np.linalg.eigh(matrix)
    return np.asarray((vectors * np.sqrt(values)[:, None, :]) @ vectors.transpose(0, 2, 1))
