# SPDX-License-Identifier: GPL-2.0-or-later
"""Whole floes as discs of given sizes, from open drift ice to jammed packs (generator dense).

The number of floes follows the concentration; water stays open between them. Discs are thrown,
relaxed and pushed apart, and then compacted by the element model, which the caller hands in.
"""

from __future__ import annotations

import logging
from collections.abc import Callable

import numpy as np
import shapely
import xarray as xr
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from floeflow.core.grids import Grid
from floeflow.core.period import Period, images, period_of
from floeflow.packings import discs, points
from floeflow.packings.elements import Elements, grid_of, hilbert_order, ordered
from floeflow.packings.lines import diagram_around, disc_lines
from floeflow.packings.shore import shore_of
from floeflow.scene.blocks import Discs, Packing
from floeflow.state.bonds import Arrays

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Index = NDArray[np.int64]

log = logging.getLogger(__name__)

# Discs whose gap is within this share of their radii's sum are neighbours.
NEIGHBOUR = 1.0
RELAXATIONS = 10
# What takes places, radii, fixed discs with their radii, and the largest overlap left, and returns
# places: `floeflow.coupling.compaction.compactor`.
Compactor = Callable[[Array, Array, Array, Array, float], Array]


def disc_sizes(count: int, keys: Discs, generator: np.random.Generator) -> Array:
    """Radii over their root mean square, (count,).

    Parameters
    ----------
    count : int
        How many discs.
    keys : Discs
        Which distribution: all equal; halves of two sizes of a ratio; lognormal; a power law
        n(r) ~ r^-exponent; the last two between cut-offs.
    generator : numpy.random.Generator
        The only source of chance.

    Returns
    -------
    ndarray
        1, (count,), in random order.
    """
    low, high = keys.smallest, keys.largest
    if keys.sizes == "equal":
        radius = np.ones(count)
    elif keys.sizes == "bidisperse":
        radius = np.where(generator.permutation(count) < count // 2, keys.ratio, 1.0)
    elif keys.sizes == "lognormal":
        radius = np.exp(keys.spread * generator.standard_normal(count))
        while (off := (radius < low) | (radius > high)).any():
            radius[off] = np.exp(keys.spread * generator.standard_normal(int(off.sum())))
    else:
        at, power = generator.random(count), 1.0 - keys.exponent
        if abs(power) < 1e-9:
            radius = low * (high / low) ** at
        else:
            radius = (low**power + at * (high**power - low**power)) ** (1.0 / power)
    return np.asarray(radius / np.sqrt((radius**2).mean()))


def dense_discs(
    mask: xr.Dataset,
    packing: Packing,
    seed: int,
    coast_effect: bool,
    compact: Compactor,
    walls: Arrays | None = None,
) -> Elements:
    """Whole floes over the ice of a mask.

    Parameters
    ----------
    mask : xarray.Dataset
        Output of the mask stage.
    packing, seed, coast_effect, walls
        As in `floeflow.packings.packing.make_packing`.
    compact : callable
        Parts discs that overlap.

    Returns
    -------
    Elements
        Each fully ice-covered, of its disc's area where the concentration is no higher than the
        largest share that discs fill; where it is higher a disc stands for the ice in the gaps too.
    """
    grid, keys = grid_of(mask), packing.discs
    land, siconc = mask["land"].values > 0, mask["siconc"].values
    ice = siconc > 0
    generator = np.random.Generator(np.random.PCG64(seed))
    cover = np.minimum(siconc, keys.fill)
    own = disc_sizes(packing.elements, keys, generator)
    radius = own * np.sqrt(cover.sum() * grid.spacing**2 / packing.elements / np.pi)
    size = np.where(ice, np.sqrt(cover.max() / np.where(ice, cover, 1.0)), 1.0)
    places, radius = _thrown(grid, ice, size, radius, generator)
    coast, side = np.empty((0, 2)), 0.0
    if coast_effect:
        coast, side = discs.coast_points(grid, ice, land, np.full(grid.shape, radius.mean()))
        coast = ordered(grid, coast)
    clear = np.full(len(coast), 0.5 * side)
    shore = shore_of(grid, land, walls, float(radius.max()))
    places = discs.spread(grid, ice, places, (coast, clear), radius, shore)
    places = shore.before(places, radius)
    places = compact(places, radius, coast, clear, keys.overlap)
    period = period_of(mask.attrs)
    places = _on_grid(grid, places)
    order = hilbert_order(grid, places)
    places, radius = places[order], radius[order]
    everywhere = np.concatenate([places, coast])
    shrunk = discs.apart(everywhere, np.concatenate([radius, clear]), len(places), period)
    log.info(
        "discs fill %.4f of the ice cells' area; overlaps took %.2g of it",
        np.pi * (shrunk[: len(places)] ** 2).sum() / (ice.sum() * grid.spacing**2),
        1.0 - (shrunk[: len(places)] ** 2).sum() / (radius**2).sum(),
    )
    return _elements(mask, everywhere, shrunk, len(places))


def _thrown(
    grid: Grid, ice: Flags, size: Array, radius: Array, generator: np.random.Generator
) -> tuple[Array, Array]:
    """Blue noise as dense as the ice, relaxed; which place has which radius."""
    own = radius / np.sqrt((radius**2).mean())
    places, found = points.blue_noise(grid, ice, size, own, generator)
    radius = np.sqrt((radius**2).mean()) * found
    marks = points.samples(grid, ice, len(radius), size)
    places = points.lloyd(grid, ice, places, marks, RELAXATIONS, radius**2)
    return places, radius


def _on_grid(grid: Grid, places: Array) -> Array:
    low = np.array([grid.x_edges[0], grid.y_edges[0]])
    high = np.array([grid.x_edges[-1], grid.y_edges[-1]])
    return np.clip(places, low, high)


def _elements(mask: xr.Dataset, places: Array, radius: Array, count: int) -> Elements:
    grid, siconc = grid_of(mask), mask["siconc"].values
    area, sithick = mask["cell_area"].values, mask["sithick"].values
    x, y = places[:count].T
    at = _nearest_ice(grid, siconc > 0, x, y)
    true = np.pi * radius[:count] ** 2 * (area / grid.spacing**2)[at]
    # Where the ice is denser than discs can be they stand for what lies between them too.
    wanted = float((siconc * area).sum())
    stands = true * (wanted / true.sum())
    thick = sithick[at]
    thick = thick * (float((siconc * sithick * area).sum()) / float((stands * thick).sum()))
    lo, hi, ends = _lines(places, radius, count, period_of(mask.attrs))
    return Elements(
        places,
        radius,
        area=stands,
        ice_fraction=np.ones(count),
        ice_volume=thick,
        polygons=np.asarray(shapely.polygons(discs.outlines(places[:count], radius[:count]))),
        lo=lo,
        hi=hi,
        ends=ends,
        correction=0.0,
        concentration=siconc[at],
    )


def _lines(
    places: Array, radius: Array, count: int, period: Period | None
) -> tuple[Index, Index, Array]:
    """Lines between neighbours, in the order of their rows; across sides at the place of the lower.

    The first ``count`` discs are ice. A pair that meets in two images has the line of one.
    """
    copies, of = images(places, 2.0 * (1.0 + NEIGHBOUR) * float(radius.max()), period)
    every, wide = np.concatenate([places, copies]), np.concatenate([radius, radius[of]])
    own = np.concatenate([np.arange(len(places)), of])
    diagram = diagram_around(every, wide)
    reach = wide[diagram.lo] + wide[diagram.hi]
    gap = np.hypot(*(every[diagram.hi] - every[diagram.lo]).T) - reach
    first, second = own[diagram.lo], own[diagram.hi]
    chosen = (first < count) & (second < count) & (gap < NEIGHBOUR * reach)
    # Each pair across a side is there from both sides, and once more among copies.
    chosen &= (diagram.lo < len(places)) & (first < second)
    lo, hi, ends = disc_lines(diagram, every, wide, chosen)
    hi = own[hi]
    _, once = np.unique(lo * len(places) + hi, return_index=True)
    return lo[once], hi[once], ends[once]


def _nearest_ice(grid: Grid, ice: Flags, x: Array, y: Array) -> tuple[NDArray[np.int64], ...]:
    """Row and column of the ice cell in which a disc lies, or of the nearest one."""
    _, (rows, columns) = distance_transform_edt(~ice, return_indices=True)
    row, column = grid.cell_of(x, y)
    return rows[row, column], columns[row, column]
