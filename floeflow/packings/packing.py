# SPDX-License-Identifier: GPL-2.0-or-later
"""Cut the ice of the mask into elements: places, radii, effective areas, ice, neighbours.

Blue-noise points over the ice, relaxed; fixed coast elements along the land; discs that touch but
do not overlap; effective areas from their power diagram clipped to the ice, so that areas, ice area
and ice volume are those of the mask. See docs/theory/packing.md.
"""

import logging
from dataclasses import replace

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.core.grids import Grid
from floeflow.packings import discs, points, tessellation
from floeflow.packings.coastline import CLEARANCE, coastline, off_shore
from floeflow.packings.dense import Compactor, dense_discs
from floeflow.packings.elements import (
    Elements,
    grid_of,
    hilbert_order,
    no_elements,
    ordered,
    packing_dataset,
)
from floeflow.packings.floes import floe_discs
from floeflow.packings.quality import LABELS, PREFIX, quality
from floeflow.packings.shore import Shore, shore_of
from floeflow.packings.sizes import relative_size
from floeflow.scene.blocks import Packing
from floeflow.state.bonds import Arrays

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

log = logging.getLogger(__name__)

# Patches of ice smaller than this share of a mean element get no element of their own.
SMALLEST_PATCH = 0.5
# Cells come out less unlike than the sizes for which their places are sought; measured.
SPREAD_GAIN = 1.3
# No disc of a packing of unlike sizes is larger than this many mean radii.
MOST = 3.0


def mean_radii(grid: Grid, ice: Flags, elements: int, size: Array) -> Array:
    """Radius (m) of a circle of an element's area, by place, (ny, nx).

    Parameters
    ----------
    grid : Grid
        Cells of the mask.
    ice : Flags
        Cells with ice, (ny, nx).
    elements : int
        Number of elements.
    size : ndarray
        Relative size by place, (ny, nx).

    Returns
    -------
    ndarray
        m.
    """
    density = size[ice] ** -2.0
    return size * grid.spacing * float(np.sqrt(density.sum() / elements / np.pi))


def own_sizes(elements: int, spread: float, generator: np.random.Generator) -> Array:
    """Sizes of elements over the mean one of their place: lognormal, mean square 1, (n,).

    Parameters
    ----------
    elements : int
        Number of elements, n.
    spread : float
        Relative spread of sizes; 0 makes all alike.
    generator : numpy.random.Generator
        Of random numbers.

    Returns
    -------
    ndarray
        1.
    """
    if spread == 0.0:
        return np.ones(elements)
    wide = SPREAD_GAIN * spread
    return np.exp(wide * generator.standard_normal(elements) - wide**2)


def place(
    grid: Grid,
    ice: Flags,
    packing: Packing,
    size: Array,
    seed: int,
    coast: tuple[Array, Array],
    shore: Shore,
) -> tuple[Array, Array, Array]:
    """Places of the mobile elements.

    Parameters
    ----------
    grid, ice
        Mask grid and its cells with ice, (ny, nx).
    packing : Packing
        How many elements and relaxations, and the spread of their sizes.
    size : ndarray
        Relative size of elements by place, (ny, nx).
    seed : int
        Of PCG64, the only source of chance.
    coast : tuple of ndarray
        Centres of the coast elements (m), (k, 2), and the radii to keep clear of, (k,).
    shore : Shore
        Lines and planes to keep clear of.

    Returns
    -------
    places : ndarray
        (n, 2) in metres; a few more than asked for where patches of ice lay apart.
    cell_area : ndarray
        Plane area of their clipped cells (m2), (n,), by samples.
    mean_radius : ndarray
        Radius (m) that each would have if all elements of its place were alike, times its own
        size, (n,).
    """
    generator = np.random.Generator(np.random.PCG64(seed))
    mean = mean_radii(grid, ice, packing.elements, size)
    marks = points.samples(grid, ice, packing.elements, size)
    own = own_sizes(packing.elements, packing.size.spread, generator)
    found, own = points.blue_noise(grid, ice, size, own, generator)

    def wanted() -> Array:
        return mean[grid.cell_of(found[:, 0], found[:, 1])] * own

    spread = packing.size.spread > 0.0
    weight = discs.FILL * wanted() ** 2 if spread else None
    found = points.lloyd(grid, ice, found, marks, packing.relaxations, weight)
    smallest = SMALLEST_PATCH * np.pi * mean**2
    added = points.islands_without(grid, ice, found, marks, smallest)
    found, own = np.concatenate([found, added]), np.append(own, np.ones(len(added)))
    if spread:
        target = np.sqrt(discs.FILL) * wanted()
    else:
        target = np.sqrt(discs.FILL / np.pi * points.cell_areas(found, marks))
    found = discs.spread(grid, ice, found, coast, target, shore)
    order = hilbert_order(grid, found)
    found, own = found[order], own[order]
    weight = discs.FILL * wanted() ** 2 if spread else None
    return found, points.cell_areas(found, marks, weight), wanted()


