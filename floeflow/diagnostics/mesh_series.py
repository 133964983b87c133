# SPDX-License-Identifier: GPL-2.0-or-later
"""Meshes of the elements' cells and discs, of bonds and of the grid, for ParaView.

Each element is drawn as its cell of the packing, carried and turned with it, so that leads show as
gaps; elements without a cell, as those of the coast, are drawn as their discs. Discs are points
with their radius, as contacts see them, bonds the lines along which they hold, the grid its cells.
"""

import logging
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.core.period import period_of, shortest
from floeflow.core.polygons import Outlines, body_outlines, carried_outlines, own_outlines
from floeflow.scene.windows import window_name
from floeflow.state.bonds import element_rows, lines_in_space
from floeflow.state.elements import pair_arrays

log = logging.getLogger(__name__)

Array = NDArray[np.float64]


def cell_fields(state: xr.Dataset) -> dict[str, NDArray[np.generic]]:
    """Fields of a state's elements, by the names under which ParaView shows them.

    Parameters
    ----------
    state : xarray.Dataset
        State at a window boundary.

    Returns
    -------
    dict of ndarray
        (element,), or (element, 3) for vectors: id, type, area (m2), ice_fraction (1), thickness
        (m over the ice), speed and velocity (m/s), spin (rad/s); with thermodynamics
        snow_thickness (m over the ice) and surface_temperature (K, mean over the ice). What is
        per ice is NaN where there is none.
    """
    fraction = state["ice_fraction"].values
    total = fraction.sum(axis=1)

    def per_ice(amount: Array) -> Array:
        summed = amount.sum(axis=1)
        return np.divide(summed, total, out=np.full_like(total, np.nan), where=total > 0)

    u, v = state["u"].values, state["v"].values
    fields = {
        "id": state["id"].values,
        "type": state["type"].values,
        "area": state["area"].values,
        "ice_fraction": total,
        "thickness": per_ice(state["ice_volume"].values),
        "speed": np.hypot(u, v),
        "velocity": np.stack([u, v, np.zeros_like(u)], axis=1),
        "spin": state["omega"].values,
    }
    if "snow_volume" in state:
        fields["snow_thickness"] = per_ice(state["snow_volume"].values)
    if "surface_temperature" in state:
        fields["surface_temperature"] = per_ice(fraction * state["surface_temperature"].values)
    return fields


def write_meshes(packing: xr.Dataset, states: Iterable[xr.Dataset], folder: Path) -> list[Path]:
    """Write a mesh for each state, and ``elements.pvd``, which names them with their times.

    Parameters
    ----------
    packing : xarray.Dataset
        Packing from which the first state was made.
    states : iterable of xarray.Dataset
        States, the first one before all windows; read once.
    folder : Path
        Gets the files, each mesh named by its window.

    Returns
    -------
    list of Path
        The meshes.

    Raises
    ------
    FloeError
        Where there are no elements, states do not fit the packing, or a file cannot be written.
    """
    # meshio takes 0.2 s to import.
    from floeflow.core.meshes import write_polygons, write_series

    body: Outlines | None = None
    paths, times = [], []
    for state in states:
        if "cell_corners" in state:
            body = own_outlines(state)
        else:
            body = body_outlines(packing, state) if body is None else body
        outlines = carried_outlines(body, state)
        path = folder / f"{window_name(int(state.attrs['window']))}.vtu"
        write_polygons(path, outlines.start, outlines.x, outlines.y, cell_fields(state))
        paths.append(path)
        times.append(float(state.attrs["time"]))
    write_series(folder / "elements.pvd", [path.name for path in paths], times)
    return paths


def bond_lines(state: xr.Dataset) -> Array:
    """Ends of the bonds' glue lines where the elements of the lower ids are (m), (bond, end, 2).

    Parameters
    ----------
    state : xarray.Dataset
        A state with bonds.

    Returns
    -------
    ndarray
        m, (bond, end, 2).
    """
    row = element_rows(state["id"].values, state["bond_id_lo"].values)
    x, y, theta = (state[name].values[row] for name in ("x", "y", "theta"))
    return lines_in_space(pair_arrays(state, "bond"), x, y, theta)


def bond_fields(state: xr.Dataset) -> dict[str, NDArray[np.generic]]:
    """Fields of a state's bonds, by the names under which ParaView shows them.

    Parameters
    ----------
    state : xarray.Dataset
        A state with bonds.

    Returns
    -------
    dict of ndarray
        (bond,): id_lo, id_hi, length and thickness (m), crack (share of the line, from both
        ends), stretch (distance of the centres over that when it froze, less 1).
    """
    lo, hi = (element_rows(state["id"].values, state[f"bond_id_{e}"].values) for e in ("lo", "hi"))
    way = [state[axis].values[hi] - state[axis].values[lo] for axis in "xy"]
    apart = np.hypot(*shortest((way[0], way[1]), period_of(state.attrs)))
    crack = state["bond_crack_a"].values + state["bond_crack_b"].values
    return {
        "id_lo": state["bond_id_lo"].values,
        "id_hi": state["bond_id_hi"].values,
        "length": state["bond_length"].values,
        "thickness": state["bond_thickness"].values,
        "crack": np.minimum(crack, 1.0),
        "stretch": apart / state["bond_span"].values - 1.0,
    }


