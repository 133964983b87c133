# SPDX-License-Identifier: GPL-2.0-or-later
"""Cut the ice of the mask into elements: places, radii, effective areas, ice, neighbours.

Blue-noise points over the ice, relaxed; fixed coast elements along the land; discs that touch but
do not overlap; effective areas from their power diagram clipped to the ice, so that areas, ice area
and ice volume are those of the mask. See docs/theory/packing.md.
"""

import logging
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
import xarray as xr
from numpy.typing import NDArray

from floeflow.core.grids import Grid
from floeflow.packings import discs, points, tessellation
from floeflow.scene.blocks import Packing
from floeflow.state.schema import COAST, MOBILE

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Flags = NDArray[np.bool_]

log = logging.getLogger(__name__)

# Patches of ice smaller than this share of a mean element get no element of their own.
SMALLEST_PATCH = 0.5
# Unclaimed water below this share of the ocean is the round-off of a sum.
ROUND_OFF = 1.0e-12


@dataclass(frozen=True)
class Elements:
    """Mobile elements, tessellated.

    Parameters
    ----------
    area : ndarray
        Effective areas (m2 on the earth), (n,).
    ice_fraction, ice_volume : ndarray
        Share of the area under ice, and ice volume per area (m), (n,).
    polygons : ndarray of shapely.Polygon
        Clipped cells, (n,).
    lo, hi, ends : ndarray
        Shared edges as in `tessellation.Diagram`.
    correction : float
        As in `tessellation.Overlay`.
    """

    area: Array
    ice_fraction: Array
    ice_volume: Array
    polygons: NDArray[np.object_]
    lo: Index
    hi: Index
    ends: Array
    correction: float


def grid_of(mask: xr.Dataset) -> Grid:
    """The mask's grid."""
    x, y = mask["x"].values, mask["y"].values
    spacing = float(x[1] - x[0])
    return Grid(x, y, spacing, float(x[0]) - 0.5 * spacing, float(y[0]) - 0.5 * spacing)


def ordered(grid: Grid, places: Array) -> Array:
    """Points in the order of a Hilbert curve, so that neighbours are near in memory."""
    side = grid.spacing * max(grid.shape)
    key = points.hilbert_key(places[:, 0], places[:, 1], grid.x_min, grid.y_min, side)
    return places[np.argsort(key, kind="stable")]


