# SPDX-License-Identifier: GPL-2.0-or-later
"""Tendencies of the ice's mass and concentration on the grid, means over each window.

What the columns of a window made of ice goes to the grid as the ice itself does
(docs/theory/remap.md), from where the dynamics left the elements. What else changes the mass and
the concentration of a cell between two window boundaries is the dynamics: advection, ridging, and
ice that leaves or enters the scene's rectangle.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.core.constants import ICE_DENSITY
from floeflow.core.errors import FloeError
from floeflow.diagnostics.cf_output import MISSING, field_attributes, file_attributes
from floeflow.diagnostics.collect import read_grid
from floeflow.diagnostics.gridded import room_of
from floeflow.diagnostics.tendencies import METHOD
from floeflow.scene import Scene
from floeflow.transfer import (
    ROOM,
    Field,
    Grid,
    Room,
    build_remapper,
    conservative_transfer,
    near_cells,
)

Array = NDArray[np.float64]

AMOUNT = "tendency_of_sea_ice_amount_due_to_"
SHARE = "tendency_of_sea_ice_area_fraction_due_to_"
COVER = "ice_area_grown"


@dataclass(frozen=True)
class Tendency:
    """A tendency under its name in CMIP6's table SImon.

    Parameters
    ----------
    standard_name, long_name : str
        As in the file.
    terms : tuple of str
        Terms of the columns whose sum it is; empty for what follows from others.
    sign : float
        -1 where upwards counts.
    units : str
        As in the file.
    """

    standard_name: str
    long_name: str
    terms: tuple[str, ...] = ()
    sign: float = 1.0
    units: str = "kg m-2 s-1"


TENDENCIES = {
    "sidmassgrowthbot": Tendency(
        f"{AMOUNT}congelation_ice_accumulation", "growth at the base", ("growth_base",)
    ),
    "sidmassgrowthwat": Tendency(
        f"{AMOUNT}frazil_ice_accumulation_in_leads", "new ice on open water", ("growth_new_ice",)
    ),
    "sidmasssi": Tendency(
        f"{AMOUNT}conversion_of_snow_to_sea_ice", "snow that turned into ice", ("growth_snow_ice",)
    ),
    "sidmassmelttop": Tendency(f"{AMOUNT}surface_melting", "melt at the top", ("growth_melt_top",)),
    "sidmassmeltbot": Tendency(f"{AMOUNT}basal_melting", "melt at the base", ("growth_melt_base",)),
    "sidmasslat": Tendency(
        f"{AMOUNT}lateral_melting", "melt at the sides", ("growth_melt_lateral",)
    ),
    "sidmassevapsubl": Tendency(
        "water_evapotranspiration_flux",
        "sublimation of ice, upwards",
        ("growth_sublimation",),
        sign=-1.0,
    ),
    "sidmassth": Tendency(f"{AMOUNT}sea_ice_thermodynamics", "growth less melt and sublimation"),
    "sidmassdyn": Tendency(
        f"{AMOUNT}sea_ice_dynamics", "change of simass less sidmassth: advection, sides, ridging"
    ),
    "sidconcth": Tendency(
        f"{SHARE}thermodynamics", "share of ice by growth and melt", (COVER,), units="s-1"
    ),
    "sidconcdyn": Tendency(
        f"{SHARE}dynamics",
        "change of siconc less sidconcth: advection, sides, ridging",
        units="s-1",
    ),
}
# What dynamics and thermodynamics share.
CHANGING = ("simass", "siconc")
# What a file of fields says of its grid.
FIXED = ("crs", "cell_area", "sea_area", "sea_area_fraction", "x_bnds", "y_bnds", "lat", "lon")


def growth_on_grid(places: Mapping[str, Array], room: Room) -> dict[str, Array]:
    """What the columns of a window made of ice, in the cells of a grid.

    Parameters
    ----------
    places : mapping
        As `floeflow.coupling.growth` makes them: x, y (m) and area (m2) of the columns as
        ``grown_...``, and terms (m3, m2), (n,) each.
    room : Room
        The grid and the sea in its cells.

    Returns
    -------
    dict of ndarray
        Sums of each term in the cells, (ny, nx): all of what there is at places that have a cell.
    """
    terms = {name: v for name, v in places.items() if not name.startswith("grown_")}
    area = places["grown_area"]
    some = np.any([values != 0.0 for values in terms.values()], axis=0) & (area > 0.0)
    if not some.any():
        return {name: np.zeros(room.area.shape) for name in terms}
    x, y, area = (places[f"grown_{name}"][some] for name in ("x", "y", "area"))
    values = {"area": area, **{name: v[some] for name, v in terms.items()}}
    radius = np.sqrt(area / np.pi)
    fields = [Field("area", "extensive", ROOM)]
    fields += [Field(name, "extensive", "area") for name in terms]
    near = near_cells(x, y, radius, room.target, room.target.pairs(x, y, room.reach))
    remapper = build_remapper(x, y, {"area": area}, room, radius=radius)
    carried = conservative_transfer(fields, values, remapper, near=near)
    return {name: _whole(carried.values[name], carried.missing[name]) for name in terms}


def _whole(cells: Array, missing: float) -> Array:
    """Sums in cells that get what crowded elements could not place, as they are filled."""
    size = np.abs(cells)
    total = float(size.sum())
    return cells + missing * size / total if total > 0.0 else cells


def window_tendencies(
    grown: Mapping[str, Array], change: tuple[Array, Array], sea: Array, seconds: float
) -> dict[str, Array]:
    """Tendencies of a window.

    Parameters
    ----------
    grown : mapping
        From `growth_on_grid`.
    change : tuple of ndarray
        By how much mass (kg/m2) and share of ice have changed per sea, (ny, nx) each.
    sea : ndarray
        Area of sea in the cells (m2), (ny, nx).
    seconds : float
        Length of the window.

    Returns
    -------
    dict of ndarray
        By CMIP6's names, those whose terms there are, (ny, nx); NaN where there is no sea.
    """
    per = np.where(sea > 0.0, 1.0 / (np.where(sea > 0.0, sea, 1.0) * seconds), np.nan)
    made: dict[str, Array] = {}
    for name, said in TENDENCIES.items():
        terms = [grown[term] for term in said.terms if term in grown]
        if terms:
            factor = ICE_DENSITY if said.units != "s-1" else 1.0
            made[name] = said.sign * factor * per * np.sum(terms, axis=0)
    growth = [values for term, values in grown.items() if term != COVER]
    made["sidmassth"] = ICE_DENSITY * per * np.sum(growth, axis=0)
    made["sidmassdyn"] = change[0] / seconds - made["sidmassth"]
    made["sidconcdyn"] = change[1] / seconds - made["sidconcth"]
    return made


def make_tendencies(
    scene: Scene, grid: Path, mask: xr.Dataset, snapshots: Iterable[xr.Dataset]
) -> xr.Dataset:
    """Tendencies of all windows of a run, with all that CF asks for.

    Parameters
    ----------
    scene : Scene
        Its domain is read.
    grid : Path
        Fields at all window boundaries, as `floeflow.diagnostics.cf_output` writes them.
    mask : xarray.Dataset
        Mask on the mask grid.
    snapshots : iterable of xarray.Dataset
        Elements at the ends of all windows, in order; read once.

    Returns
    -------
    xarray.Dataset
        On (time, y, x), time being the middle of each window; encodings included.

    Raises
    ------
    FloeError
        Where the files are not of one run.
    """
    fields = read_grid(grid)
    for name in ("simass", "sea_area"):
        if name not in fields:
            raise FloeError(f"{grid}: variable '{name}' is missing")
    sea = np.nan_to_num(fields["sea_area"].values)
    windows, times = fields["window"].values, fields["time"].values
    made: dict[str, list[Array]] = {}
    for k, (number, grown) in enumerate(_on_grid(snapshots, fields, mask)):
        if k + 1 >= len(windows) or windows[k + 1] != number:
            raise FloeError(f"{grid}: it does not hold the end of window {number}")
        mass, share = (np.diff(fields[name].values[k : k + 2], axis=0)[0] for name in CHANGING)
        found = window_tendencies(grown, (mass, share), sea, float(times[k + 1] - times[k]))
        for name, values in found.items():
            made.setdefault(name, []).append(values)
    return _described(scene, fields, made)


def _on_grid(
    snapshots: Iterable[xr.Dataset], fields: xr.Dataset, mask: xr.Dataset
) -> Iterator[tuple[int, dict[str, Array]]]:
    """Number of each window, and what its columns made of ice in the cells."""
    target = Grid(fields["x"].values, fields["y"].values)
    rooms: dict[int, Room] = {}
    for state in snapshots:
        room = room_of(state, mask, target, rooms)
        names = [name for name, v in state.data_vars.items() if v.dims == ("grown",)]
        places = {str(name): state[name].values for name in names}
        yield int(state.attrs["window"]), growth_on_grid(places, room)


def _described(scene: Scene, fields: xr.Dataset, made: Mapping[str, list[Array]]) -> xr.Dataset:
    """The tendencies with attributes, axes and encodings."""
    edges = fields["time"].values
    bounds = np.stack([edges[:-1], edges[1:]], axis=1)
    axes = {name: fields[name] for name in ("y", "x")}
    time = dict(fields["time"].attrs) | {"long_name": "middle of the window", "bounds": "time_bnds"}
    data = xr.Dataset(coords={"time": ("time", bounds.mean(axis=1), time), **axes})
    data["time_bnds"] = (("time", "bnds"), bounds)
    for name in FIXED:
        if name in fields:
            data[name] = fields[name]
            data[name].attrs.pop("coordinates", None)
    data = data.set_coords([name for name in ("lat", "lon") if name in data])
    number = fields["window"].values[1:]
    data["window"] = ("time", number, dict(fields["window"].attrs))
    for name, values in made.items():
        described = TENDENCIES[name]
        data[name] = (("time", "y", "x"), np.stack(values))
        data[name].attrs = {"standard_name": described.standard_name}
        data[name].attrs |= field_attributes(described.long_name, described.units, METHOD)
    title = f"Tendencies of the sea ice of scene {scene.name}"
    history = "from the columns to the grid (floeflow.diagnostics.gridded_tendencies)"
    data.attrs = file_attributes(scene, title, history)
    for name in map(str, data.variables):
        filled = name in TENDENCIES
        data[name].encoding = {"_FillValue": MISSING if filled else None}
        if data[name].ndim >= 2:
            data[name].encoding |= {"zlib": True, "complevel": 4}
        if filled:
            data[name].encoding["coordinates"] = "lat lon"
    return data
