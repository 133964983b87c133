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

from floeflow.core.grids import Grid
from floeflow.core.near import pushes, thin
from floeflow.core.period import Period, tree_of
from floeflow.core.period import apart as distances
from floeflow.packings.points import hilbert_key, on_ice
from floeflow.packings.shore import Shore

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

# Coast is needed as far as ice may drift along it within a scene (m).
REACH = 2.0e5
# Coast elements keep this distance, in mean radii: gaps between them stay under a mean diameter.
COAST_SPACING = 0.9
# No disc is larger than this many mean radii.
MOST_RADII = 1.5
# Discs are spread until they could fill this share of the ice: random packings of equal discs jam
# near 0.84 (O'Hern et al. 2003).
FILL = 0.84
SPREAD_ROUNDS, SPREAD_STEP = 100, 0.25
# Each round of growth closes half of what gaps are left.
ROUNDS = 40
# Taken off every radius at the end, so that round-off makes no overlap.
ROUND_OFF = 1.0e-12
# A disc in water too narrow for it keeps this share of its mean radius and reaches over the coast:
# smaller ones would rule the time step.
SLIMMEST = 0.25
# Corners of the outline of a disc.
CORNERS = 24

_SIDES = np.array([[0, 1, 0], [1, 1, 1], [0, 1, 0]], dtype=bool)


def coast_points(grid: Grid, ice: Flags, land: Flags, radius: Array) -> tuple[Array, float]:
    """Centres of the coast elements.

    Land cells with a side on water that the ice can reach; where cells are larger than elements,
    their sub-cells; where they are much smaller, a thinned choice.

    Parameters
    ----------
    grid : Grid
        The mask grid.
    ice, land : ndarray
        Cells with ice and cells of land, (ny, nx).
    radius : ndarray
        Mean radius of the mobile elements there (m), (ny, nx).

    Returns
    -------
    points : ndarray
        (n, 2) in metres.
    side : float
        Side of the squares (m) in whose centres they stand.
    """
    steps = int(np.ceil(REACH / grid.spacing))
    reached = binary_dilation(ice, _SIDES, iterations=steps, mask=~land) if steps else ice
    shore = land & binary_dilation(reached, _SIDES)
    if not shore.any():
        return np.empty((0, 2)), grid.spacing
    split = max(1, round(grid.spacing / (2.0 * float(radius[shore].min()))))
    block = np.ones((split, split), dtype=bool)
    water, solid = np.kron(reached, block), np.kron(land, block)
    row, column = np.nonzero(solid & binary_dilation(water, _SIDES))
    side = grid.spacing / split
    points = np.stack([grid.x_min + side * (column + 0.5), grid.y_min + side * (row + 0.5)], axis=1)
    distance = COAST_SPACING * radius[grid.cell_of(points[:, 0], points[:, 1])]
    if float(distance.max()) > side:
        priority = np.argsort(np.argsort(_curve(grid, points), kind="stable"))
        points = points[thin(points, priority, np.maximum(distance, side * (1.0 - ROUND_OFF)))]
    return points, side


def _curve(grid: Grid, points: Array) -> NDArray[np.int64]:
    size = grid.spacing * max(grid.shape)
    return hilbert_key(points[:, 0], points[:, 1], grid.x_min, grid.y_min, size)


def spread(
    grid: Grid,
    ice: Flags,
    points: Array,
    coast: tuple[Array, float | Array],
    target: Array,
    shore: Shore,
) -> Array:
    """Push discs apart that would overlap at their target radii, so that all can grow.

    In each round every pair that overlaps moves apart by a share of its overlap, a mobile disc at
    the coast, a line or a plane alone. A disc that would leave the ice stays.

    Parameters
    ----------
    grid, ice
        Mask grid and its cells with ice.
    points : ndarray
        Mobile centres (m), (n, 2).
    coast : tuple of ndarray
        Fixed centres (m), (k, 2), and their radii (m).
    target : ndarray
        Target radii of the mobile discs (m), (n,).
    shore : Shore
        Lines and planes to keep clear of.

    Returns
    -------
    ndarray
        Mobile centres (m), (n, 2).
    """
    count = len(points)
    radius = np.concatenate([target, np.broadcast_to(coast[1], len(coast[0]))])
    everywhere = np.concatenate([points, coast[0]])
    for _ in range(SPREAD_ROUNDS):
        moves, deepest = pushes(everywhere, radius, count, SPREAD_STEP)
        inland, over = shore.pushes(everywhere[:count], target, 2.0 * SPREAD_STEP)
        if deepest == over == 0.0:
            break
        moved = everywhere[:count] + moves + inland
        stays = on_ice(grid, ice, moved)
        everywhere[:count][stays] = moved[stays]
    return everywhere[:count]


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