def place(
    grid: Grid, ice: Flags, packing: Packing, seed: int, coast: Array, coast_radius: float
) -> tuple[Array, Array]:
    """Places of the mobile elements.

    Parameters
    ----------
    grid, ice
        Mask grid and its cells with ice, (ny, nx).
    packing : Packing
        How many elements and relaxations.
    seed : int
        Of PCG64, the only source of chance.
    coast, coast_radius
        Centres of the coast elements (m), (k, 2), and the radius to keep clear of.

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
    target = np.sqrt(discs.FILL * area * points.shares(found, marks) / np.pi)
    found = discs.spread(grid, ice, found, coast, coast_radius, target)
    found = ordered(grid, found)
    return found, points.shares(found, marks) * area


def tessellate(mask: xr.Dataset, places: Array, radius: Array) -> Elements:
    """Effective areas, ice, cells and edges of mobile elements.

    Parameters
    ----------
    mask : xarray.Dataset
        Output of the mask stage.
    places, radius : ndarray
        Centres (n, 2) and radii (n,) in metres, n >= 1.
    """
    grid = grid_of(mask)
    siconc, sithick = mask["siconc"].values, mask["sithick"].values
    diagram = tessellation.power_diagram(places, radius, grid)
    found = tessellation.overlay(diagram.polygons, grid, siconc > 0)
    scale = mask["cell_area"].values / grid.spacing**2
    share = found.area * scale.ravel()[found.cell]
    ice = share * siconc.ravel()[found.cell]

    def total(amount: Array) -> Array:
        count = len(places)
        return np.bincount(found.element, weights=amount, minlength=count).astype(float)

    area = total(share)
    shortest = 2.0 * tessellation.SHORTEST_EDGE * float(radius.mean())
    polygons, lo, hi, ends = tessellation.clip(diagram, found, grid, shortest)
    return Elements(
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


def make_packing(
    mask: xr.Dataset, packing: Packing, seed: int, coast_effect: bool = True
) -> xr.Dataset:
    """Elements of a scene.

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

    Returns
    -------
    xarray.Dataset
        Elements sorted by id (mobile first, then coast), their cells as rings, the edges that
        neighbours share; see docs/theory/packing.md. No ice makes no elements.
    """
    grid = grid_of(mask)
    land, ice = mask["land"].values > 0, mask["siconc"].values > 0
    if not ice.any():
        log.warning("the scene has no ice: no elements")
        none, index = np.empty(0), np.empty(0, dtype=np.int64)
        polygons = np.empty(0, dtype=object)
        elements = Elements(none, none, none, polygons, index, index, np.empty((0, 2, 2)), 0.0)
        return _dataset(mask, np.empty((0, 2)), none, elements)
    mean_radius = grid.spacing * float(np.sqrt(ice.sum() / packing.elements / np.pi))
    coast, side = np.empty((0, 2)), 0.0
    if coast_effect:
        coast, side = discs.coast_points(grid, ice, land, mean_radius)
        coast = ordered(grid, coast)
    places, cells = place(grid, ice, packing, seed, coast, 0.5 * side)
    largest = np.clip(np.sqrt(cells / np.pi), 0.25 * mean_radius, discs.MOST_RADII * mean_radius)
    largest = np.concatenate([largest, np.full(len(coast), mean_radius)])
    radius = discs.radii(np.concatenate([places, coast]), largest)
    elements = tessellate(mask, places, radius[: len(places)])
    mobile = radius[: len(places)]
    log.info(
        "%d mobile and %d coast elements, radii %.4g m to %.4g m, mean %.4g m; discs fill %.1f %%; "
        "areas in a mask cell corrected by at most %.1e of it",
        *(len(places), len(coast), mobile.min(), mobile.max(), mobile.mean()),
        100 * np.pi * (mobile**2).sum() / (ice.sum() * grid.spacing**2),
        elements.correction,
    )
    return _dataset(mask, np.concatenate([places, coast]), radius, elements)


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


def _dataset(mask: xr.Dataset, places: Array, radius: Array, elements: Elements) -> xr.Dataset:
    count, mobile = len(places), len(elements.area)

    def padded(values: Array) -> Array:
        return np.concatenate([values, np.zeros(count - mobile)])

    ocean = float(mask["cell_area"].values[mask["land"].values == 0].sum())
    unclaimed = ocean - float(elements.area.sum())
    start, ring = _rings(elements.polygons, count)
    data = {
        "id": np.arange(1, count + 1, dtype=np.int64),
        "type": np.where(np.arange(count) < mobile, MOBILE, COAST).astype(np.int8),
        "x": places[:, 0],
        "y": places[:, 1],
        "radius": radius,
        "area": padded(elements.area),
    }
    columns = {
        "ice_fraction": padded(elements.ice_fraction)[:, None],
        "ice_volume": padded(elements.ice_volume)[:, None],
    }
    edges: dict[str, NDArray[Any]] = {"edge_lo": elements.lo + 1, "edge_hi": elements.hi + 1}
    for k, end in enumerate("ab"):
        edges |= {f"edge_{end}x": elements.ends[:, k, 0], f"edge_{end}y": elements.ends[:, k, 1]}
    attrs = {
        "crs": mask.attrs["crs"],
        "ocean_area": ocean,
        "unclaimed_water": unclaimed if abs(unclaimed) > ROUND_OFF * ocean else 0.0,
        "overlay_correction": elements.correction,
    }
    return xr.Dataset(
        {name: ("element", values) for name, values in data.items()}
        | {name: (("element", "category"), values) for name, values in columns.items()}
        | {"cell_start": ("element_bound", start)}
        | {"cell_x": ("vertex", ring[:, 0]), "cell_y": ("vertex", ring[:, 1])}
        | {name: ("edge", values) for name, values in edges.items()},
        attrs=attrs,
    )
