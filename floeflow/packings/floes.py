# SPDX-License-Identifier: GPL-2.0-or-later
"""Floes of a labelled image as clusters of discs (generator floes).

Each floe is filled with discs that stay inside its outline, so that those of touching floes do not
overlap. The power diagram of a floe's discs divides its pixels among them: areas add up to the
floe's. Places are moved a little until centroid and second moments of the cluster are the floe's.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import shapely
import xarray as xr
from numpy.typing import NDArray
from scipy.ndimage import find_objects, label

from floeflow.core.grids import Grid, overlaps
from floeflow.core.near import owners, pushes
from floeflow.packings import discs, points, tessellation
from floeflow.packings.elements import Elements, grid_of, hilbert_order, ordered
from floeflow.packings.moments import cluster_moments, match_areas, match_moments
from floeflow.scene.blocks import Packing

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Flags = NDArray[np.bool_]

log = logging.getLogger(__name__)

# A floe up to this many mean elements is one disc; a larger one has at least three, which can take
# on its second moments.
ALONE, FEWEST = 1.5, 3
# A floe of several discs whose second moments are off by more than this share of their trace gets
# one more, so many times at most: three in a row have no width but their own.
CLOSE, TRIES = 0.01, 3
# Rounds in which places are matched to the floe's moments, and discs pushed into the outline.
MATCHES, FITS = 20, 60
# Where a floe is narrow its discs stand out of it rather than be smaller than this share of a disc
# of their area: small ones would rule the time step.
SLIMMEST = 0.8
# Discs of a floe are spread to fill this share of it.
FILL = 0.84
STEP = 0.3


@dataclass(frozen=True)
class Floes:
    """Floes as sets of pixels, sorted by floe.

    Parameters
    ----------
    grid : Grid
        All pixels.
    pixel, floe : ndarray
        Flat pixel, and row of its floe, ascending, (p,).
    number : ndarray
        Number in the image, (f,).
    outline : ndarray of shapely geometries
        Polygons of the pixels, (f,).
    """

    grid: Grid
    pixel: Index
    floe: Index
    number: Index
    outline: NDArray[np.object_]

    @cached_property
    def start(self) -> Index:
        """First row of each floe's pixels, and the end, (f + 1,)."""
        return np.searchsorted(self.floe, np.arange(len(self.number) + 1))

    @property
    def area(self) -> Array:
        """Plane areas (m2), (f,)."""
        return np.diff(self.start) * self.grid.spacing**2


def floes_of(mask: xr.Dataset) -> Floes:
    """Floes of a mask: connected pixels of one number, through sides or corners.

    Parameters
    ----------
    mask : xarray.Dataset
        On ``y`` and ``x``.

    Returns
    -------
    Floes
        Pixels of each floe, its number in the mask, and its outline (m).
    """
    x, y = mask["floe_x"].values, mask["floe_y"].values
    spacing = float(mask.attrs["floe_pixel"])
    grid = Grid(x, y, spacing, float(x[0]) - 0.5 * spacing, float(y[0]) - 0.5 * spacing)
    numbers = mask["floe"].values
    known = np.unique(numbers[numbers > 0])
    dense = np.where(numbers > 0, np.searchsorted(known, numbers) + 1, 0)
    found, of, pixels = 0, [], []
    for row, window in enumerate(find_objects(dense)):
        mine = dense[window] == row + 1
        part, count = label(mine, np.ones((3, 3)))
        for k in range(1, count + 1):
            down, right = np.nonzero(part == k)
            pixels.append((down + window[0].start) * x.size + right + window[1].start)
            of.append(row)
            found += 1
    if found > known.size:
        log.info("%d labels lie in several parts: %d floes", found - known.size, found)
    floe = np.repeat(np.arange(found), [len(mine) for mine in pixels])
    outline = np.array([_outline(grid, mine) for mine in pixels], dtype=object)
    return Floes(grid, np.concatenate(pixels), floe, known[of].astype(np.int64), outline)


def _outline(grid: Grid, pixels: Index) -> shapely.Geometry:
    """Union of pixels: of their runs along the rows, which are fewer."""
    row, column = np.divmod(np.sort(pixels), grid.x.size)
    new = np.append(True, (np.diff(row) != 0) | (np.diff(column) != 1))
    first, last = np.flatnonzero(new), np.append(np.flatnonzero(new)[1:] - 1, len(row) - 1)
    x, y = grid.x_edges, grid.y_edges
    at = row[first]
    runs = shapely.box(x[column[first]], y[at], x[column[last] + 1], y[at + 1])
    return shapely.union_all(runs)


