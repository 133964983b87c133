# SPDX-License-Identifier: GPL-2.0-or-later
"""Nearest of many straight lines to many points in the plane, compiled, on square bins."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]

# Bins beyond so many times the number of lines would only cost memory.
MOST_BINS = 64


@dataclass(frozen=True)
class NearLines:
    """Lines, ready to be searched from points no further than a reach away.

    Parameters
    ----------
    ends : ndarray
        Both ends of each line (m), (m, 2, 2).
    reach : float
        How far (m) a point looks.
    low : tuple of float
        Lower left corner of the bins (m).
    size : float
        Side of a bin (m).
    count : tuple of int
        Bins along x and along y.
    start, line : ndarray
        Lines that may be in reach of a bin's points: starts by bin, and rows of `ends`.
    """

    ends: Array
    reach: float
    low: tuple[float, float]
    size: float
    count: tuple[int, int]
    start: Index
    line: Index

    def nearest(self, points: Array) -> tuple[Array, Array]:
        """Distance (m) of points (n, 2) from the lines, and the nearest place on one (m), (n, 2).

        Infinite and nan where no line is in reach.

        Parameters
        ----------
        points : ndarray
            m.

        Returns
        -------
        distance, place : ndarray
            m, (n,), and x and y (m), (n, 2).
        """
        away, foot = np.full(len(points), np.inf), np.full((len(points), 2), np.nan)
        x, y = np.ascontiguousarray(points.T, dtype=float)
        frame = (*self.low, self.size, *self.count)
        held = self.start, self.line
        _nearest(x, y, self.ends, self.reach, frame, held, away, foot)
        return away, foot


def near_lines(ends: Array, reach: float) -> NearLines:
    """Sort lines (m), (m, 2, 2), for a search of a reach (m) above 0.

    Parameters
    ----------
    ends : ndarray
        m, (m, 2, 2).
    reach : float
        m.

    Returns
    -------
    NearLines
        Lines sorted into bins.
    """
    ends = np.ascontiguousarray(ends, dtype=float)
    if not len(ends):
        return NearLines(ends, reach, (0.0, 0.0), 1.0, (0, 0), np.zeros(1, int), np.empty(0, int))
    low, high = ends.min(axis=(0, 1)) - reach, ends.max(axis=(0, 1)) + reach
    wide, tall = high - low
    size = max(reach, math.sqrt(wide * tall / (MOST_BINS * len(ends) + 64)))
    frame = (float(low[0]), float(low[1]), size, int(wide / size) + 1, int(tall / size) + 1)
    held = np.zeros(frame[3] * frame[4] + 1, np.int64)
    _sort(ends, reach, frame, held, np.empty(0, np.int64))
    start = np.cumsum(held)
    line = np.empty(start[-1], np.int64)
    _sort(ends, reach, frame, start[:-1].copy(), line)
    return NearLines(ends, reach, frame[:2], size, frame[3:], start, line)


@njit(cache=True, nogil=True)
def _away(px: float, py: float, ends: np.ndarray) -> tuple[float, ...]:
    """Distance of a point from a line with ends, and its nearest place."""
    ax, ay = ends[0, 0], ends[0, 1]
    dx, dy = ends[1, 0] - ax, ends[1, 1] - ay
    length = dx * dx + dy * dy
    share = 0.0
    if length > 0.0:
        share = min(max(((px - ax) * dx + (py - ay) * dy) / length, 0.0), 1.0)
    fx, fy = ax + share * dx, ay + share * dy
    return math.hypot(px - fx, py - fy), fx, fy


@njit(cache=True, nogil=True)
def _sort(
    ends: np.ndarray,
    reach: float,
    frame: tuple[float, float, float, int, int],
    at: np.ndarray,
    line: np.ndarray,
) -> None:
    """Count the lines of each bin (no room in `line`: one bin later), or write them where due."""
    x0, y0, size, nx, ny = frame
    reach_of_bin = reach + 0.7072 * size
    for k in range(len(ends)):
        west, east = min(ends[k, 0, 0], ends[k, 1, 0]), max(ends[k, 0, 0], ends[k, 1, 0])
        south, north = min(ends[k, 0, 1], ends[k, 1, 1]), max(ends[k, 0, 1], ends[k, 1, 1])
        i0, i1 = max(int((west - reach - x0) / size), 0), int((east + reach - x0) / size)
        j0, j1 = max(int((south - reach - y0) / size), 0), int((north + reach - y0) / size)
        for j in range(j0, min(j1, ny - 1) + 1):
            for i in range(i0, min(i1, nx - 1) + 1):
                away, _, _ = _away(x0 + (i + 0.5) * size, y0 + (j + 0.5) * size, ends[k])
                if away > reach_of_bin:
                    continue
                b = j * nx + i
                if len(line) == 0:
                    at[b + 1] += 1
                else:
                    line[at[b]] = k
                    at[b] += 1


@njit(cache=True, nogil=True)
def _nearest(
    x: np.ndarray,
    y: np.ndarray,
    ends: np.ndarray,
    reach: float,
    frame: tuple[float, float, float, int, int],
    held: tuple[np.ndarray, np.ndarray],
    away: np.ndarray,
    foot: np.ndarray,
) -> None:
    """Write distance and nearest place of points; ``held``: starts of the bins, and their lines."""
    start, line = held
    x0, y0, size, nx, ny = frame
    for p in range(len(x)):
        i, j = int(math.floor((x[p] - x0) / size)), int(math.floor((y[p] - y0) / size))
        if i < 0 or i >= nx or j < 0 or j >= ny:
            continue
        b = j * nx + i
        for s in range(start[b], start[b + 1]):
            far, fx, fy = _away(x[p], y[p], ends[line[s]])
            if far <= reach and far < away[p]:
                away[p], foot[p, 0], foot[p, 1] = far, fx, fy
