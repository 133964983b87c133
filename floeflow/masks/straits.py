# SPDX-License-Identifier: GPL-2.0-or-later
"""Straits of a coarse land mask, open or shut as on the fine one; inland seas that are no sea.

Cells that are land where most of them is land shut straits narrower than themselves, and join seas
across thin spits. Here three things are mended, on samples of the 1 km mask: a passage of samples
through land cells is opened where the way around is long; a cell of water is shut that joins what
no samples join nearby; water that no samples join to the sea becomes land.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.ndimage import find_objects, label

Flags = NDArray[np.bool_]
Index = NDArray[np.int64]

# A passage is opened where the way around through open cells is so many times as long, and more.
AROUND, LEAST_AROUND = 3.0, 6


def keep_straits(land: Flags, water: Flags) -> Flags:
    """Land cells with the straits of finer samples.

    Parameters
    ----------
    land : ndarray
        Coarse cells of land, (ny, nx).
    water : ndarray
        Samples of water, k by k in each cell, (k ny, k nx).

    Returns
    -------
    ndarray
        Land cells, (ny, nx).
    """
    split = water.shape[0] // land.shape[0]
    sea = _sea(water)
    share = sea.reshape(land.shape[0], split, land.shape[1], split).mean(axis=(1, 3))
    # A cell of water that is no sea, as of a lake.
    out = land | (share == 0.0)
    out = _opened(out, sea, split)
    return _parted(out, sea, share, split)


def _sea(water: Flags) -> Flags:
    """Samples of the largest water, and of what the rim of the scene cuts."""
    part, count = label(water)
    if count == 0:
        return water.copy()
    size = np.bincount(part.ravel())
    size[0] = 0
    keep = np.zeros(count + 1, dtype=bool)
    keep[int(size.argmax())] = True
    for rim in (part[0], part[-1], part[:, 0], part[:, -1]):
        keep[rim] = True
    keep[0] = False
    return np.asarray(keep[part])


def _opened(land: Flags, sea: Flags, split: int) -> Flags:
    """Open passages of samples through land cells, where the way around is long."""
    out = land.copy()
    block = np.ones((split, split), dtype=bool)
    hidden = sea & np.kron(land, block)
    part, count = label(hidden)
    if count == 0:
        return out
    # Sides of hidden samples on samples in open cells, with those open cells.
    doors = _doors(part, sea & ~hidden, split, land.shape[1])
    doors = doors[np.argsort(doors[:, 0], kind="stable")]
    windows = find_objects(part)
    for mine in np.split(doors, np.flatnonzero(np.diff(doors[:, 0])) + 1):
        groups = _groups(np.unique(mine[:, 2]), land.shape)
        window = windows[int(mine[0, 0]) - 1]
        for first in range(len(groups)):
            for second in range(first + 1, len(groups)):
                _open_between(out, (part, window), mine, (groups[first], groups[second]), split)
    return out


def _doors(part: Index, beyond: Flags, split: int, columns: int) -> Index:
    """Hidden part, flat hidden sample and flat open cell of each side between them, (n, 3)."""
    found = []
    for dy, dx in ((0, 1), (0, -1), (1, 0), (-1, 0)):
        there = np.roll(beyond, (-dy, -dx), axis=(0, 1))
        if dy:
            there[-1 if dy > 0 else 0] = False
        if dx:
            there[:, -1 if dx > 0 else 0] = False
        row, column = np.nonzero((part > 0) & there)
        cell = (row + dy) // split * columns + (column + dx) // split
        found.append(np.stack([part[row, column], row * part.shape[1] + column, cell], axis=1))
    return np.concatenate(found)


def _groups(cells: Index, shape: tuple[int, int]) -> list[Index]:
    """Cells that touch by sides or corners, group by group."""
    flags = np.zeros(shape, dtype=bool)
    flags.ravel()[cells] = True
    part, count = label(flags, np.ones((3, 3)))
    of = part.ravel()[cells]
    return [cells[of == k] for k in range(1, count + 1)]


def _open_between(
    land: Flags,
    hidden: tuple[Index, tuple[slice, slice]],
    doors: Index,
    groups: tuple[Index, Index],
    split: int,
) -> None:
    """Open the cells of a passage, in place, unless there is a way around nearly as short."""
    (part, window), number = hidden, int(doors[0, 0])
    start = np.unique(doors[np.isin(doors[:, 2], groups[0]), 1])
    ends = np.unique(doors[np.isin(doors[:, 2], groups[1]), 1])
    inside = part[window] == number
    (r0, c0), wide = (each.start for each in window), inside.shape[1]

    def local(flat: Index) -> Index:
        row, column = np.divmod(flat, part.shape[1])
        return (row - r0) * wide + column - c0

    steps, parent = _flood(inside, local(start))
    at = local(ends)
    reached = at[steps.ravel()[at] >= 0]
    if not reached.size:
        return
    last = int(reached[steps.ravel()[reached].argmin()])
    length = int(steps.ravel()[last]) / split
    # No further than that: seas need not be searched to their ends.
    most = max(AROUND * length, LEAST_AROUND)
    rows, columns = np.divmod(np.concatenate(groups), land.shape[1])
    near = int(np.ceil(most)) + 1
    box = np.s_[max(rows.min() - near, 0) : rows.max() + near + 1,
                max(columns.min() - near, 0) : columns.max() + near + 1]  # fmt: skip
    free = ~land[box]
    cells = [
        (group // land.shape[1] - box[0].start) * free.shape[1]
        + group % land.shape[1] - box[1].start
        for group in groups
    ]  # fmt: skip
    around, _ = _flood(free, cells[0])
    ways = around.ravel()[cells[1]]
    ways = ways[ways >= 0]
    if ways.size and ways.min() <= most:
        return
    while last >= 0:
        row, column = divmod(last, wide)
        land[(row + r0) // split, (column + c0) // split] = False
        last = int(parent[last])


@njit(cache=True, nogil=True)
def _flood(free: np.ndarray, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Steps from the start through free cells, -1 where there is no way; the cell before each."""
    ny, nx = free.shape
    steps = np.full((ny, nx), -1, np.int64)
    parent = np.full(ny * nx, -1, np.int64)
    queue = np.empty(ny * nx, np.int64)
    head, tail = 0, 0
    for s in start:
        if free[s // nx, s % nx] and steps[s // nx, s % nx] < 0:
            steps[s // nx, s % nx] = 0
            queue[tail] = s
            tail += 1
    while head < tail:
        now = queue[head]
        head += 1
        j, i = now // nx, now % nx
        for k in range(4):
            jj = j + (1 if k == 0 else -1 if k == 1 else 0)
            ii = i + (1 if k == 2 else -1 if k == 3 else 0)
            if 0 <= jj < ny and 0 <= ii < nx and free[jj, ii] and steps[jj, ii] < 0:
                steps[jj, ii] = steps[j, i] + 1
                parent[jj * nx + ii] = now
                queue[tail] = jj * nx + ii
                tail += 1
    return steps, parent


def _parted(land: Flags, sea: Flags, share: NDArray[np.float64], split: int) -> Flags:
    """Shut cells of water that join what no samples join nearby: two sides of a thin spit."""
    out = land.copy()
    # Only a cell that is not all water can hold a spit.
    for row, column in np.argwhere(~land & (share < 1.0)):
        top, left = max(row - 1, 0), max(column - 1, 0)
        window = sea[top * split : (row + 2) * split, left * split : (column + 2) * split]
        part, _ = label(window)
        beside = [
            (row + dy, column + dx)
            for dy, dx in ((0, 1), (1, 0), (0, -1), (-1, 0))
            if 0 <= row + dy < land.shape[0] and 0 <= column + dx < land.shape[1]
        ]
        cells = [(row, column), *(cell for cell in beside if not out[cell])]
        waters = [
            set(np.unique(_block(part, down - top, right - left, split))) - {0}
            for down, right in cells
        ]
        out[row, column] = any(
            not one & two for k, one in enumerate(waters) for two in waters[k + 1 :]
        )
    return out


def _block(values: Index, row: int, column: int, split: int) -> Index:
    return values[row * split : (row + 1) * split, column * split : (column + 1) * split]
