# SPDX-License-Identifier: GPL-2.0-or-later
"""Discs that overlap without having been pressed together: placed so, or grown into each other.

The contact law would take such an overlap for a spring that somebody has compressed, and throw
the discs apart. It makes no force here: it is written into the contact table as rest overlap,
which the law takes back as the discs part. What presses them closer is met as by any contact.
"""

from __future__ import annotations

import numpy as np

from floeflow.core.errors import FloeError
from floeflow.core.period import Period, apart, in_tree, tree_of
from floeflow.dynamics.engine.params import FIXED
from floeflow.state.bonds import Arrays, element_rows

# Centres closer than this share of the smaller radius have no direction to push in.
COINCIDENT = 1e-6


def overlapping_pairs(
    elements: Arrays, period: Period | None = None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows and overlaps (m) of all discs that overlap, sorted; lower row first.

    Parameters
    ----------
    elements : Arrays
        Table of n elements.
    period : Period, optional
        Along which axes the domain repeats itself.

    Returns
    -------
    lo, hi : ndarray
        Rows of the two, lo < hi, (m,) each.
    overlap : ndarray
        m, positive, (m,).

    Raises
    ------
    FloeError
        Where two elements stand at the same place.
    """
    points = np.column_stack([elements["x"], elements["y"]])
    radius = np.asarray(elements["radius"])
    found = _close_pairs(points, radius, period)
    lo, hi = found[np.lexsort((found[:, 1], found[:, 0]))].T
    distance = apart(points, lo, hi, period)
    same = distance < COINCIDENT * np.minimum(radius[lo], radius[hi])
    if same.any():
        k = int(np.flatnonzero(same)[0])
        raise FloeError(
            f"Elements {elements['id'][lo[k]]} and {elements['id'][hi[k]]} are at the same place, "
            f"x = {points[lo[k], 0]:.7g} m, y = {points[lo[k], 1]:.7g} m."
        )
    overlap = radius[lo] + radius[hi] - distance
    keep = overlap > 0.0
    return lo[keep], hi[keep], overlap[keep]


def _close_pairs(points: np.ndarray, radius: np.ndarray, period: Period | None) -> np.ndarray:
    """Pairs that may overlap, (n, 2); classes of radius spare trying a few large discs with all.

    A pair is looked for in the class of its larger disc, around the larger one.
    """
    found = [np.zeros((0, 2), np.int64)]
    octave = np.floor(np.log2(radius)).astype(int)
    points = in_tree(points, period)
    for size in np.unique(octave):
        rows = np.flatnonzero(octave <= size)
        large = np.flatnonzero(octave == size)
        tree = tree_of(points[rows], period)
        near = tree.query_ball_point(points[large], radius[large] + 2.0 ** (size + 1))
        count = [len(item) for item in near]
        first = np.repeat(large, count)
        second = rows[np.concatenate([np.asarray(item, np.int64) for item in near])]
        # Within a class each pair is found from both sides.
        kept = (octave[second] < size) | (first < second)
        found.append(np.column_stack([first[kept], second[kept]]))
    pairs = np.concatenate(found)
    return np.sort(pairs[pairs[:, 0] != pairs[:, 1]], axis=1)


def rest_overlaps(
    elements: Arrays, bonds: Arrays | None, contacts: Arrays, period: Period | None = None
) -> Arrays:
    """Contact table with a rest overlap for each pair that overlaps and is not yet in it.

    Parameters
    ----------
    elements : dict of ndarray, shape (n,)
        As `Engine.load` takes them.
    bonds : dict of ndarray, or None
        Bond table: bonded pairs do not also collide.
    contacts : dict of ndarray, shape (c,)
        Contacts with their history.
    period : tuple of float, optional
        Bounds (m) of a rectangle that repeats itself.

    Returns
    -------
    dict of ndarray
        The table, sorted by (id_lo, id_hi).

    Raises
    ------
    FloeError
        Where two elements stand at the same place.
    """
    lo, hi, overlap = overlapping_pairs(elements, period)
    fixed = np.asarray(elements["type"]) == FIXED
    known = [_keys(elements, contacts)] + ([] if bonds is None else [_keys(elements, bonds)])
    n = len(elements["id"])
    new = ~(fixed[lo] & fixed[hi]) & ~np.isin(lo * n + hi, np.concatenate(known))
    if not new.any():
        return contacts
    ids = np.asarray(elements["id"])
    added = {name: np.zeros(int(new.sum()), values.dtype) for name, values in contacts.items()}
    added |= {"id_lo": ids[lo[new]], "id_hi": ids[hi[new]], "rest_overlap": overlap[new]}
    joined = {name: np.concatenate([contacts[name], added[name]]) for name in contacts}
    order = np.lexsort((joined["id_hi"], joined["id_lo"]))
    return {name: values[order] for name, values in joined.items()}


def _keys(elements: Arrays, pairs: Arrays) -> np.ndarray:
    lo, hi = (element_rows(elements["id"], pairs[name]) for name in ("id_lo", "id_hi"))
    return lo * len(elements["id"]) + hi
