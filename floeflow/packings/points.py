# SPDX-License-Identifier: GPL-2.0-or-later
"""Points over the ice: seeded blue noise, Lloyd relaxation, order along a Hilbert curve.

All on samples: each ice cell of the mask is divided into equal sub-cells, whose centres stand for
its area. With some thirty samples an element that is as good as clipped cells and much faster.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label

from floeflow.core.grids import Grid
from floeflow.core.near import owners, thin

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Flags = NDArray[np.bool_]

SAMPLES_PER_ELEMENT = 32
CANDIDATES_PER_ELEMENT = 4
# Share of the lack in a cell's area by which its weight grows in a step.
ADJUST = 0.4
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

    Returns
    -------
    ndarray
        Integer from 0 to 2^32 - 1, (n,).
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


@dataclass(frozen=True)
class Samples:
    """Places that stand for the area of the ice.

    Parameters
    ----------
    points : ndarray
        Centres of sub-cells (m), (m, 2), cell after cell.
    cell : ndarray
        Flat index of each one's mask cell, (m,).
    area : ndarray
        Area of each sub-cell (m2), (m,).
    pull : ndarray
        Weight of each in a relaxation, (m,): area over the fourth power of the relative size, with
        which cells grow as that size (Du, Faber and Gunzburger 1999,
        doi 10.1137/S0036144599352836).
    """

    points: Array
    cell: Index
    area: Array
    pull: Array


def samples(grid: Grid, ice: Flags, elements: int, size: Array) -> Samples:
    """Sub-cell centres of the ice cells, as many an element everywhere.

    Parameters
    ----------
    grid : Grid
        The mask grid.
    ice : ndarray
        Cells with ice, (ny, nx).
    elements : int
        How many elements there will be.
    size : ndarray
        Their relative size, (ny, nx).

    Returns
    -------
    Samples
        Places (m), cell, area (m2) and weight of each.
    """
    cell = np.flatnonzero(ice)
    density = size.ravel()[cell] ** -2.0
    wanted = SAMPLES_PER_ELEMENT * elements * density / density.sum()
    per_side = np.maximum(2, np.ceil(np.sqrt(wanted) - 1e-9)).astype(np.int64)
    row, column = np.divmod(cell, grid.x.size)
    start = np.concatenate([[0], np.cumsum(per_side**2)])
    of = np.repeat(np.arange(cell.size), per_side**2)
    down, right = np.divmod(np.arange(start[-1]) - start[of], per_side[of])
    x, y = (
        axis[place][of] + ((off + 0.5) / per_side[of] - 0.5) * grid.spacing
        for axis, place, off in ((grid.x, column, right), (grid.y, row, down))
    )
    area = (grid.spacing / per_side[of]) ** 2
    return Samples(np.stack([x, y], axis=1), cell[of], area, area * density[of] ** 2)


def blue_noise(
    grid: Grid, ice: Flags, size: Array, factor: Array, generator: np.random.Generator
) -> tuple[Array, Array]:
    """Poisson-disc points over the ice, exactly as many as asked for.

    Parameters
    ----------
    grid : Grid
        The mask grid.
    ice : ndarray
        Cells with ice, (ny, nx).
    size : ndarray
        Relative size of the elements, (ny, nx).
    factor : ndarray
        Each element's own size over that of its place, (n,); as many points are wanted.
    generator : numpy.random.Generator
        The only source of chance.

    Returns
    -------
    points, factor : ndarray
        (n, 2) in metres, and (n,): which point has which factor.
    """
    cells, elements = np.flatnonzero(ice), len(factor)
    count = CANDIDATES_PER_ELEMENT * elements
    density = size.ravel()[cells] ** -2.0
    even = bool(np.all(density == density[0]))
    picked = generator.choice(cells, count, p=None if even else density / density.sum())
    row, column = np.divmod(picked, grid.x.size)
    jitter = generator.random((count, 2)) * grid.spacing
    points = np.stack([grid.x_edges[column], grid.y_edges[row]], axis=1) + jitter
    own = np.resize(factor, count)
    priority = generator.permutation(count)
    area = grid.spacing**2 * density.sum() / elements
    reach = np.sqrt(POISSON_DENSITY * area) * size.ravel()[picked] * own
    chosen = thin(points, priority, reach)
    while chosen.sum() < elements:
        reach *= 0.96
        chosen = thin(points, priority, reach)
    found = np.flatnonzero(chosen)
    # The last thrown go; the relaxation closes their gaps.
    kept = np.sort(found[np.argsort(priority[found])][:elements])
    # Small ones find room more easily: the wanted sizes go to the places by rank.
    sizes = np.empty(elements)
    sizes[np.argsort(own[kept], kind="stable")] = np.sort(factor)
    return points[kept], sizes


def on_ice(grid: Grid, ice: Flags, points: Array) -> Flags:
    """Whether points lie in cells with ice; none off the grid does.

    Parameters
    ----------
    grid : Grid
        Cells of the mask.
    ice : Flags
        Cells with ice, (ny, nx).
    points : ndarray
        m, (n, 2).

    Returns
    -------
    Flags
        (n,), bool.
    """
    x, y = points[:, 0], points[:, 1]
    row, column = grid.cell_of(x, y)
    inside = (x >= grid.x_edges[0]) & (x <= grid.x_edges[-1])
    inside &= (y >= grid.y_edges[0]) & (y <= grid.y_edges[-1])
    return np.asarray(ice[row, column] & inside)


def lloyd(
    grid: Grid,
    ice: Flags,
    points: Array,
    marks: Samples,
    steps: int,
    weight: Array | None = None,
) -> Array:
    """Move points to the centroids of their Voronoi cells, clipped to the ice (Lloyd 1982).

    A centroid off the ice (of a cell bent around land) goes to the cell's nearest sample.

    Parameters
    ----------
    grid, ice
        Mask grid and its ice cells.
    points : ndarray
        (n, 2) in metres.
    marks : Samples
        Samples of the ice.
    steps : int
        Relaxations.
    weight : ndarray, optional
        Squared radii (m2), (n,): cells of the power diagram instead, whose weights are adjusted in
        each step so that areas go as the squared radii (Aurenhammer, Hoffmann and Aronov 1998,
        doi 10.1007/PL00009187).

    Returns
    -------
    ndarray
        m, (n, 2).
    """
    points = points.copy()
    wanted = np.zeros(0) if weight is None else weight * (marks.area.sum() / weight.sum())
    for _ in range(steps):
        owner = owners(points, marks.points, weight)
        if weight is not None:
            lack = wanted - np.bincount(owner, weights=marks.area, minlength=len(points))
            weight = np.maximum(weight + ADJUST / np.pi * lack, 0.0)
        total = np.bincount(owner, weights=marks.pull, minlength=len(points))
        has = total > 0
        for axis in (0, 1):
            amount = marks.pull * marks.points[:, axis]
            moved = np.bincount(owner, weights=amount, minlength=len(points))
            points[has, axis] = moved[has] / total[has]
        points = _back_on_ice(grid, ice, points, marks.points, owner)
    return points


def cell_areas(points: Array, marks: Samples, weight: Array | None = None) -> Array:
    """Area (m2) of the samples that belong to each point (n, 2), (n,).

    Parameters
    ----------
    points : ndarray
        m, (n, 2).
    marks : Samples
        Points that stand for area (m2) of ice.
    weight : ndarray, optional
        Of the power diagram (m2), (n,); without it each sample belongs to the nearest point.

    Returns
    -------
    ndarray
        m2.
    """
    owner = owners(points, marks.points, weight)
    return np.bincount(owner, weights=marks.area, minlength=len(points)).astype(float)


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
    grid: Grid, ice: Flags, points: Array, marks: Samples, smallest: Array
) -> Array:
    """One more point for each separate patch of ice that has none and is large enough.

    Parameters
    ----------
    grid, ice
        Mask grid and its ice cells; patches are joined through the sides of cells.
    points : ndarray
        Points so far, (n, 2).
    marks : Samples
        Samples of the ice.
    smallest : ndarray
        Patches smaller than this (m2, by place, (ny, nx)) get none; their area goes to the nearest
        element.

    Returns
    -------
    ndarray
        Points to add, (k, 2).
    """
    patch, count = label(ice)
    row, column = grid.cell_of(points[:, 0], points[:, 1])
    held = np.bincount(patch[row, column], minlength=count + 1)
    room = np.bincount(patch.ravel(), 1.0 / smallest.ravel(), minlength=count + 1)
    lacking = (held == 0) & (room * grid.spacing**2 >= 1.0)
    lacking[0] = False
    of_mark = patch.ravel()[marks.cell]
    rows = np.flatnonzero(lacking[of_mark])
    rows = rows[np.argsort(of_mark[rows], kind="stable")]
    added = []
    for mine in np.split(rows, np.flatnonzero(np.diff(of_mark[rows])) + 1):
        if len(mine):
            off = marks.points[mine] - marks.points[mine].mean(axis=0)
            added.append(marks.points[mine[np.argmin((off**2).sum(axis=1))]])
    return np.array(added).reshape(-1, 2)
