# SPDX-License-Identifier: GPL-2.0-or-later
"""Points over the ice: seeded blue noise, Lloyd relaxation, order along a Hilbert curve.

All on samples: each ice cell of the mask is divided into equal sub-cells, whose centres stand for
its area. With some thirty samples an element that is as good as clipped cells and much faster.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label
from scipy.spatial import cKDTree

from floeflow.core.grids import Grid

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Flags = NDArray[np.bool_]

SAMPLES_PER_ELEMENT = 32
CANDIDATES_PER_ELEMENT = 4
# Points of a full Poisson-disc set per (distance squared / area); measured, only a first guess.
POISSON_DENSITY = 0.66


def hilbert_key(x: Array, y: Array, x_min: float, y_min: float, side: float) -> Index:
    """Place along a Hilbert curve of 2^16 by 2^16 cells over a square.

    Skilling's transform in two dimensions: quadrant by quadrant from the coarsest.

    Parameters
    ----------
    x, y : ndarray
        Points (n,).
    x_min, y_min, side : float
        Lower left corner and side of the square.
    """
    bits = 16
    top = 2**bits - 1
    a = np.clip((x - x_min) / side * 2**bits, 0, top).astype(np.int64)
    b = np.clip((y - y_min) / side * 2**bits, 0, top).astype(np.int64)
    key = np.zeros(a.shape, dtype=np.int64)
    for level in range(bits - 1, -1, -1):
        half = 1 << level
        right, upper = (a & half) > 0, (b & half) > 0
        key += half * half * ((3 * right) ^ upper)
        flip = right & ~upper
        a, b = np.where(flip, top - a, a), np.where(flip, top - b, b)
        a, b = np.where(upper, a, b), np.where(upper, b, a)
    return key


def samples(grid: Grid, ice: Flags, per_side: int) -> tuple[Array, Index]:
    """Sub-cell centres of the ice cells.

    Parameters
    ----------
    grid : Grid
        The mask grid.
    ice : ndarray
        Cells with ice, (ny, nx).
    per_side : int
        Sub-cells along the side of a cell.

    Returns
    -------
    points : ndarray
        (n, 2) in metres, cell after cell.
    cell : ndarray
        Flat index of each point's cell, (n,).
    """
    cell = np.flatnonzero(ice)
    row, column = np.divmod(cell, grid.x.size)
    offset = ((np.arange(per_side) + 0.5) / per_side - 0.5) * grid.spacing
    dy, dx = (part.ravel() for part in np.meshgrid(offset, offset, indexing="ij"))
    points = np.stack(
        [(grid.x[column][:, None] + dx).ravel(), (grid.y[row][:, None] + dy).ravel()], axis=1
    )
    return points, np.repeat(cell, per_side**2)


def samples_per_side(cells: int, elements: int) -> int:
    """Sub-cells along the side of an ice cell that give each element enough samples."""
    return max(2, int(np.ceil(np.sqrt(SAMPLES_PER_ELEMENT * elements / cells))))


def thin(points: Array, priority: Index, distance: float) -> Flags:
    """Choose a largest set of points no two of which are nearer than a distance.

    A point stays where it ranks before all its neighbours that are still undecided (Luby 1986);
    its neighbours go. That equals throwing the points one after the other by rank.

    Parameters
    ----------
    points : ndarray
        (n, 2).
    priority : ndarray
        A permutation of 0..n-1; lower ranks win.
    distance : float
        Same unit as the points.
    """
    count = len(points)
    chosen, undecided = np.zeros(count, dtype=bool), np.ones(count, dtype=bool)
    pairs = cKDTree(points).query_pairs(distance, output_type="ndarray")
    first, second = pairs[:, 0], pairs[:, 1]
    while undecided.any():
        best = np.full(count, count)
        np.minimum.at(best, first, priority[second])
        np.minimum.at(best, second, priority[first])
        new = undecided & (priority < best)
        chosen |= new
        undecided &= ~new
        undecided[second[new[first]]] = False
        undecided[first[new[second]]] = False
        keep = undecided[first] & undecided[second]
        first, second = first[keep], second[keep]
    return chosen


def blue_noise(grid: Grid, ice: Flags, elements: int, generator: np.random.Generator) -> Array:
    """Poisson-disc points over the ice, exactly as many as asked for.

    Parameters
    ----------
    grid : Grid
        The mask grid.
    ice : ndarray
        Cells with ice, (ny, nx).
    elements : int
        How many; 1 or more.
    generator : numpy.random.Generator
        The only source of chance.

    Returns
    -------
    ndarray
        (elements, 2) in metres.
    """
    cells = np.flatnonzero(ice)
    count = CANDIDATES_PER_ELEMENT * elements
    row, column = np.divmod(generator.choice(cells, count), grid.x.size)
    jitter = generator.random((count, 2)) * grid.spacing
    points = np.stack([grid.x_edges[column], grid.y_edges[row]], axis=1) + jitter
    priority = generator.permutation(count)
    distance = np.sqrt(POISSON_DENSITY * cells.size * grid.spacing**2 / elements)
    chosen = thin(points, priority, distance)
    while chosen.sum() < elements:
        distance *= 0.96
        chosen = thin(points, priority, distance)
    found = np.flatnonzero(chosen)
    # The last thrown go; the relaxation closes their gaps.
    kept = found[np.argsort(priority[found])][:elements]
    return points[np.sort(kept)]


def on_ice(grid: Grid, ice: Flags, points: Array) -> Flags:
    """Whether points lie in cells with ice; none off the grid does."""
    x, y = points[:, 0], points[:, 1]
    row, column = grid.cell_of(x, y)
    inside = (x >= grid.x_edges[0]) & (x <= grid.x_edges[-1])
    inside &= (y >= grid.y_edges[0]) & (y <= grid.y_edges[-1])
    return np.asarray(ice[row, column] & inside)


def lloyd(grid: Grid, ice: Flags, points: Array, marks: Array, steps: int) -> Array:
    """Move points to the centroids of their Voronoi cells, clipped to the ice (Lloyd 1982).

    A centroid off the ice (of a cell bent around land) goes to the cell's nearest sample.

    Parameters
    ----------
    grid, ice
        Mask grid and its ice cells.
    points : ndarray
        (n, 2) in metres.
    marks : ndarray
        Samples of the ice, (m, 2).
    steps : int
        Relaxations.
    """
    points = points.copy()
    for _ in range(steps):
        _, owner = cKDTree(points).query(marks)
        count = np.bincount(owner, minlength=len(points))
        has = count > 0
        for axis in (0, 1):
            total = np.bincount(owner, weights=marks[:, axis], minlength=len(points))
            points[has, axis] = total[has] / count[has]
        points = _back_on_ice(grid, ice, points, marks, owner)
    return points


def shares(points: Array, marks: Array) -> Array:
    """Share of the samples (m, 2) that is nearest to each point (n, 2), (n,)."""
    _, owner = cKDTree(points).query(marks)
    return np.bincount(owner, minlength=len(points)) / len(marks)


def _back_on_ice(grid: Grid, ice: Flags, points: Array, marks: Array, owner: Index) -> Array:
    off = ~on_ice(grid, ice, points)
    mine = np.flatnonzero(off[owner])
    if mine.size:
        distance = np.hypot(*(marks[mine] - points[owner[mine]]).T)
        order = np.lexsort((mine, distance, owner[mine]))
        owners, first = np.unique(owner[mine][order], return_index=True)
        points[owners] = marks[mine[order[first]]]
    return points


def islands_without(
    grid: Grid, ice: Flags, points: Array, marks: Array, mark_cells: Index, smallest: float
) -> Array:
    """One more point for each separate patch of ice that has none and is large enough.

    Parameters
    ----------
    grid, ice
        Mask grid and its ice cells; patches are joined through the sides of cells.
    points : ndarray
        Points so far, (n, 2).
    marks, mark_cells : ndarray
        Samples of the ice and their flat cells.
    smallest : float
        Patches smaller than this (m2) get none; their area goes to the nearest element.

    Returns
    -------
    ndarray
        Points to add, (k, 2).
    """
    patch, count = label(ice)
    row, column = grid.cell_of(points[:, 0], points[:, 1])
    held = np.bincount(patch[row, column], minlength=count + 1)
    size = np.bincount(patch.ravel(), minlength=count + 1) * grid.spacing**2
    lacking = np.flatnonzero((held == 0) & (size >= smallest))
    of_mark = patch.ravel()[mark_cells]
    added = []
    for number in lacking[lacking > 0]:
        mine = marks[of_mark == number]
        off = mine - mine.mean(axis=0)
        added.append(mine[np.argmin((off**2).sum(axis=1))])
    return np.array(added).reshape(-1, 2)
