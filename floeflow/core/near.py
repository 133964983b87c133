# SPDX-License-Identifier: GPL-2.0-or-later
"""Compiled searches among points in the plane, on square bins: nearest, thinned, pushed apart.

All take a time that grows with the number of points alone, and do the same in the same order each
time, so that the same input gives the same bits.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floeflow.core.period import Period, images

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Flags = NDArray[np.bool_]

# Bins beyond so many times the number of points would only cost memory.
MOST_BINS = 4


class _Bins(NamedTuple):
    """Points in square bins: lower left corner, side, numbers along x and y, starts, points."""

    x0: float
    y0: float
    size: float
    nx: int
    ny: int
    start: Index
    order: Index


class _Places(NamedTuple):
    """Points or marks (m), and the territory of each; arrays of shape (n,)."""

    x: Array
    y: Array
    of: Index


def _bins(x: Array, y: Array, size: float) -> _Bins:
    """Sort points into bins at least as wide as a size (m)."""
    frame = _frame(x, y, size)
    return _Bins(*frame, *_binned(x, y, *frame))


def _frame(x: Array, y: Array, size: float) -> tuple[float, float, float, int, int]:
    """Lower left corner, side and numbers of bins that hold all points."""
    low = float(x.min()), float(y.min())
    wide, high = float(x.max()) - low[0], float(y.max()) - low[1]
    # A few points over a wide plane get wider bins.
    size = max(size, math.sqrt(wide * high / (MOST_BINS * len(x) + 64)))
    size = max(size, max(wide, high) / 1.0e5) or 1.0
    return low[0], low[1], size, int(wide / size) + 1, int(high / size) + 1


@njit(cache=True, nogil=True)
def _binned(
    x: np.ndarray, y: np.ndarray, x0: float, y0: float, size: float, nx: int, ny: int
) -> tuple[np.ndarray, ...]:
    """Bin of each point, starts of the bins and the points in the order of bins."""
    count = len(x)
    bin_of = np.empty(count, np.int64)
    start = np.zeros(nx * ny + 1, np.int64)
    for k in range(count):
        i = min(max(int((x[k] - x0) / size), 0), nx - 1)
        j = min(max(int((y[k] - y0) / size), 0), ny - 1)
        bin_of[k] = j * nx + i
        start[bin_of[k] + 1] += 1
    for b in range(nx * ny):
        start[b + 1] += start[b]
    order = np.empty(count, np.int64)
    filled = start[:-1].copy()
    for k in range(count):
        order[filled[bin_of[k]]] = k
        filled[bin_of[k]] += 1
    return start, order


@njit(cache=True, nogil=True)
def _owners(
    marks: _Places, points: _Places, weight: np.ndarray, bins: _Bins, owner: np.ndarray
) -> None:
    mx, my, of_mark = marks
    x, y, of = points
    x0, y0, size, nx, ny, start, order = bins
    most = 0.0
    for k in range(len(weight)):
        most = max(most, weight[k])
    for m in range(len(mx)):
        px, py, mine = mx[m], my[m], of_mark[m]
        ci = int(math.floor((px - x0) / size))
        cj = int(math.floor((py - y0) / size))
        best, who = np.inf, -1
        ring = 0
        # Rings that miss the bins altogether are passed over.
        ring = max(ring, -ci, ci - nx + 1, -cj, cj - ny + 1)
        last = max(abs(ci), abs(ci - nx + 1), abs(cj), abs(cj - ny + 1))
        while ring <= last:
            for j in range(max(cj - ring, 0), min(cj + ring, ny - 1) + 1):
                edge = j == cj - ring or j == cj + ring
                step = 1 if edge or ring == 0 else 2 * ring
                i = ci - ring
                while i <= ci + ring:
                    if 0 <= i < nx:
                        b = j * nx + i
                        for s in range(start[b], start[b + 1]):
                            k = order[s]
                            if of[k] != mine:
                                continue
                            dx, dy = x[k] - px, y[k] - py
                            power = dx * dx + dy * dy - weight[k]
                            if power < best or (power == best and k < who):
                                best, who = power, k
                    i += step
            # No point beyond this ring is nearer than so many bins.
            if best <= (ring * size) ** 2 - most:
                break
            ring += 1
        owner[m] = who


def owners(
    points: Array,
    marks: Array,
    weight: Array | None = None,
    territory: tuple[Index, Index] | None = None,
) -> Index:
    """Point of the least power |m - x|^2 - w for each mark: the nearest one without weights.

    Parameters
    ----------
    points, marks : ndarray
        (n, 2), n >= 1, and (m, 2) in metres.
    weight : ndarray, optional
        w of each point (m2), (n,).
    territory : tuple of ndarray, optional
        To which each point (n,) and each mark (m,) belongs: a mark goes to a point of its own.
        Each has a point.

    Returns
    -------
    ndarray
        Row of the point, the lower one of two that are equal, (m,); -1 where a territory has none.
    """
    x, y = np.ascontiguousarray(points.T, dtype=float)
    mx, my = np.ascontiguousarray(marks.T, dtype=float)
    weight = np.zeros(len(x)) if weight is None else np.asarray(weight, float)
    of, of_mark = territory or (np.zeros(len(x), np.int64), np.zeros(len(mx), np.int64))
    if len(mx) == 0:
        return np.empty(0, np.int64)
    # As wide as an even spread of the points over the marks would be apart.
    wide, high = float(np.ptp(mx)), float(np.ptp(my))
    size = max(math.sqrt(wide * high / len(x)), max(wide, high) / (16.0 * len(x)))
    size = max(size, max(float(np.abs(x - mx[0]).max()), float(np.abs(y - my[0]).max())) / 1.0e5)
    owner = np.empty(len(mx), np.int64)
    _owners(_Places(mx, my, of_mark), _Places(x, y, of), weight, _bins(x, y, size), owner)
    return owner


@njit(cache=True, nogil=True)
def _thin(
    x: np.ndarray,
    y: np.ndarray,
    reach: np.ndarray,
    turn: np.ndarray,
    bins: _Bins,
    chosen: np.ndarray,
) -> None:
    x0, y0, size, nx, ny, start, order = bins
    for k in turn:
        i = min(max(int((x[k] - x0) / size), 0), nx - 1)
        j = min(max(int((y[k] - y0) / size), 0), ny - 1)
        free = True
        for jj in range(max(j - 1, 0), min(j + 1, ny - 1) + 1):
            for ii in range(max(i - 1, 0), min(i + 1, nx - 1) + 1):
                b = jj * nx + ii
                for s in range(start[b], start[b + 1]):
                    other = order[s]
                    if chosen[other]:
                        dx, dy = x[other] - x[k], y[other] - y[k]
                        apart = 0.5 * (reach[k] + reach[other])
                        if dx * dx + dy * dy < apart * apart:
                            free = False
                            break
                if not free:
                    break
            if not free:
                break
        chosen[k] = free


def thin(points: Array, priority: Index, distance: float | Array) -> Flags:
    """Choose a largest set of points no two of which are nearer than a distance.

    The points are thrown one after the other; one stays where no earlier one is too near.

    Parameters
    ----------
    points : ndarray
        (n, 2).
    priority : ndarray
        A permutation of 0..n-1; lower ranks come first.
    distance : float or ndarray
        Same unit as the points; one for each point (n,): two keep the mean of theirs.

    Returns
    -------
    ndarray
        Of bool, True for those that stay, (n,).
    """
    x, y = np.ascontiguousarray(points.T, dtype=float)
    reach = np.broadcast_to(np.asarray(distance, float), len(x)).copy()
    chosen = np.zeros(len(x), dtype=bool)
    _thin(x, y, reach, np.argsort(priority), _bins(x, y, float(reach.max())), chosen)
    return chosen


@njit(cache=True, nogil=True)
def _pushes(
    x: np.ndarray,
    y: np.ndarray,
    radius: np.ndarray,
    mobile: int,
    share: float,
    bins: _Bins,
    px: np.ndarray,
    py: np.ndarray,
) -> float:
    """Moves of all discs that would take away a share of each overlap; returns the deepest."""
    nx, ny, start, order = bins.nx, bins.ny, bins.start, bins.order
    deepest = 0.0
    for b in range(nx * ny):
        i, j = b % nx, b // nx
        for s in range(start[b], start[b + 1]):
            k = order[s]
            # Half of the bins around: each pair once.
            for near in range(5):
                ii = i + (0 if near == 0 else near - 2 if near < 4 else 1)
                jj = j + (1 if 0 < near < 4 else 0)
                if ii < 0 or ii >= nx or jj >= ny:
                    continue
                c = jj * nx + ii
                first = s + 1 if near == 0 else start[c]
                for t in range(first, start[c + 1]):
                    other = order[t]
                    if k >= mobile and other >= mobile:
                        continue
                    dx, dy = x[other] - x[k], y[other] - y[k]
                    reach = radius[k] + radius[other]
                    square = dx * dx + dy * dy
                    if square >= reach * reach or square == 0.0:
                        continue
                    distance = math.sqrt(square)
                    overlap = reach - distance
                    deepest = max(deepest, overlap)
                    part = share * overlap / distance
                    if k < mobile and other < mobile:
                        px[k] -= part * dx
                        py[k] -= part * dy
                        px[other] += part * dx
                        py[other] += part * dy
                    elif k < mobile:
                        px[k] -= 2.0 * part * dx
                        py[k] -= 2.0 * part * dy
                    else:
                        px[other] += 2.0 * part * dx
                        py[other] += 2.0 * part * dy
    return deepest


def pushes(points: Array, radius: Array, mobile: int, share: float) -> tuple[Array, float]:
    """Moves that would take away a share of each overlap of discs, a pair's in equal parts.

    Parameters
    ----------
    points, radius : ndarray
        Discs (m), (n, 2) and (n,); those from row `mobile` on are fixed.
    mobile : int
        How many can move.
    share : float
        Of the overlap, for each of the two.

    Returns
    -------
    moves : ndarray
        (mobile, 2) in metres.
    deepest : float
        Largest overlap (m).
    """
    x, y = np.ascontiguousarray(points.T, dtype=float)
    bins = _bins(x, y, 2.0 * float(radius.max()))
    px, py = np.zeros(len(x)), np.zeros(len(x))
    radius = np.ascontiguousarray(radius, dtype=float)
    deepest = _pushes(x, y, radius, mobile, share, bins, px, py)
    return np.stack([px, py], axis=1)[:mobile], float(deepest)


@njit(cache=True, nogil=True)
def _deepest(x: np.ndarray, y: np.ndarray, radius: np.ndarray, mobile: int, bins: _Bins) -> float:
    nx, ny, start, order = bins.nx, bins.ny, bins.start, bins.order
    deepest = 0.0
    for b in range(nx * ny):
        i, j = b % nx, b // nx
        for s in range(start[b], start[b + 1]):
            k = order[s]
            for jj in range(j, min(j + 1, ny - 1) + 1):
                for ii in range(max(i - 1, 0), min(i + 1, nx - 1) + 1):
                    c = jj * nx + ii
                    if c < b:
                        continue
                    for t in range(s + 1 if c == b else start[c], start[c + 1]):
                        other = order[t]
                        if k >= mobile and other >= mobile:
                            continue
                        reach = radius[k] + radius[other]
                        dx, dy = x[other] - x[k], y[other] - y[k]
                        if abs(dx) < reach and abs(dy) < reach:
                            deepest = max(deepest, 1.0 - math.hypot(dx, dy) / reach)
    return deepest


def deepest_overlap(
    points: Array,
    radius: Array,
    mobile: int,
    period: Period | None = None,
) -> float:
    """Largest overlap of discs, as a share of the sum of the two radii; 0 where none overlap.

    Parameters
    ----------
    points, radius : ndarray
        Discs (m), (n, 2) and (n,); two fixed ones, from row `mobile` on, do not count.
    mobile : int
        How many can move.
    period : tuple of float, optional
        Bounds (m) of a rectangle that repeats itself and holds them all (`floeflow.core.period`).

    Returns
    -------
    float
        1.
    """
    # Copies count as fixed ones.
    copies, of = images(points, 2.0 * float(radius.max()), period)
    points, radius = np.concatenate([points, copies]), np.concatenate([radius, radius[of]])
    x, y = np.ascontiguousarray(points.T, dtype=float)
    radius = np.ascontiguousarray(radius, dtype=float)
    bins = _bins(x, y, 2.0 * float(radius.max()))
    return float(_deepest(x, y, radius, mobile, bins))
