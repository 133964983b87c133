# SPDX-License-Identifier: GPL-2.0-or-later
"""Gridded output of one window boundary: CF NetCDF that climate models and their tools read.

Properties of the ice are averaged by moving least squares, how much of a cell's sea it covers
comes from dealing out the elements' areas (docs/theory/remap.md). Nothing is corrected to the
elements' totals yet; what the grid lacks or has in excess is written beside the fields.
"""

import logging
import math
from pathlib import Path

import numpy as np
import xarray as xr

from floeflow import stage
from floeflow.config import Scene
from floeflow.constants import ICE_DENSITY, SNOW_DENSITY
from floeflow.errors import FloeError
from floeflow.postprocess.cf import describe, write_grid
from floeflow.postprocess.remap import (
    Field,
    Grid,
    Remapper,
    Room,
    build_bins,
    build_room,
    build_weights,
    remap,
)
from floeflow.postprocess.remap.grid import Array
from floeflow.preprocess.grids import scene_grid
from floeflow.state import read_dataset, read_state
from floeflow.state.schema import MOBILE

log = logging.getLogger(__name__)

CONCENTRATION = Field("siconc", "intensive", "area")
THICKNESS = Field("sithick", "intensive", "ice_area")
SNOW = Field("sisnthick", "intensive", "ice_area")
VELOCITIES = (Field("siu", "intensive", "ice_mass"), Field("siv", "intensive", "ice_mass"))


def cell_areas(mask: xr.Dataset, shape: tuple[int, int]) -> Array:
    """Areas of the scene grid's cells on the earth.

    Parameters
    ----------
    mask : xarray.Dataset
        cell_area (m2) on the mask grid.
    shape : tuple of int
        Rows and columns of the scene grid.

    Returns
    -------
    ndarray
        m2, of that shape.

    Raises
    ------
    FloeError
        Where the mask grid is no refinement of the scene grid.
    """
    (ny, nx), (rows, columns) = shape, mask["cell_area"].shape
    refine = rows // ny
    if refine < 1 or (rows, columns) != (refine * ny, refine * nx):
        raise FloeError(f"mask: its {rows} x {columns} cells do not divide {ny} x {nx} cells")
    parts = mask["cell_area"].values.reshape(ny, refine, nx, refine)
    return np.asarray(parts.sum(axis=(1, 3)))


def sea_room(mask: xr.Dataset, grid: Grid, reach: int) -> Room:
    """Find the sea in the scene grid's cells, of which the mask grid's cells are pieces.

    Parameters
    ----------
    mask : xarray.Dataset
        land and cell_area (m2) on the mask grid.
    grid : Grid
        The scene grid.
    reach : int
        Half-width of the hats in grid spacings.
    """
    x, y = np.meshgrid(mask["x"].values, mask["y"].values)
    sea = mask["land"].values == 0
    return build_room(x[sea], y[sea], mask["cell_area"].values[sea], grid, reach=reach)


def hat_reach(state: xr.Dataset, grid: Grid) -> int:
    """Half-width of the hats in grid spacings: about two spacings of the elements.

    Fewer leave nodes without enough elements for a plane, more blur without need.
    """
    area = state["area"].values
    area = area[area > 0.0]
    if not len(area):
        return 1
    width = 2.0 * float(np.sqrt(np.median(area))) / min(grid.spacing)
    # The allowance keeps the plain hats for three elements a cell and more.
    return max(1, math.ceil(width - 0.25))