def disc_counts(area: Array, elements: int) -> Index:
    """How many discs each floe gets, (f,), for about so many in all.

    Parameters
    ----------
    area : ndarray
        Of the floes, in any unit, (f,).
    elements : int
        About how many discs there shall be.

    Returns
    -------
    Index
        At least 1 each, (f,).
    """
    share = area / (area.sum() / elements)
    return np.where(share < ALONE, 1, np.maximum(FEWEST, np.round(share))).astype(np.int64)


def floe_discs(mask: xr.Dataset, packing: Packing, seed: int, coast_effect: bool) -> Elements:
    """Clusters of discs for the floes of a mask.

    Parameters
    ----------
    mask : xarray.Dataset
        Output of the mask stage, with ``floe``.
    packing, seed, coast_effect
        As in `floeflow.packings.packing.make_packing`.

    Returns
    -------
    Elements
        Edges only within floes; areas, to round-off, those of the pixels on the earth.
    """
    floes = floes_of(mask)
    count = disc_counts(floes.area, packing.elements)
    for left in range(TRIES, -1, -1):
        made, misfit = _clusters(mask, floes, count, (packing.relaxations, seed, coast_effect))
        short = (count > 1) & (misfit > CLOSE)
        if not short.any() or not left:
            break
        count = count + short
    return replace(made, figures=made.figures | _moment_figures(misfit[count > 1]))


def _moment_figures(misfit: Array) -> dict[str, float]:
    return {
        "moment_error": float(misfit.max(initial=0.0)),
        "moment_share": float((misfit > CLOSE).mean()) if len(misfit) else 0.0,
    }


def _clusters(
    mask: xr.Dataset, floes: Floes, count: Index, ways: tuple[int, int, bool]
) -> tuple[Elements, Array]:
    """Clusters of so many discs, (f,), and the misfit of their second moments, (f,).

    `ways` are relaxations, seed and whether there is a coast.
    """
    relaxations, seed, coast_effect = ways
    generator = np.random.Generator(np.random.PCG64(seed))
    places, floe, marks = _first_places(floes, count, generator)
    places = _relaxed(floes, places, floe, marks, relaxations)
    single = (count == 1)[floe]
    wanted = np.sqrt(floes.area / count / np.pi)[floe]
    places = _fitted(floes, places, floe, np.where(single, 0.0, np.sqrt(FILL) * wanted))
    for _ in range(MATCHES):
        radius = _radii(floes, places, floe, single, wanted)
        owner = owners(places, marks[0], radius**2, (floe, marks[1]))
        area = (
            np.bincount(owner, minlength=len(places)) * (floes.area / np.bincount(marks[1]))[floe]
        )
        places = match_moments(places, area, radius, floe, _moments(floes))
        places = _back(floes, places, floe)
    coast = np.empty((0, 2))
    if coast_effect:
        coast = _coast(mask, float(wanted.mean()))
    order = hilbert_order(floes.grid, places)
    places, floe, single, wanted = places[order], floe[order], single[order], wanted[order]
    everywhere = np.concatenate([places, coast])
    largest = _largest_radii(floes, places, floe, single, wanted)
    largest = np.concatenate([largest, np.full(len(coast), wanted.mean())])
    radius = discs.radii(everywhere, largest)
    made = _divided(mask, floes, floe, everywhere, radius)
    _, _, second = cluster_moments(places, made.area, radius[: made.count], floe)
    _, wanted = _moments(floes)
    off = np.abs(second - wanted).max(axis=(1, 2))
    return made, np.asarray(off / wanted.trace(axis1=1, axis2=2))


def _first_places(
    floes: Floes, count: Index, generator: np.random.Generator
) -> tuple[Array, Index, tuple[Array, Index]]:
    """Random samples of each floe; their floes; all samples and theirs."""
    per_disc = float((floes.area / count).min()) / floes.grid.spacing**2
    split = max(1, int(np.ceil(np.sqrt(points.SAMPLES_PER_ELEMENT / per_disc))))
    row, column = np.divmod(floes.pixel, floes.grid.x.size)
    offset = ((np.arange(split) + 0.5) / split - 0.5) * floes.grid.spacing
    dy, dx = (part.ravel() for part in np.meshgrid(offset, offset, indexing="ij"))
    x = (floes.grid.x[column][:, None] + dx).ravel()
    y = (floes.grid.y[row][:, None] + dy).ravel()
    of = np.repeat(floes.floe, split**2)
    samples = np.stack([x, y], axis=1)
    shuffled = np.lexsort((generator.permutation(len(of)), of))
    rank = np.arange(len(of)) - np.searchsorted(of, of)
    chosen = shuffled[rank < count[of]]
    return samples[chosen], of[chosen], (samples, of)


