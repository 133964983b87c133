# SPDX-License-Identifier: GPL-2.0-or-later
"""Cut the ice of the mask into elements: places, radii, effective areas, ice, neighbours.

Blue-noise points over the ice, relaxed; fixed coast elements along the land; discs that touch but
do not overlap; effective areas from their power diagram clipped to the ice, so that areas, ice area
and ice volume are those of the mask. See docs/theory/packing.md.
"""

import logging

import numpy as np
import shapely
import xarray as xr
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from floeflow import stage
from floeflow.config.blocks import Packing
from floeflow.preprocess import discs, points, tessellation
from floeflow.preprocess.grids import Grid
from floeflow.state import read_dataset, write_dataset
from floeflow.state.schema import COAST, MOBILE

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Flags = NDArray[np.bool_]

log = logging.getLogger(__name__)

# Patches of ice smaller than this share of a mean element get no element of their own.
SMALLEST_PATCH = 0.5


def grid_of(mask: xr.Dataset) -> Grid:
    """The mask's grid."""
    x, y = mask["x"].values, mask["y"].values
    spacing = float(x[1] - x[0])
    return Grid(x, y, spacing, float(x[0]) - 0.5 * spacing, float(y[0]) - 0.5 * spacing)


def place(grid: Grid, ice: Flags, packing: Packing, seed: int) -> tuple[Array, Array]:
    """Places of the mobile elements, in the order of a Hilbert curve.

    Parameters
    ----------
    grid, ice
        Mask grid and its cells with ice, (ny, nx).
    packing : Packing
        How many elements and relaxations.
    seed : int
        Of PCG64.

    Returns
    -------
    places : ndarray
        (n, 2) in metres; a few more than asked for where patches of ice lay apart.
    cell_area : ndarray
        Plane area of their clipped Voronoi cells (m2), (n,), by samples.
    """
    generator = np.random.Generator(np.random.PCG64(seed))
    area = float(ice.sum()) * grid.spacing**2
    per_side = points.samples_per_side(int(ice.sum()), packing.elements)
    marks, cells = points.samples(grid, ice, per_side)
    found = points.blue_noise(grid, ice, packing.elements, generator)
    found = points.lloyd(grid, ice, found, marks, packing.relaxations)
    smallest = SMALLEST_PATCH * area / packing.elements
    added = points.islands_without(grid, ice, found, marks, cells, smallest)
    found = np.concatenate([found, added])
    size = grid.spacing * max(grid.shape)
    key = points.hilbert_key(found[:, 0], found[:, 1], grid.x_min, grid.y_min, size)
    found = found[np.argsort(key, kind="stable")]
    _, owner = cKDTree(found).query(marks)
    share = np.bincount(owner, minlength=len(found)) / len(marks)
    return found, share * area


def make_packing(mask: xr.Dataset, packing: Packing, seed: int) -> xr.Dataset:
    """Elements of a scene.

    Parameters
    ----------
    mask : xarray.Dataset
        Output of the mask stage.
    packing : Packing
        The scene's block.
    seed : int
        The scene's seed.

    Returns
    -------
    xarray.Dataset
        Elements sorted by id (mobile first, then coast), their cells as rings, the edges that
        neighbours share; see docs/theory/packing.md.
    """
    grid = grid_of(mask)
    siconc, land = mask["siconc"].values, mask["land"].values > 0
    ice = siconc > 0
    true_area = mask["cell_area"].values
    ocean = float(true_area[~land].sum())
    if not ice.any():
        log.warning("the scene has no ice: no elements")
        return _dataset(mask, _no_elements(), ocean)
    places, voronoi = place(grid, ice, packing, seed)
    count = len(places)
    mean_radius = float(np.sqrt(voronoi.mean() / np.pi))
    coast = np.empty((0, 2))
    if packing.coast and land.any():
        coast, _ = discs.coast_points(grid, ice, land, mean_radius)
        size = grid.spacing * max(grid.shape)
        key = points.hilbert_key(coast[:, 0], coast[:, 1], grid.x_min, grid.y_min, size)
        coast = coast[np.argsort(key, kind="stable")]
    everywhere = np.concatenate([places, coast])
    largest = np.full(len(everywhere), mean_radius)
    largest[:count] = np.minimum(np.sqrt(voronoi / np.pi), discs.MOST_RADII * mean_radius)
    radius = discs.radii(everywhere, np.maximum(largest, 0.25 * mean_radius))
    elements = _tessellated(mask, grid, ice, places, radius[:count])
    elements |= {"places": everywhere, "radius": radius, "mobile": count}
    log.info(
        "%d mobile and %d coast elements, mean radius %.4g m, smallest %.4g m, discs fill %.1f %%",
        count, len(coast), radius[:count].mean(), radius[:count].min(),
        100 * np.pi * (radius[:count] ** 2).sum() / (ice.sum() * grid.spacing**2),
    )
    return _dataset(mask, elements, ocean)