def gridded_fields(state: xr.Dataset, room: Room) -> dict[str, Array]:
    """Fields of the ice on a grid.

    Parameters
    ----------
    state : xarray.Dataset
        State at a window boundary.
    room : Room
        The grid and the sea in its cells.

    Returns
    -------
    dict of ndarray
        siconc, sithick, sivol, siu, siv, sisnthick with snow: (ny, nx). siconc and sivol are NaN
        where there is no sea, the others where there is no ice. remap_method: (ny, nx) of int8.
        siarea_residual (m2), sivolume_residual (m3): the grid's total minus the elements'.
    """
    mobile = state.isel(element=np.flatnonzero(state["type"].values == MOBILE))
    x, y, area = (mobile[name].values for name in ("x", "y", "area"))
    fraction, volume = (mobile[name].values.sum(axis=1) for name in ("ice_fraction", "ice_volume"))
    iced = fraction > 0.0
    snow = mobile["snow_volume"].values.sum(axis=1) if "snow_volume" in mobile else None
    mass = area * (ICE_DENSITY * volume + (0.0 if snow is None else SNOW_DENSITY * snow))
    parents = {"area": area, "ice_area": area * fraction, "ice_mass": mass}
    remapper = Remapper(
        weights={
            name: build_weights(x, y, amount, room.grid, reach=room.reach)
            for name, amount in parents.items()
        },
        bins=build_bins(x, y, room),
    )

    def per_ice(amount: Array) -> Array:
        return np.divide(amount, fraction, out=np.full_like(amount, np.nan), where=iced)

    is_sea = room.area > 0.0
    covered = np.minimum(np.nan_to_num(remapper.bins.coverage(area)), 1.0)
    siconc = covered * np.nan_to_num(remap(CONCENTRATION, fraction, remapper))
    sithick = remap(THICKNESS, per_ice(volume), remapper)
    siconc = np.where(np.isfinite(sithick), siconc, 0.0)
    fields = {"siconc": siconc, "sithick": sithick, "sivol": siconc * np.nan_to_num(sithick)}
    if snow is not None:
        fields["sisnthick"] = remap(SNOW, per_ice(snow), remapper)
    for velocity, name in zip(VELOCITIES, ("u", "v"), strict=True):
        fields[velocity.name] = remap(velocity, mobile[name].values, remapper)
    has_ice = is_sea & (siconc > 0.0)
    for name, values in fields.items():
        keep = is_sea if name in ("siconc", "sivol") else has_ice
        fields[name] = np.where(keep, values, np.nan)
    method = remapper.weights["ice_area"].status
    fields["remap_method"] = np.where(has_ice, method, 0).astype(np.int8)
    for name, field, amount in (
        ("siarea_residual", "siconc", area * fraction),
        ("sivolume_residual", "sivol", area * volume),
    ):
        fields[name] = np.asarray(np.nansum(fields[field] * room.area) - amount.sum())
    return fields


def make_grid(scene: Scene, state: xr.Dataset, mask: xr.Dataset) -> xr.Dataset:
    """Gridded output of a state, with all that CF asks for.

    Parameters
    ----------
    scene : Scene
        Its domain and effects are read.
    state : xarray.Dataset
        State at a window boundary.
    mask : xarray.Dataset
        Mask on the mask grid.

    Returns
    -------
    xarray.Dataset
        Fields (time, y, x) and what describes them, encodings included.

    Raises
    ------
    FloeError
        Where state or mask do not fit the scene.
    """
    cells = scene_grid(scene.domain)
    grid = Grid(cells.x, cells.y)
    area = cell_areas(mask, grid.shape)
    room = sea_room(mask, grid, hat_reach(state, grid))
    return describe(scene, state, gridded_fields(state, room), (area, room.area))


def main(snakemake: stage.Snakemake) -> None:
    """Rule ``grid``."""
    scene = stage.scene(snakemake)
    state = read_state(snakemake.input.state)
    data = make_grid(scene, state, read_dataset(snakemake.input.mask))
    write_grid(data, Path(str(snakemake.output.grid)))
    area, volume = float(data["siarea_residual"][0]), float(data["sivolume_residual"][0])
    log.info("grid minus elements: ice area %.4g km2, volume %.4g km3", area / 1e6, volume / 1e9)


if "snakemake" in globals():
    stage.run(main, globals()["snakemake"])