def _relaxed(
    floes: Floes, places: Array, floe: Index, marks: tuple[Array, Index], steps: int
) -> Array:
    """Lloyd's relaxation within each floe."""
    for _ in range(max(steps, 1)):
        owner = owners(places, marks[0], None, (floe, marks[1]))
        held = np.maximum(np.bincount(owner, minlength=len(places)), 1)
        middle = [
            np.bincount(owner, weights=marks[0][:, axis], minlength=len(places)) / held
            for axis in (0, 1)
        ]
        places = _back(floes, np.stack(middle, axis=1), floe)
    return places


def _back(floes: Floes, places: Array, floe: Index) -> Array:
    """Places off their floe go to the centre of its nearest pixel."""
    grid = floes.grid
    row, column = grid.cell_of(places[:, 0], places[:, 1])
    flat = row * grid.x.size + column
    # Pixels in the order of their place, each with its floe.
    order = np.argsort(floes.pixel)
    at = np.minimum(np.searchsorted(floes.pixel, flat, sorter=order), len(order) - 1)
    home = (floes.pixel[order[at]] == flat) & (floes.floe[order[at]] == floe)
    places = places.copy()
    for off in np.flatnonzero(~home):
        mine = floes.pixel[floes.start[floe[off]] : floes.start[floe[off] + 1]]
        down, right = np.divmod(mine, grid.x.size)
        centres = np.stack([grid.x[right], grid.y[down]], axis=1)
        places[off] = centres[np.argmin(((centres - places[off]) ** 2).sum(axis=1))]
    return places


def _fitted(floes: Floes, places: Array, floe: Index, target: Array) -> Array:
    """Discs pushed apart within their floe, and inside its outline, at their target radii."""
    rim = shapely.boundary(floes.outline)[floe]
    moving = target > 0
    for _ in range(FITS):
        moves = _apart(places, floe, target)
        line = shapely.shortest_line(rim, shapely.points(places))
        ends = shapely.get_coordinates(line).reshape(-1, 2, 2)
        inward = ends[:, 1] - ends[:, 0]
        near = np.hypot(*inward.T)
        lack = np.where(moving & (near > 0), np.maximum(target - near, 0.0), 0.0)
        moves += (STEP * lack / np.maximum(near, 1e-12))[:, None] * inward
        moved = places + moves
        stays = shapely.covers(floes.outline[floe], shapely.points(moved))
        places = np.where(stays[:, None], moved, places)
    return places


def _apart(places: Array, floe: Index, target: Array) -> Array:
    """Moves that part discs of one floe; those of others are where they are."""
    # Each floe on its own: shifted far from all others.
    reach = 4.0 * float(np.ptp(places)) + 4.0 * float(target.max())
    away = places + np.stack([floe * reach, np.zeros(len(floe))], axis=1)
    moves, _ = pushes(away, target, len(places), STEP)
    return moves


def _largest_radii(floes: Floes, places: Array, floe: Index, single: Flags, wanted: Array) -> Array:
    """Discs end at the outline of their floe; one alone has its floe's area."""
    rim = shapely.boundary(floes.outline)[floe]
    clear = shapely.distance(rim, shapely.points(places))
    return np.where(single, wanted, np.maximum(clear, SLIMMEST * wanted))


def _radii(floes: Floes, places: Array, floe: Index, single: Flags, wanted: Array) -> Array:
    return discs.radii(places, _largest_radii(floes, places, floe, single, wanted))


def _moments(floes: Floes) -> tuple[Array, Array]:
    """Centroids (f, 2) and second moments over area (f, 2, 2) of the floes, of whole pixels."""
    row, column = np.divmod(floes.pixel, floes.grid.x.size)
    at = np.stack([floes.grid.x[column], floes.grid.y[row]], axis=1)
    held = np.bincount(floes.floe)
    middle = np.stack([np.bincount(floes.floe, at[:, k]) / held for k in (0, 1)], axis=1)
    off = at - middle[floes.floe]
    second = np.empty((len(held), 2, 2))
    for a in (0, 1):
        for b in (0, 1):
            second[:, a, b] = np.bincount(floes.floe, off[:, a] * off[:, b]) / held
        second[:, a, a] += floes.grid.spacing**2 / 12.0
    return middle, second


def _coast(mask: xr.Dataset, radius: float) -> Array:
    grid = grid_of(mask)
    land, ice = mask["land"].values > 0, mask["siconc"].values > 0
    coast, _ = discs.coast_points(grid, ice, land, np.full(grid.shape, radius))
    return ordered(grid, coast)


