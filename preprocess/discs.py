# SPDX-License-Identifier: GPL-2.0-or-later
"""Coast elements, and radii with which no two discs overlap.

Coast elements stand in the outermost land cells along all water that the ice can reach in a scene.
Radii grow from half the distance to the nearest neighbour until each disc touches another one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation
from scipy.spatial import cKDTree

from floeflow.preprocess.grids import Grid
from floeflow.preprocess.points import hilbert_key, thin

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

# Coast is needed as far as ice may drift along it within a scene (m).
REACH = 2.0e5
# Coast elements keep this distance, in mean radii: gaps between them stay under a mean diameter.
COAST_SPACING = 0.9
# No disc is larger than this many mean radii.
MOST_RADII = 1.5
# Each round of growth closes half of what gaps are left.
ROUNDS = 40
# Taken off every radius at the end, so that round-off makes no overlap.
ROUND_OFF = 1.0e-12

_SIDES = np.array([[0, 1, 0], [1, 1, 1], [0, 1, 0]], dtype=bool)


def coast_points(grid: Grid, ice: Flags, land: Flags, mean_radius: float) -> tuple[Array, float]:
    """Centres of the coast elements.

    Land cells with a side on water that the ice can reach; where cells are larger than elements,
    their sub-cells; where they are much smaller, a thinned choice.

    Parameters
    ----------
    grid : Grid
        The mask grid.
    ice, land : ndarray
        Cells with ice and cells of land, (ny, nx).
    mean_radius : float
        Of the mobile elements (m).

    Returns
    -------
    points : ndarray
        (n, 2) in metres.
    side : float
        Side of the squares (m) in whose centres they stand.
    """
    steps = int(np.ceil(REACH / grid.spacing))
    reached = binary_dilation(ice, _SIDES, iterations=steps, mask=~land) if steps else ice
    split = max(1, round(grid.spacing / (2.0 * mean_radius)))
    block = np.ones((split, split), dtype=bool)
    water, solid = np.kron(reached, block), np.kron(land, block)
    row, column = np.nonzero(solid & binary_dilation(water, _SIDES))
    side = grid.spacing / split
    points = np.stack(
        [grid.x_min + side * (column + 0.5), grid.y_min + side * (row + 0.5)], axis=1
    )
    distance = COAST_SPACING * mean_radius
    if len(points) and distance > side:
        priority = np.argsort(np.argsort(_curve(grid, points), kind="stable"))
        points = points[thin(points, priority, distance)]
    return points, side


def _curve(grid: Grid, points: Array) -> NDArray[np.int64]:
    size = grid.spacing * max(grid.shape)
    return hilbert_key(points[:, 0], points[:, 1], grid.x_min, grid.y_min, size)


def radii(points: Array, largest: Array) -> Array:
    """Radii of discs that touch but do not overlap: r_i + r_j <= d_ij for every pair.

    Parameters
    ----------
    points : ndarray
        Centres (m), (n, 2), all different.
    largest : ndarray
        Upper limit of each radius (m), (n,).

    Returns
    -------
    ndarray
        Radii (m), (n,). Each disc touches another one, to round-off, or is as large as allowed.
    """
    if len(points) < 2:
        return largest * (1.0 - ROUND_OFF)
    tree = cKDTree(points)
    nearest = tree.query(points, k=2)[0][:, 1]
    radius = np.minimum(0.5 * nearest, largest)
    pairs = tree.query_pairs(2.0 * float(largest.max()), output_type="ndarray")
    first, second = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))].T
    distance = np.hypot(*(points[first] - points[second]).T)
    for _ in range(ROUNDS):
        gap = distance - radius[first] - radius[second]
        room = 2.0 * (largest - radius)
        np.minimum.at(room, first, gap)
        np.minimum.at(room, second, gap)
        radius += 0.5 * np.maximum(room, 0.0)
    return radius * (1.0 - ROUND_OFF)
