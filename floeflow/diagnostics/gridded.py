# SPDX-License-Identifier: GPL-2.0-or-later
"""Gridded output of one window boundary: CF NetCDF that climate models and their tools read.

Properties of the ice are averaged by moving least squares, how much of a cell's sea it covers
comes from dealing out the elements' areas; both are then moved, as little as it takes, to the
elements' totals (docs/theory/remap.md). What lies outside of the grid is written beside the fields.
"""

import logging
import math
from collections.abc import Mapping
from functools import partial
from typing import Literal, cast

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.core.constants import ICE_DENSITY, SNOW_DENSITY
from floeflow.core.errors import FloeError
from floeflow.core.grids import scene_grid
from floeflow.diagnostics.cf_output import describe
from floeflow.diagnostics.ice_fields import follow, ice_amounts, strain_rates
from floeflow.diagnostics.surface_forces import surface_forces
from floeflow.scene import Scene
from floeflow.state.schema import MOBILE
from floeflow.state.snapshots import snapshot
from floeflow.transfer import (
    ROOM,
    Field,
    Grid,
    Room,
    build_remapper,
    build_room,
    conservative_transfer,
    near_cells,
)
from floeflow.transfer.stencil import Array
from floeflow.transfer.weights import CONDITION_LIMIT

log = logging.getLogger(__name__)

