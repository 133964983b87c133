# SPDX-License-Identifier: GPL-2.0-or-later
"""What a window gives to ocean and air, on the scene's grid: the way back to a coupled model.

Each element's totals of the window are spread over points of its disc, and each point over the
four cells around it with the weights by which the forcing is read there: with ``forcing.at: cell``
the transpose of the way in.
What the elements gave is what the cells get, to round-off; what lies beyond the scene's
rectangle is told apart. Names are CF's; fluxes are means over the window and over the cell.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.core.discs import disc_places
from floeflow.core.grids import Grid, cell_area, scene_crs, scene_grid, to_lonlat
from floeflow.coupling.sea.birth import OpenIce
from floeflow.scene import Scene
from floeflow.state.schema import MOBILE

Array = NDArray[np.float64]
Index = NDArray[np.int64]

# Variables: units, CF standard name (empty where CF has none), long name.
FIELDS: dict[str, tuple[str, str, str]] = {
    "tau_x_ocean": (
        "Pa",
        "downward_x_stress_at_sea_ice_base",
        "stress of the ice on the ocean along x",
    ),
    "tau_y_ocean": (
        "Pa",
        "downward_y_stress_at_sea_ice_base",
        "stress of the ice on the ocean along y",
    ),
    "tau_x_air": ("Pa", "surface_downward_x_stress", "stress of the air on the ice along x"),
    "tau_y_air": ("Pa", "surface_downward_y_stress", "stress of the air on the ice along y"),
    "heat_ocean": (
        "W m-2",
        "heat_flux_into_sea_water_due_to_sea_ice_thermodynamics",
        "heat that the ocean gets; negative: that it gave to the ice",
    ),
    "heat_air": ("W m-2", "", "heat that ice and leads got from the air, radiation included"),
    "light_ocean": (
        "W m-2",
        "downwelling_shortwave_flux_in_sea_water_at_sea_ice_base",
        "short wave through the ice and in leads, part of the heat from the air",
    ),
    "water_ocean": (
        "kg m-2 s-1",
        "water_flux_into_sea_water_due_to_sea_ice_thermodynamics",
        "fresh water that the ocean gets by melt; negative: by growth",
    ),
    "salt_ocean": (
        "kg m-2 s-1",
        "downward_sea_ice_basal_salt_flux",
        "salt that the ocean gets by growth and drainage",
    ),
}
# Units of a flux times area and time.
TOTAL_UNITS = {"Pa": "N s", "W m-2": "J", "kg m-2 s-1": "kg"}
# How a flux is made from the sums of elements and columns: names and signs.
SUMS: dict[str, tuple[tuple[str, float], ...]] = {
    "tau_x_ocean": (("ocean_impulse_x", -1.0),),
    "tau_y_ocean": (("ocean_impulse_y", -1.0),),
    "tau_x_air": (("wind_impulse_x", 1.0),),
    "tau_y_air": (("wind_impulse_y", 1.0),),
    "heat_ocean": (("energy_ocean", -1.0), ("energy_to_ocean", -1.0)),
    "heat_air": (("energy_atmosphere", 1.0),),
    "light_ocean": (("light_to_sea", 1.0),),
    "water_ocean": (("water_ocean", -1.0),),
    "salt_ocean": (("salt_ocean", -1.0),),
}


def spread(grid: Grid, x: Array, y: Array, area: Array, totals: Array) -> tuple[Array, Array]:
    """Spread totals of elements over the cells of a grid.

    Parameters
    ----------
    grid : Grid
        The scene grid.
    x, y : ndarray
        Centres of the elements (m), (n,).
    area : ndarray
        Their areas (m2), (n,).
    totals : ndarray
        What they hold, (k, n).

    Returns
    -------
    cells : ndarray
        What the cells get, (k, ny, nx).
    outside : ndarray
        What lies beyond the grid's rim, (k,).
    """
    dx, dy = disc_places()
    radius = np.sqrt(area / np.pi)[:, None]
    px, py = x[:, None] + radius * dx, y[:, None] + radius * dy
    edges = grid.x_edges, grid.y_edges
    inside = (px >= edges[0][0]) & (px <= edges[0][-1])
    inside &= (py >= edges[1][0]) & (py <= edges[1][-1])
    columns, east = _between(grid.x, px)
    rows, north = _between(grid.y, py)
    ny, nx = grid.shape
    cells = np.zeros((len(totals), ny * nx))
    each = totals / dx.size
    for row, column, weight in (
        (rows, columns, (1 - north) * (1 - east)),
        (rows, columns + 1, (1 - north) * east),
        (rows + 1, columns, north * (1 - east)),
        (rows + 1, columns + 1, north * east),
    ):
        part = np.where(inside, weight, 0.0)
        place = (row * nx + column).ravel()
        for k, values in enumerate(each):
            cells[k] += np.bincount(place, (values[:, None] * part).ravel(), ny * nx)
    outside = (each * (~inside).sum(axis=1)).sum(axis=1)
    return cells.reshape(len(totals), ny, nx), outside


def _between(axis: Array, places: Array) -> tuple[Index, Array]:
    """Lower node of each place, and its share of the way to the next; the rim's hold beyond."""
    low = np.clip(np.searchsorted(axis, places, side="right") - 1, 0, axis.size - 2)
    share = (places - axis[low]) / (axis[low + 1] - axis[low])
    return low.astype(np.int64), np.clip(share, 0.0, 1.0)


