# SPDX-License-Identifier: GPL-2.0-or-later
"""Fresh cells for remapping: the packing's elements and as many over the water around the ice.

They tile all sea that the ice may reach, so that ice which drifts into open water finds a cell.
Cells of the packing keep their ids and discs; those over water are numbered behind the coast.
"""

import logging
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation
from scipy.spatial import cKDTree

from floeflow.core.grids import Grid
from floeflow.packings import discs, points, tessellation
from floeflow.packings.coastline import CLEARANCE, coastline, off_shore
from floeflow.packings.elements import grid_of, ordered
from floeflow.packings.shore import shore_of
from floeflow.state.cells import rings_of
from floeflow.state.schema import MOBILE

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

log = logging.getLogger(__name__)

# Discs smaller than this share of the mean radius are left out; their water goes to neighbours.
SMALLEST_RADIUS = 0.25
RELAXATIONS = 20


def reachable(grid: Grid, ice: Flags, land: Flags) -> Flags:
    """Sea that the ice can reach: ice, and water up to `discs.REACH` from it by sea, (ny, nx).

    Parameters
    ----------
    grid : Grid
        Cells of the mask.
    ice : Flags
        Cells with ice, and land, (ny, nx).
    land : Flags
        Cells with ice, and land, (ny, nx).

    Returns
    -------
    Flags
        bool.
    """
    steps = int(np.ceil(discs.REACH / grid.spacing))
    return np.asarray(binary_dilation(ice, iterations=steps, mask=~land))


def water_discs(
    grid: Grid,
    water: Flags,
    fixed: tuple[Array, Array],
    mean_radius: float,
    seed: int,
    land: Flags,
) -> tuple[Array, Array]:
    """Discs over open water, as large as the packing's and clear of them.

    Parameters
    ----------
    grid, water
        Mask grid and its cells of open water, (ny, nx).
    fixed : tuple of ndarray
        Discs that stand already: centres and radii (m), (n, 2) and (n,).
    mean_radius : float
        Of a disc of an element's area (m).
    seed : int
        Of PCG64.
    land : ndarray
        Cells of land, (ny, nx).

    Returns
    -------
    places, radius : ndarray
        (k, 2) and (k,) in metres.
    """
    area = float(water.sum()) * grid.spacing**2
    count = round(area / (np.pi * mean_radius**2))
    if count < 1:
        return np.empty((0, 2)), np.empty(0)
    generator = np.random.Generator(np.random.PCG64([seed, 1]))
    size = np.ones(grid.shape)
    marks = points.samples(grid, water, count, size)
    found, _ = points.blue_noise(grid, water, size, np.ones(count), generator)
    found = points.lloyd(grid, water, found, marks, RELAXATIONS)
    target = np.full(len(found), np.sqrt(discs.FILL) * mean_radius)
    shore = shore_of(grid, land, None, discs.MOST_RADII * mean_radius)
    found = discs.spread(grid, water, found, (fixed[0], mean_radius), target, shore)
    found = off_shore(
        ordered(grid, found),
        *coastline(grid, land),
        CLEARANCE * mean_radius,
        lambda at: points.on_ice(grid, water, at),
    )
    near, which = cKDTree(fixed[0]).query(found, k=min(8, len(fixed[0])))
    near, which = near.reshape(len(found), -1), which.reshape(len(found), -1)
    room = np.minimum((near - fixed[1][which]).min(axis=1), shore.clearance(found))
    clear = room > SMALLEST_RADIUS * mean_radius
    found, room = found[clear], room[clear]
    radius = discs.radii(found, np.minimum(room, discs.MOST_RADII * mean_radius))
    wide = radius > SMALLEST_RADIUS * mean_radius
    return found[wide], radius[wide]


def make_cells(mask: xr.Dataset, packing: xr.Dataset, seed: int) -> xr.Dataset:
    """Fresh cells of a scene.

    Parameters
    ----------
    mask, packing : xarray.Dataset
        Outputs of those stages.
    seed : int
        The scene's seed.

    Returns
    -------
    xarray.Dataset
        Cells sorted by id with discs, areas, outlines and sides, as
        `floeflow.state.cells.read_cells` takes them.
    """
    grid = grid_of(mask)
    ice, land = mask["siconc"].values > 0, mask["land"].values > 0
    sea = reachable(grid, ice, land)
    fixed = np.stack([packing["x"].values, packing["y"].values], axis=1)
    fixed_radius, mobile = packing["radius"].values, packing["type"].values == MOBILE
    if not mobile.any():
        none = np.empty(0)
        return _dataset(np.empty(0, dtype=np.int64), np.empty((0, 2)), none, none, None)
    mean_radius = grid.spacing * float(np.sqrt(ice.sum() / mobile.sum() / np.pi))
    places, radius = water_discs(grid, sea & ~ice, (fixed, fixed_radius), mean_radius, seed, land)
    ids = packing["id"].values
    ids = np.append(ids[mobile], ids[-1] + 1 + np.arange(len(places)))
    places = np.concatenate([fixed[mobile], places])
    radius = np.append(fixed_radius[mobile], radius)
    diagram = tessellation.power_diagram(places, radius, grid)
    found = tessellation.overlay(diagram.polygons, grid, sea)
    scale = mask["cell_area"].values / grid.spacing**2
    share = found.area * scale.ravel()[found.cell]
    area = np.bincount(found.element, weights=share, minlength=len(places)).astype(float)
    shortest = 2.0 * tessellation.SHORTEST_EDGE * float(radius.mean())
    clipped = tessellation.Diagram(*tessellation.clip(diagram, found, grid, shortest))
    log.info("%d cells, %d of them over open water", len(places), len(places) - mobile.sum())
    return _dataset(ids.astype(np.int64), places, radius, area, clipped)


def _dataset(
    ids: NDArray[np.int64],
    places: Array,
    radius: Array,
    area: Array,
    diagram: tessellation.Diagram | None,
) -> xr.Dataset:
    none = np.empty(0, dtype=object)
    start, ring = rings_of(diagram.polygons if diagram else none)
    lo, hi = (diagram.lo, diagram.hi) if diagram else (ids, ids)
    ends = diagram.ends if diagram else np.empty((0, 2, 2))
    cells: dict[str, NDArray[Any]] = {
        "id": ids,
        "x": places[:, 0],
        "y": places[:, 1],
        "radius": radius,
        "area": area,
    }
    sides: dict[str, NDArray[Any]] = {"edge_lo": lo, "edge_hi": hi}
    for k, end in enumerate("ab"):
        sides |= {f"edge_{end}x": ends[:, k, 0], f"edge_{end}y": ends[:, k, 1]}
    return xr.Dataset(
        {name: ("element", values) for name, values in cells.items()}
        | {"cell_start": ("element_bound", start)}
        | {"cell_x": ("vertex", ring[:, 0]), "cell_y": ("vertex", ring[:, 1])}
        | {name: ("edge", values) for name, values in sides.items()}
    )