AMOUNTS = (
    Field("area", "extensive", ROOM),
    Field("ice_area", "extensive", "area"),
    Field("ice_volume", "extensive", "ice_area"),
    Field("snow_volume", "extensive", "ice_area"),
)
VELOCITIES = (Field("siu", "intensive", "ice_mass"), Field("siv", "intensive", "ice_mass"))
Transfer = Literal["conservative", "mls", "shepard", "nearest"]
RESIDUALS = {"ice_area": "siarea", "ice_volume": "sivolume", "snow_volume": "sisnvolume"}


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

    Returns
    -------
    Room
        Area of sea (m2) and pull (1) of each cell, (ny, nx).
    """
    x, y = np.meshgrid(mask["x"].values, mask["y"].values)
    sea = mask["land"].values == 0
    return build_room(x[sea], y[sea], mask["cell_area"].values[sea], grid, reach=reach)


def room_of(state: xr.Dataset, mask: xr.Dataset, grid: Grid, rooms: dict[int, Room]) -> Room:
    """Sea in the cells, as a state's hats reach it.

    Parameters
    ----------
    state : xarray.Dataset
        Elements with ``area`` (m2).
    mask : xarray.Dataset
        As of `sea_room`.
    grid : Grid
        The scene grid.
    rooms : dict
        What was found for other states of the same mask and grid, by the reach of their hats; what
        is not in it is added.

    Returns
    -------
    Room
        That of `rooms` for the reach; it is added where it lacks.
    """
    reach = hat_reach(state, grid)
    if reach not in rooms:
        rooms[reach] = sea_room(mask, grid, reach)
    return rooms[reach]


def hat_reach(state: xr.Dataset, grid: Grid) -> int:
    """Half-width of the hats in grid spacings: about two spacings of the elements.

    Fewer leave nodes without enough elements for a plane, more blur without need.

    Parameters
    ----------
    state : xarray.Dataset
        Elements with ``area`` (m2).
    grid : Grid
        Nodes.

    Returns
    -------
    int
        At least 1.
    """
    area = state["area"].values
    area = area[area > 0.0]
    if not len(area):
        return 1
    width = 2.0 * float(np.sqrt(np.median(area))) / min(grid.spacing)
    # The allowance keeps the plain hats for three elements a cell and more.
    return max(1, math.ceil(width - 0.25))


def gridded_fields(
    state: xr.Dataset, room: Room, transfer: Transfer = "conservative"
) -> dict[str, Array]:
    """Fields of the ice on a grid, with the totals of the elements if conservative.

    Parameters
    ----------
    state : xarray.Dataset
        State at a window boundary.
    room : Room
        The grid and the sea in its cells.
    transfer : str
        As in ``grid.transfer``: how averages are made, and whether they are moved to the totals.

    Returns
    -------
    dict of ndarray
        siconc, sithick, sivol, siu, siv, sisnthick with snow, and what
        `floeflow.diagnostics.ice_fields` adds: (ny, nx), those of categories with one more
        dimension in front. What is per sea is NaN where there is none, the rest where there is
        no ice. remap_method: (ny, nx) of int8.
        siarea_residual (m2), sivolume_residual and, with snow, sisnvolume_residual (m3): the
        grid's total minus that of the elements on it; siarea_outside ...: what lies in elements
        outside of the grid.

    Raises
    ------
    FloeError
        Where the state holds values that cannot be.
    """
    if "bond_id_lo" in state:
        state = snapshot(state)
    mobile = state.isel(element=np.flatnonzero(state["type"].values == MOBILE))
    x, y, area = (mobile[name].values for name in ("x", "y", "area"))
    fraction, volume = (mobile[name].values.sum(axis=1) for name in ("ice_fraction", "ice_volume"))
    snow = mobile["snow_volume"].values.sum(axis=1) if "snow_volume" in mobile else 0.0 * volume
    values = {
        "area": area,
        "ice_area": area * fraction,
        "ice_volume": area * np.where(fraction > 0.0, volume, 0.0),
        "snow_volume": area * np.where(fraction > 0.0, snow, 0.0),
    }
    parents = {name: values[name] for name in ("area", "ice_area")}
    exact = transfer == "conservative"
    build = partial(
        build_remapper,
        radius=mobile["radius"].values,
        # No condition number lies below 1: each node then gets Shepard's average.
        condition_limit=0.0 if transfer == "shepard" else CONDITION_LIMIT,
        nearest=transfer == "nearest",
    )
    remapper = build(x, y, parents, room)
    more, amounts = ice_amounts(mobile)
    carried = conservative_transfer(
        (*AMOUNTS, *more), values | amounts, remapper, near=_near(mobile, room), exact=exact
    )
    found = carried.values
    # Velocity is a property of the mass, which is known on the grid only now.
    mass = ICE_DENSITY * values["ice_volume"] + SNOW_DENSITY * values["snow_volume"]
    on_grid = ICE_DENSITY * found["ice_volume"] + SNOW_DENSITY * found["snow_volume"]
    moving = {"ice_mass": mass, "siu": mobile["u"].values, "siv": mobile["v"].values}
    heavy = build(x, y, {"ice_mass": mass}, room)
    speeds = conservative_transfer(
        VELOCITIES, moving, heavy, known={"ice_mass": on_grid}, exact=exact
    )

    is_sea, sea = room.area > 0.0, np.where(room.area > 0.0, room.area, 1.0)
    has_ice = is_sea & (found["ice_area"] > 0.0)
    per_ice = np.where(has_ice, found["ice_area"], np.nan)
    fields = {
        "siconc": np.where(is_sea, found["ice_area"] / sea, np.nan),
        "sivol": np.where(is_sea, found["ice_volume"] / sea, np.nan),
        "sithick": found["ice_volume"] / per_ice,
    }
    if "snow_volume" in mobile:
        fields["sisnthick"] = found["snow_volume"] / per_ice
    fields |= {name: np.where(has_ice, v, np.nan) for name, v in speeds.values.items()}
    follow(found, sea, per_ice, fields)
    fields["sispeed"] = np.hypot(fields["siu"], fields["siv"])
    fields["sidivvel"], fields["sishevel"] = strain_rates(
        fields["siu"], fields["siv"], cast(Grid, room.target).spacing
    )
    method = remapper.weights["ice_area"].status
    fields["remap_method"] = np.where(has_ice, method, 0).astype(np.int8)
    for name, output in RESIDUALS.items():
        if name != "snow_volume" or "snow_volume" in mobile:
            fields[f"{output}_residual"] = np.asarray(0.0 - carried.missing[name])
            fields[f"{output}_outside"] = np.asarray(carried.outside[name])
    return fields


def mass_transport(fields: Mapping[str, Array], area: Array, sea: Array) -> dict[str, Array]:
    """Mass of ice and snow that passes each cell.

    Parameters
    ----------
    fields : mapping
        simass, siconc, siu, siv and, with snow, sisnthick.
    area, sea : ndarray
        Of the cells and of the sea in them (m2), (ny, nx).

    Returns
    -------
    dict of ndarray
        sidmasstranx, sidmasstrany (kg/s), (ny, nx): mass per area of the cell times velocity times
        the cell's width on the earth, which the projection stretches alike along x and y; 0 where
        the sea is open.
    """
    mass = np.nan_to_num(fields["simass"])
    if "sisnthick" in fields:
        mass = mass + SNOW_DENSITY * np.nan_to_num(fields["siconc"] * fields["sisnthick"])
    per = np.where(sea > 0.0, mass * sea / area * np.sqrt(area), np.nan)
    return {
        f"sidmasstran{axis}": per * np.nan_to_num(fields[f"si{name}"])
        for axis, name in (("x", "u"), ("y", "v"))
    }


def _near(mobile: xr.Dataset, room: Room) -> NDArray[np.bool_]:
    """Cells that may hold ice: those within one grid spacing of an element that has some."""
    iced = mobile.isel(element=np.flatnonzero(mobile["ice_fraction"].values.sum(axis=1) > 0.0))
    x, y, radius = (iced[name].values for name in ("x", "y", "radius"))
    return near_cells(x, y, radius, room.target, room.target.pairs(x, y, room.reach))


def make_grid(
    scene: Scene,
    state: xr.Dataset,
    mask: xr.Dataset,
    forcing: Mapping[str, Array] | None = None,
    rooms: dict[int, Room] | None = None,
) -> xr.Dataset:
    """Gridded output of a state, with all that CF asks for.

    Parameters
    ----------
    scene : Scene
        Its domain and effects are read.
    state : xarray.Dataset
        State at a window boundary.
    mask : xarray.Dataset
        Mask on the mask grid.
    forcing : mapping, optional
        From `floeflow.diagnostics.surface_forces.forcing_at`; without it no forces.
    rooms : dict, optional
        As of `room_of`, kept for the next state of the same mask and grid.

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
    room = room_of(state, mask, grid, {} if rooms is None else rooms)
    fields = gridded_fields(state, room, scene.grid.transfer)
    fields |= mass_transport(fields, area, room.area)
    if forcing:
        fields |= surface_forces(scene, fields, forcing)
    return describe(scene, state, fields, (area, room.area))
