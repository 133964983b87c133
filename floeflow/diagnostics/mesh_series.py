# SPDX-License-Identifier: GPL-2.0-or-later
"""Meshes of the elements' cells at all window boundaries, for ParaView.

Each element is drawn as its cell of the packing, carried and turned with it, so that leads show as
gaps; elements without a cell, as those of the coast, are drawn as their discs. Bonds are the lines
along which they hold.
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
