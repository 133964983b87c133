# SPDX-License-Identifier: GPL-2.0-or-later
"""Meshes of the elements' cells at all window boundaries, for ParaView.

Each element is drawn as its cell of the packing, carried and turned with it, so that leads show as
gaps; elements without a cell, as those of the coast, are drawn as their discs.
"""

import logging
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.core.polygons import Outlines, body_outlines, carried_outlines, own_outlines
from floeflow.scene.windows import window_name

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