def _tessellated(
    mask: xr.Dataset, grid: Grid, ice: Flags, places: Array, radius: Array
) -> dict[str, object]:
    """Areas, ice, cells and edges of the mobile elements."""
    diagram = tessellation.power_diagram(places, radius, grid)
    found = tessellation.overlay(diagram.polygons, grid, ice)
    log.info("overlay: areas in a mask cell corrected by at most %.1e of it", found.correction)
    count = len(places)
    true = mask["cell_area"].values.ravel()[found.cell] / grid.spacing**2 * found.area
    siconc = mask["siconc"].values.ravel()[found.cell]
    sithick = mask["sithick"].values.ravel()[found.cell]

    def total(amount: Array) -> Array:
        return np.bincount(found.element, weights=amount, minlength=count)

    area = total(true)
    shortest = 2.0 * tessellation.SHORTEST_EDGE * float(radius.mean())
    polygons, lo, hi, ends = tessellation.clip(diagram, found, grid, shortest)
    return {
        "area": area,
        # A sum of shares may end a round-off above 1.
        "ice_fraction": np.minimum(total(true * siconc) / area, 1.0),
        "ice_volume": total(true * siconc * sithick) / area,
        "polygons": polygons,
        "lo": lo,
        "hi": hi,
        "ends": ends,
        "correction": found.correction,
    }


def _no_elements() -> dict[str, object]:
    none, index = np.empty(0), np.empty(0, dtype=np.int64)
    return {
        "places": np.empty((0, 2)), "radius": none, "mobile": 0, "area": none,
        "ice_fraction": none, "ice_volume": none, "polygons": np.empty(0, dtype=object),
        "lo": index, "hi": index, "ends": np.empty((0, 2, 2)), "correction": 0.0,
    }


def _rings(polygons: NDArray[np.object_], count: int) -> tuple[Index, Array]:
    """Starts and vertices of open rings, without repeated vertices; none for coast elements."""
    xy, of = shapely.get_coordinates(polygons, return_index=True)
    if len(xy):
        last = np.append(of[1:] != of[:-1], True)
        again = np.append(np.all(xy[1:] == xy[:-1], axis=1) & (of[1:] == of[:-1]), False)
        keep = ~(last | again)
        xy, of = xy[keep], of[keep]
    start = np.searchsorted(of, np.arange(count + 1))
    return start.astype(np.int64), xy


def _dataset(mask: xr.Dataset, elements: dict[str, object], ocean: float) -> xr.Dataset:
    places, mobile = np.asarray(elements["places"]), int(str(elements["mobile"]))
    count = len(places)

    def padded(name: str) -> Array:
        return np.concatenate([np.asarray(elements[name]), np.zeros(count - mobile)])

    area = padded("area")
    unclaimed = ocean - float(area.sum())
    if abs(unclaimed) <= 1e-12 * ocean:
        unclaimed = 0.0
    start, ring = _rings(np.asarray(elements["polygons"]), count)
    lo, hi = np.asarray(elements["lo"]) + 1, np.asarray(elements["hi"]) + 1
    ends = np.asarray(elements["ends"])
    kind = np.where(np.arange(count) < mobile, MOBILE, COAST).astype(np.int8)
    data = {
        "id": ("element", np.arange(1, count + 1, dtype=np.int64)),
        "type": ("element", kind),
        "x": ("element", places[:, 0]),
        "y": ("element", places[:, 1]),
        "radius": ("element", np.asarray(elements["radius"])),
        "area": ("element", area),
        "ice_fraction": (("element", "category"), padded("ice_fraction")[:, None]),
        "ice_volume": (("element", "category"), padded("ice_volume")[:, None]),
        "cell_start": ("element_bound", start),
        "cell_x": ("vertex", ring[:, 0]),
        "cell_y": ("vertex", ring[:, 1]),
        "edge_lo": ("edge", lo),
        "edge_hi": ("edge", hi),
        "edge_ax": ("edge", ends[:, 0, 0]),
        "edge_ay": ("edge", ends[:, 0, 1]),
        "edge_bx": ("edge", ends[:, 1, 0]),
        "edge_by": ("edge", ends[:, 1, 1]),
    }
    attrs = {
        "crs": mask.attrs["crs"],
        "ocean_area": ocean,
        "unclaimed_water": unclaimed,
        "overlay_correction": float(str(elements["correction"])),
    }
    return xr.Dataset(data, attrs=attrs)


def main(snakemake: stage.Snakemake) -> None:
    """Rule ``packing``."""
    scene = stage.scene(snakemake)
    mask = read_dataset(snakemake.input.mask)
    write_dataset(make_packing(mask, scene.packing, scene.seed), snakemake.output.packing)


if "snakemake" in globals():
    stage.run(main, globals()["snakemake"])