def window_fluxes(
    scene: Scene,
    state: xr.Dataset,
    sums: Mapping[str, Array],
    window: tuple[float, float],
    open_water: Sequence[OpenIce] = (),
) -> xr.Dataset:
    """Fluxes of a window on the scene grid.

    Parameters
    ----------
    scene : Scene
        The scene.
    state : xarray.Dataset
        Elements at the window's end, before they are merged or remapped.
    sums : mapping of str to ndarray
        What each mobile element gave or got in the window: impulses (N s), and terms of the
        column times its area (J, kg), (n,).
    window : tuple of float
        Start and end (s since the scene's start).
    open_water : sequence of OpenIce
        With a mixed layer the open water of the cells, each time that columns were advanced: its
        terms are added to its cells.

    Returns
    -------
    xarray.Dataset
        The variables of `FIELDS` that the scene has on (time, y, x), time the window's middle with
        bounds; ``<name>_outside``: the window's total of what lies beyond the rectangle (N s, J,
        kg).
    """
    grid = scene_grid(scene.domain)
    mobile = state["type"].values == MOBILE
    x, y, area = (state[name].values[mobile] for name in ("x", "y", "area"))
    made = {
        name: sum(sign * np.asarray(sums[part]) for part, sign in parts if part in sums)
        for name, parts in SUMS.items()
        if any(part in sums for part, _ in parts)
    }
    totals = np.array(list(made.values())).reshape(len(made), -1)
    cells, outside = spread(grid, x, y, area, totals)
    for water in open_water:
        for k, name in enumerate(made):
            for part, sign in SUMS[name]:
                if part in water.terms:
                    np.add.at(cells[k].reshape(-1), water.cells, sign * water.terms[part])
    per = (window[1] - window[0]) * cell_area(grid, scene_crs(scene.domain))
    data = xr.Dataset()
    for name, total, beyond in zip(made, cells, outside, strict=True):
        unit, standard, text = FIELDS[name]
        attrs = {"units": unit, "long_name": text, "cell_methods": "area: time: mean"}
        attrs |= {"standard_name": standard} if standard else {}
        attrs |= {"grid_mapping": "crs", "cell_measures": "area: cell_area"}
        data[name] = (("time", "y", "x"), (total / per)[None], attrs)
        whole = f"beyond the grid, over the window: {text}"
        data[f"{name}_outside"] = (
            *(("time",), [beyond]),
            {"long_name": whole, "units": TOTAL_UNITS[unit], "cell_methods": "time: sum"},
        )
    since = f"seconds since {scene.time.start.isoformat(sep=' ')}"
    time = {"units": since, "calendar": "standard", "standard_name": "time", "axis": "T"}
    time |= {"bounds": "time_bounds"}
    data["time_bounds"] = (("time", "bound"), [list(window)])
    area = {"units": "m2", "standard_name": "cell_area", "grid_mapping": "crs"}
    data["cell_area"] = (("y", "x"), per / (window[1] - window[0]), area)
    crs = scene_crs(scene.domain)
    data["crs"] = ((), np.int32(0), crs.to_cf())
    lon, lat = to_lonlat(crs, *grid.mesh())
    data = data.assign_coords(
        time=("time", [0.5 * (window[0] + window[1])], time),
        x=("x", grid.x, {"units": "m", "standard_name": "projection_x_coordinate", "axis": "X"}),
        y=("y", grid.y, {"units": "m", "standard_name": "projection_y_coordinate", "axis": "Y"}),
        lat=(("y", "x"), lat, {"standard_name": "latitude", "units": "degrees_north"}),
        lon=(("y", "x"), lon, {"standard_name": "longitude", "units": "degrees_east"}),
    )
    data.attrs = {"Conventions": "CF-1.10", "crs": scene.domain.crs}
    return data


def join_fluxes(parts: Sequence[xr.Dataset]) -> xr.Dataset:
    """Fluxes of consecutive windows, as they were written, in one dataset.

    Parameters
    ----------
    parts : sequence of xarray.Dataset
        In the order of time.

    Returns
    -------
    xarray.Dataset
        All times behind each other; what has no time is that of the first part.
    """
    fixed = [name for name, item in parts[0].data_vars.items() if "time" not in item.dims]
    joined = xr.concat([part.drop_vars(fixed) for part in parts], "time", join="exact")
    joined.attrs.pop("window", None)
    return joined.merge(parts[0][fixed])