def tessellate(mask: xr.Dataset, discs_of: tuple[Array, Array], count: int) -> Elements:
    """Effective areas, ice, cells and edges of mobile elements.

    Parameters
    ----------
    mask : xarray.Dataset
        Output of the mask stage.
    discs_of : tuple of ndarray
        Centres (n + k, 2) and radii (n + k,) in metres of mobile and coast elements.
    count : int
        n >= 1, how many are mobile.

    Returns
    -------
    Elements
        In the order of the discs: areas (m2), ice, corners of cells and ends of edges (m).
    """
    places, radius = (values[:count] for values in discs_of)
    grid = grid_of(mask)
    siconc, sithick = mask["siconc"].values, mask["sithick"].values
    diagram = tessellation.power_diagram(places, radius, grid)
    found = tessellation.overlay(diagram.polygons, grid, siconc > 0)
    scale = mask["cell_area"].values / grid.spacing**2
    share = found.area * scale.ravel()[found.cell]
    ice = share * siconc.ravel()[found.cell]

    def total(amount: Array) -> Array:
        return np.bincount(found.element, weights=amount, minlength=count).astype(float)

    area = total(share)
    shortest = 2.0 * tessellation.SHORTEST_EDGE * float(radius.mean())
    polygons, lo, hi, ends = tessellation.clip(diagram, found, grid, shortest)
    return Elements(
        *discs_of,
        area=area,
        # A sum of shares may end a round-off above 1.
        ice_fraction=np.minimum(total(ice) / area, 1.0),
        ice_volume=total(ice * sithick.ravel()[found.cell]) / area,
        polygons=polygons,
        lo=lo,
        hi=hi,
        ends=ends,
        correction=found.correction,
    )


def tessellated(
    mask: xr.Dataset, packing: Packing, seed: int, coast_effect: bool, walls: Arrays | None
) -> Elements:
    """Cells that fill the ice (generator tessellation); see `make_packing`.

    Parameters
    ----------
    mask : xarray.Dataset
        Ice and land.
    packing : Packing
        Block ``packing`` of the scene.
    seed : int
        Of the random numbers.
    coast_effect : bool
        Whether elements line the coast.
    walls : Arrays or None
        Faces that no element reaches across.

    Returns
    -------
    Elements
        Places, discs and cells.

    Raises
    ------
    FloeError
        For a packing that cannot be made.
    """
    grid = grid_of(mask)
    land, ice = mask["land"].values > 0, mask["siconc"].values > 0
    coarse = 2.0 * grid.spacing * float(np.sqrt(ice.sum() / packing.elements / np.pi))
    size = relative_size(grid, ice, land, packing.size, coarse, mask.attrs["crs"])
    mean = mean_radii(grid, ice, packing.elements, size)
    coast, side = np.empty((0, 2)), 0.0
    if coast_effect:
        coast, side = discs.coast_points(grid, ice, land, mean)
        coast = ordered(grid, coast)
    clear = np.full(len(coast), 0.5 * side)
    shore = shore_of(grid, land, walls, MOST * float(mean[ice].max()))
    places, cells, own = place(grid, ice, packing, size, seed, (coast, clear), shore)

    def allowed(at: Array) -> Flags:
        return points.on_ice(grid, ice, at)

    clearance = CLEARANCE * float(mean[ice].mean())
    places = off_shore(places, *coastline(grid, land), clearance, allowed)
    before = shore.before(places, discs.SLIMMEST * own)
    places = np.where(allowed(before)[:, None], before, places)
    # Cells of unlike elements have no bound that follows from those of like ones.
    least, most = (0.25, discs.MOST_RADII) if packing.size.spread == 0 else (0.1, MOST)
    largest = np.clip(np.sqrt(cells / np.pi), least * own, most * own)
    largest = discs.off_coast(places, largest, own, shore)
    beside = mean[grid.cell_of(coast[:, 0], coast[:, 1])]
    everywhere = np.concatenate([places, coast])
    radius = discs.radii(everywhere, np.concatenate([largest, beside]))
    radius = discs.coast_at_ice(everywhere, radius, len(places), discs.MOST_RADII * beside)
    made = tessellate(mask, (everywhere, radius), len(places))
    row, column = grid.cell_of(places[:, 0], places[:, 1])
    scale = mask["cell_area"].values[row, column] / grid.spacing**2
    ratio = np.sqrt(made.area / scale / np.pi) / own
    return replace(made, size_ratio=ratio, figures={"size_error": float(ratio.std())})


def make_packing(
    mask: xr.Dataset,
    packing: Packing,
    seed: int,
    coast_effect: bool = True,
    compact: Compactor | None = None,
    walls: Arrays | None = None,
) -> xr.Dataset:
    """Elements of a scene, by the generator that it names.

    Parameters
    ----------
    mask : xarray.Dataset
        Output of the mask stage.
    packing : Packing
        The scene's block.
    seed : int
        The scene's seed.
    coast_effect : bool
        Whether to line the land with fixed elements.
    compact : callable, optional
        Parts discs that overlap, for the generator dense.
    walls : dict of ndarray, optional
        Faces (`floeflow.state.walls`) of the scene's walls, which discs keep clear of.

    Returns
    -------
    xarray.Dataset
        Elements sorted by id (mobile first, then coast), their cells as rings, the edges that
        neighbours share; see docs/theory/packing.md. No ice makes no elements.
    """
    ice = mask["siconc"].values > 0
    if not ice.any():
        log.warning("the scene has no ice: no elements")
        return packing_dataset(mask, no_elements())
    if packing.generator == "dense":
        assert compact is not None
        made = dense_discs(mask, packing, seed, coast_effect, compact, walls)
    elif packing.generator == "floes":
        made = floe_discs(mask, packing, seed, coast_effect)
    else:
        made = tessellated(mask, packing, seed, coast_effect, walls)
    mobile = made.radius[: made.count]
    log.info(
        "%d mobile and %d coast elements, radii %.4g m to %.4g m, mean %.4g m; discs fill %.1f %%; "
        "areas in a mask cell corrected by at most %.1e of it",
        *(made.count, len(made.radius) - made.count, mobile.min(), mobile.max(), mobile.mean()),
        100 * np.pi * (mobile**2).sum() / float(made.area.sum()),
        made.correction,
    )
    out = packing_dataset(mask, made)
    for name, value in (quality(mask, out) | made.figures).items():
        text, units = LABELS[name]
        out[f"{PREFIX}{name}"] = ((), value, {"long_name": text, "units": units})
    return out
