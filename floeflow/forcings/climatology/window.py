# SPDX-License-Identifier: GPL-2.0-or-later
"""The climatology over a coupling window, on the scene's grid and along its axes."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.core.grids import scene_crs, scene_grid, to_lonlat
from floeflow.core.times import window_span
from floeflow.core.vectors import east_north_to_map, north_angle
from floeflow.forcings.climatology.fields import fields
from floeflow.forcings.fixed_fields import FIXED
from floeflow.scene.blocks import Scene
from floeflow.scene.effects import forcing_variables

Array = NDArray[np.float64]


def scene_fields(scene: Scene, time: Array, names: Iterable[str]) -> dict[str, Array]:
    """Variables of the forcing on the scene's grid, vectors along its axes.

    Parameters
    ----------
    scene : Scene
        Its domain, start, climatology and mixed layer are read.
    time : ndarray
        Seconds since its start, (n,).
    names : iterable of str
        Of `floeflow.forcings.climatology.NAMES`; others are left out.

    Returns
    -------
    dict of ndarray
        (n, places) each.
    """
    grid, crs = scene_grid(scene.domain), scene_crs(scene.domain)
    lon, lat = (each.ravel() for each in to_lonlat(crs, *grid.mesh()))
    settings, depth = scene.forcing.climatology, scene.column.mixed_layer_depth
    found = fields(lon, lat, scene.time.start, time, names, settings, depth)
    angle = north_angle(crs, lon, lat)
    for name in ("wind", "ocean"):
        if f"{name}_u" in found:
            turned = east_north_to_map(found[f"{name}_u"], found[f"{name}_v"], angle)
            found[f"{name}_u"], found[f"{name}_v"] = turned
    return found


def window_forcing(scene: Scene, window: int, units: dict[str, str]) -> xr.Dataset:
    """Forcing of a window.

    Parameters
    ----------
    scene : Scene
        Its domain, forcing, time and effects are read.
    window : int
        From 1.
    units : dict of str
        Of each variable, vectors without ``_u`` and ``_v``.

    Returns
    -------
    xarray.Dataset
        As `floeflow.forcings.forcing.make_forcing` makes it.
    """
    grid = scene_grid(scene.domain)
    first, last = window_span(window, scene.time.window)
    count = max(1, round((last - first) / scene.forcing.step))
    time = np.linspace(first, last, count + 1)
    needed = forcing_variables(scene.effects)
    found = scene_fields(scene, time, needed)
    data: dict[str, tuple[tuple[str, ...], np.ndarray, dict[str, str]]] = {}
    for name in needed:
        unit = {"units": units[name.removesuffix("_u").removesuffix("_v")]}
        if name in FIXED:
            data[name] = (("y", "x"), FIXED[name][0](scene).reshape(grid.shape), unit)
        else:
            values = found[name].reshape(len(time), *grid.shape)
            data[name] = (("time", "y", "x"), np.ascontiguousarray(values), unit)
    coords = {
        "time": ("time", time, {"units": "s", "long_name": "time since the scene's start"}),
        "x": ("x", grid.x, {"units": "m"}),
        "y": ("y", grid.y, {"units": "m"}),
    }
    return xr.Dataset(data, coords=coords, attrs={"crs": scene.domain.crs})