def write_bonds(states: Iterable[xr.Dataset], folder: Path) -> list[Path]:
    """Write the bonds of each state, and ``bonds.pvd``, which names the files with their times.

    Parameters
    ----------
    states : iterable of xarray.Dataset
        Whole states; those without bonds make no file. Read once.
    folder : Path
        Gets the files, ``bonds_<window>.vtu``.

    Returns
    -------
    list of Path
        The meshes; none and no collection where no state has bonds.

    Raises
    ------
    FloeError
        Where a file cannot be written.
    """
    from floeflow.core.meshes import write_lines, write_series

    paths, times = [], []
    for state in states:
        if "bond_id_lo" not in state or not state.sizes["bond"]:
            continue
        path = folder / f"bonds_{window_name(int(state.attrs['window']))}.vtu"
        write_lines(path, bond_lines(state), bond_fields(state))
        paths.append(path)
        times.append(float(state.attrs["time"]))
    if paths:
        write_series(folder / "bonds.pvd", [path.name for path in paths], times)
    return paths


def write_discs(states: Iterable[xr.Dataset], folder: Path) -> list[Path]:
    """Write the discs of each state as points, and ``discs.pvd``, which names the files.

    Parameters
    ----------
    states : iterable of xarray.Dataset
        States or snapshots; read once.
    folder : Path
        Gets the files, ``discs_<window>.vtu``, with the fields of the cells, ``radius`` (m) and
        ``orientation`` (rad).

    Returns
    -------
    list of Path
        The meshes.

    Raises
    ------
    FloeError
        Where a file cannot be written.
    """
    from floeflow.core.meshes import write_points, write_series

    paths, times = [], []
    for state in states:
        path = folder / f"discs_{window_name(int(state.attrs['window']))}.vtu"
        own = {"radius": state["radius"].values, "orientation": state["theta"].values}
        write_points(path, state["x"].values, state["y"].values, cell_fields(state) | own)
        paths.append(path)
        times.append(float(state.attrs["time"]))
    write_series(folder / "discs.pvd", [path.name for path in paths], times)
    return paths


def grid_fields(grid: xr.Dataset, time: int) -> dict[str, NDArray[np.generic]]:
    """Fields of the grid at one time, row by row, by their names in ``grid.nc``.

    Parameters
    ----------
    grid : xarray.Dataset
        Fields on (time, y, x), on (y, x), and by thickness on (time, iceband, y, x).
    time : int
        Index of the time.

    Returns
    -------
    dict of ndarray
        (cell,), or (cell, iceband); and ``velocity`` (m/s), (cell, 3), where the grid has both
        components.
    """
    fields: dict[str, NDArray[np.generic]] = {}
    for name, variable in grid.data_vars.items():
        if variable.dims[-2:] != ("y", "x") or variable.dtype.kind not in "fiu":
            continue
        here = variable.isel(time=time) if "time" in variable.dims else variable
        if here.ndim == 2:
            fields[str(name)] = here.values.ravel()
        elif here.ndim == 3:
            fields[str(name)] = np.moveaxis(here.values, 0, -1).reshape(-1, here.shape[0])
    if {"siu", "siv"} <= set(fields):
        u, v = fields["siu"], fields["siv"]
        fields["velocity"] = np.stack([u, v, np.zeros_like(u)], axis=1)
    return fields


def write_grids(grid: xr.Dataset, folder: Path) -> list[Path]:
    """Write the grid's cells with their fields at each time, and ``grid.pvd``.

    Parameters
    ----------
    grid : xarray.Dataset
        As ``grid.nc`` has it: ``x`` and ``y`` (m) with their bounds, ``time`` (s), ``window``.
    folder : Path
        Gets the files, ``grid_<window>.vtu``.

    Returns
    -------
    list of Path
        The meshes.

    Raises
    ------
    FloeError
        Where a file cannot be written.
    """
    from floeflow.core.meshes import write_cells, write_series

    edges = []
    for axis in "xy":
        # Of a grid whose axis falls, the rows are turned with the values.
        grid = grid.sortby(axis)
        bounds = grid[f"{axis}_bnds"].values
        edges.append(np.append(bounds.min(axis=1), bounds.max()))
    paths, times = [], []
    for k, time in enumerate(grid["time"].values.astype(float)):
        path = folder / f"grid_{window_name(int(grid['window'].values[k]))}.vtu"
        write_cells(path, edges[0], edges[1], grid_fields(grid, k))
        paths.append(path)
        times.append(float(time))
    write_series(folder / "grid.pvd", [path.name for path in paths], times)
    return paths
