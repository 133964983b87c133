# SPDX-License-Identifier: GPL-2.0-or-later
"""A rectangle that repeats itself: nearest images, copies around it, places brought back into it.

Its bounds are west, south, east and north edge (m); an axis with infinite bounds has ends.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Period = tuple[float, float, float, float]

# Attribute of masks, packings and states that holds the bounds; missing where nothing repeats.
ATTRIBUTE = "period"


def period_of(attrs: Mapping[Hashable, object]) -> Period | None:
    """Bounds that a dataset's attributes hold; None where nothing repeats.

    Parameters
    ----------
    attrs : mapping of object
        Of a state or packing.

    Returns
    -------
    tuple of float or None
        West, south, east and north edges (m).
    """
    if ATTRIBUTE not in attrs:
        return None
    west, south, east, north = np.asarray(attrs[ATTRIBUTE], float).tolist()
    return west, south, east, north


def sides(period: Period) -> tuple[float, float]:
    """Width and height (m); infinite where an axis does not repeat.

    Parameters
    ----------
    period : Period
        x_min, y_min, x_max, y_max (m); infinite where an axis does not repeat.

    Returns
    -------
    tuple of float
        m, along x and y.
    """
    return period[2] - period[0], period[3] - period[1]


def shortest(between: tuple[Array, Array], period: Period | None) -> tuple[Array, Array]:
    """Differences of places in x and y (m), each (m,), to the nearest image of the second.

    Parameters
    ----------
    between : tuple of ndarray
        In x and in y (m), (m,) each.
    period : Period or None
        Along which axes places repeat themselves; None for none.

    Returns
    -------
    tuple of ndarray
        m, (m,) each.
    """
    dx, dy = between
    if period is None:
        return dx, dy
    wide, high = sides(period)
    # Without a rounding where nothing repeats: infinity times 0 is not a number.
    if np.isfinite(wide):
        dx = dx - wide * np.rint(dx / wide)
    if np.isfinite(high):
        dy = dy - high * np.rint(dy / high)
    return dx, dy


def apart(places: Array, first: Index, second: Index, period: Period | None) -> Array:
    """Distances (m) of pairs of places (n, 2), to the nearest image, (m,).

    Parameters
    ----------
    places : ndarray
        m, (n, 2).
    first : Index
        Rows of the pairs, (m,).
    second : Index
        Rows of the pairs, (m,).
    period : Period or None
        Along which axes places repeat themselves; None for none.

    Returns
    -------
    ndarray
        m.
    """
    between = places[second] - places[first]
    return np.asarray(np.hypot(*shortest((between[:, 0], between[:, 1]), period)))


def distances_of(
    elements: Mapping[str, NDArray[Any]], lo: Index, hi: Index, period: Period | None
) -> Array:
    """Distances (m) of pairs of elements with x and y (n,), to the nearest image, (m,).

    Parameters
    ----------
    elements : mapping of ndarray
        With x and y (m), (n,).
    lo : Index
        Rows of the pairs, (m,).
    hi : Index
        Rows of the pairs, (m,).
    period : Period or None
        Along which axes places repeat themselves; None for none.

    Returns
    -------
    ndarray
        m.
    """
    x, y = elements["x"], elements["y"]
    return np.asarray(np.hypot(*shortest((x[hi] - x[lo], y[hi] - y[lo]), period)))


def wrapped(places: Array, period: Period | None) -> Array:
    """Places (m), (n, 2), brought back into the rectangle.

    Parameters
    ----------
    places : ndarray
        m, (n, 2).
    period : Period or None
        Along which axes places repeat themselves; None for none.

    Returns
    -------
    ndarray
        m, (n, 2).
    """
    if period is None:
        return places
    out = np.array(places, float)
    for axis, side in enumerate(sides(period)):
        if np.isfinite(side):
            low = period[axis]
            inside = np.mod(out[:, axis] - low, side)
            # The remainder of what lies a round-off below the edge is the whole side.
            out[:, axis] = np.where(low + inside < period[axis + 2], low + inside, low)
    return out


def shifts(period: Period | None) -> list[Array]:
    """Ways (m), (2,), from a rectangle to its copies around it, and to itself.

    Parameters
    ----------
    period : Period or None
        x_min, y_min, x_max, y_max (m); None where nothing repeats.

    Returns
    -------
    list of ndarray
        x and y (m), (2,) each; 9 where both axes repeat, 3 where one does, else 1.
    """
    if period is None:
        return [np.zeros(2)]
    across, up = ((-side, 0.0, side) if np.isfinite(side) else (0.0,) for side in sides(period))
    return [np.array(way) for way in product(across, up)]


def images(places: Array, reach: float, period: Period | None) -> tuple[Array, Index]:
    """Copies of places around the rectangle, no further off than a reach.

    Parameters
    ----------
    places : ndarray
        (n, 2) in metres, within the rectangle.
    reach : float
        How far off copies count, m.
    period : tuple of float, optional
        Bounds; without them there are no copies.

    Returns
    -------
    copies, of : ndarray
        (k, 2) in metres, and the row of which each is a copy, (k,).
    """
    found, of = [np.empty((0, 2))], [np.empty(0, np.int64)]
    if period is None:
        return found[0], of[0]
    low, top = np.array(period[:2]) - reach, np.array(period[2:]) + reach
    for shift in shifts(period):
        if not shift.any():
            continue
        moved = places + shift
        near = np.flatnonzero(((moved > low) & (moved < top)).all(axis=1))
        found.append(moved[near])
        of.append(near)
    return np.concatenate(found), np.concatenate(of)


def tree_of(places: Array, period: Period | None) -> cKDTree:
    """Search tree of places (m), (n, 2), in which distances are those to the nearest image.

    What is sought in it has to be given as `in_tree` gives it.

    Parameters
    ----------
    places : ndarray
        m, (n, 2).
    period : Period or None
        Along which axes places repeat themselves; None for none.

    Returns
    -------
    cKDTree
        Of the places counted from the rectangle's corner, where there is a period.
    """
    # Here, since every scene reads this module, and the start of a run needs no tree.
    from scipy.spatial import cKDTree

    if period is None:
        return cKDTree(places)
    # 0 stands for an axis that does not repeat.
    box = [side if np.isfinite(side) else 0.0 for side in sides(period)]
    return cKDTree(in_tree(places, period), boxsize=box)


def in_tree(places: Array, period: Period | None) -> Array:
    """Places as a tree of `tree_of` has them: from the corner of the rectangle.

    Parameters
    ----------
    places : ndarray
        m, (n, 2).
    period : Period or None
        Along which axes places repeat themselves; None for none.

    Returns
    -------
    ndarray
        m, (n, 2).
    """
    if period is None:
        return places
    corner = np.array([low if np.isfinite(low) else 0.0 for low in period[:2]])
    return np.asarray(wrapped(places, period) - corner)