def _divided(mask: xr.Dataset, floes: Floes, floe: Index, places: Array, radius: Array) -> Elements:
    """Pixels of each floe divided among its discs by their power diagram."""
    count = len(floe)
    cells = grid_of(mask)
    scale = mask["cell_area"].values / cells.spacing**2
    up = overlaps(cells.y_edges, floes.grid.y_edges)
    across = overlaps(cells.x_edges, floes.grid.x_edges)
    # What a pixel's area is on the earth, and the ice volume on it, as shares of its plane area.
    plane = floes.grid.spacing**2
    true, thick = (
        ((up.T @ field) @ across / plane).ravel()
        for field in (scale, scale * mask["sithick"].values)
    )
    area, volume = np.zeros(count), np.zeros(count)
    polygons = np.empty(count, dtype=object)
    edges: list[tuple[Index, Index, Array]] = []
    correction, start = 0.0, floes.start
    members = np.split(np.argsort(floe, kind="stable"), np.cumsum(np.bincount(floe))[:-1])
    for number, mine in enumerate(members):
        pixels = floes.pixel[start[number] : start[number + 1]]
        if len(mine) == 1:
            area[mine], volume[mine] = plane * true[pixels].sum(), plane * thick[pixels].sum()
            polygons[mine] = _solid(floes.outline[number])
            continue
        window, inside, flat = _window(floes.grid, pixels)
        diagram = tessellation.power_diagram(places[mine], radius[mine], window)
        found = tessellation.overlay(diagram.polygons, window, inside)
        correction = max(correction, found.correction)
        at = flat[found.cell]
        area[mine] = np.bincount(found.element, found.area * true[at], minlength=len(mine))
        volume[mine] = np.bincount(found.element, found.area * thick[at], minlength=len(mine))
        shortest = 2.0 * tessellation.SHORTEST_EDGE * float(radius[mine].mean())
        polygons[mine], lo, hi, ends = tessellation.clip(diagram, found, window, shortest)
        edges.append((mine[lo], mine[hi], ends))
    lo, hi, ends = _joined(edges)
    volume = volume / area
    area = match_areas(places[:count], area, radius[:count], floe, _moments(floes))
    return Elements(
        places,
        radius,
        area=area,
        ice_fraction=np.ones(count),
        ice_volume=volume,
        polygons=shapely.orient_polygons(polygons),
        lo=lo,
        hi=hi,
        ends=ends,
        correction=correction,
        floe=floes.number[floe],
        figures=_outline_figures(floes, floe, places[:count], radius[:count]),
    )


def _outline_figures(floes: Floes, floe: Index, places: Array, radius: Array) -> dict[str, float]:
    """Mean distance of points on the outlines from the nearest disc of the floe, from its rim."""
    corners = shapely.segmentize(shapely.boundary(floes.outline), floes.grid.spacing)
    at, of = shapely.get_coordinates(corners, return_index=True)
    owner = owners(places, at, radius**2, (floe, of))
    away = np.abs(np.hypot(*(at - places[owner]).T) - radius[owner])
    typical = float(np.sqrt(np.median(floes.area) / np.pi))
    mean = float(away.mean())
    return {"outline_distance": mean, "outline_share": mean / typical}


def _solid(outline: shapely.Geometry) -> shapely.Polygon:
    """Largest part of an outline, without holes."""
    part = max(shapely.get_parts(outline), key=lambda each: float(each.area))
    return shapely.Polygon(part.exterior)


def _window(grid: Grid, pixels: Index) -> tuple[Grid, Flags, Index]:
    """Grid around some pixels, which of its cells they are, and the flat pixel of each cell."""
    row, column = np.divmod(pixels, grid.x.size)
    south, west = int(row.min()), int(column.min())
    tall, wide = int(row.max()) - south + 1, int(column.max()) - west + 1
    inside = np.zeros((tall, wide), dtype=bool)
    inside[row - south, column - west] = True
    window = Grid(
        grid.x[west : west + wide],
        grid.y[south : south + tall],
        grid.spacing,
        float(grid.x_edges[west]),
        float(grid.y_edges[south]),
    )
    flat = (np.arange(tall)[:, None] + south) * grid.x.size + np.arange(wide) + west
    return window, inside, flat.ravel()


def _joined(edges: list[tuple[Index, Index, Array]]) -> tuple[Index, Index, Array]:
    """Edges of all floes, lower row first, sorted; ends change places with the rows."""
    if not edges:
        none = np.empty(0, dtype=np.int64)
        return none, none, np.empty((0, 2, 2))
    lo, hi, ends = (np.concatenate(parts) for parts in zip(*edges, strict=True))
    turned = lo > hi
    lo, hi = np.where(turned, hi, lo), np.where(turned, lo, hi)
    ends[turned] = ends[turned][:, ::-1]
    order = np.lexsort((hi, lo))
    return lo[order], hi[order], ends[order]