def off_coast(points: Array, largest: Array, mean: Array, shore: Shore) -> Array:
    """Limits of radii with which discs end at the coast and at walls, where there is room.

    Parameters
    ----------
    points : ndarray
        Centres (m), (n, 2).
    largest, mean : ndarray
        Limits so far, and the radii of discs of the elements' area (m), (n,).
    shore : Shore
        Lines and planes.

    Returns
    -------
    ndarray
        m, (n,); never below the share `SLIMMEST` of the mean radius.
    """
    room = np.maximum(shore.clearance(points), SLIMMEST * mean)
    return np.minimum(largest, room)


def coast_at_ice(points: Array, radius: Array, mobile: int, largest: Array) -> Array:
    """Radii with which the coast's discs reach the ice beside them, where that is near enough.

    Ice ends at the coast's line and coast elements stand behind it. They touch the ice, so that it
    can freeze to them; they may overlap each other, as they never move.

    Parameters
    ----------
    points, radius : ndarray
        Discs (m), (n, 2) and (n,); those from row `mobile` on are the coast's.
    mobile : int
        How many are ice.
    largest : ndarray
        Upper limits of the coast's radii (m), (n - mobile,).

    Returns
    -------
    ndarray
        m, (n,); those of the ice are as they were.
    """
    out = radius.copy()
    if mobile in (0, len(points)):
        return out
    ice, coast = cKDTree(points[:mobile]), cKDTree(points[mobile:])
    reach = float(largest.max() + radius[:mobile].max())
    near = coast.sparse_distance_matrix(ice, reach, output_type="ndarray")
    room = np.full(len(points) - mobile, np.inf)
    np.minimum.at(room, near["i"], near["v"] - radius[near["j"]])
    touching = room <= largest
    grown = np.maximum(room * (1.0 - ROUND_OFF), out[mobile:])
    out[mobile:] = np.where(touching, grown, out[mobile:])
    return out


def apart(points: Array, radius: Array, mobile: int, period: Period | None = None) -> Array:
    """Radii of overlapping discs shortened until none overlaps, each by half its deepest overlap.

    Parameters
    ----------
    points, radius : ndarray
        Discs (m), (n, 2) and (n,); those from row `mobile` on are fixed and keep their radii.
    mobile : int
        How many can shrink.
    period : tuple of float, optional
        Bounds (m) of a rectangle that repeats itself (`floeflow.core.period`).

    Returns
    -------
    ndarray
        Radii (m), (n,).
    """
    tree = tree_of(points, period)
    pairs = tree.query_pairs(2.0 * float(radius.max()), output_type="ndarray")
    pairs = pairs[pairs[:, 0] < mobile]
    first, second = pairs.T
    overlap = radius[first] + radius[second] - distances(points, first, second, period)
    less = np.zeros(len(radius))
    share = np.where(second < mobile, 0.5, 1.0)
    np.maximum.at(less, first, share * overlap)
    np.maximum.at(less, second, np.where(second < mobile, 0.5 * overlap, 0.0))
    shrunk = np.maximum(radius - less, 0.0)
    shrunk[:mobile] *= 1.0 - ROUND_OFF
    return shrunk


def outlines(places: Array, radius: Array) -> Array:
    """Corners (m), (n, 24, 2), anticlockwise, of regular polygons of the discs' areas.

    Parameters
    ----------
    places : ndarray
        Centres (m), (n, 2).
    radius : ndarray
        m, (n,).

    Returns
    -------
    ndarray
        The polygons.
    """
    angle = 2.0 * np.pi * (np.arange(CORNERS) + 0.5) / CORNERS
    share = np.sqrt(2.0 * np.pi / (CORNERS * np.sin(2.0 * np.pi / CORNERS)))
    round_ = share * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return np.asarray(places[:, None] + radius[:, None, None] * round_)
