# SPDX-License-Identifier: GPL-2.0-or-later
"""The column's share of a window: every rank takes a slice of the elements.

A column knows nothing of its neighbours, so slices give the same bits on any number of ranks.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import xarray as xr
from mpi4py import MPI

from floeflow.column.forcing import sample_series
from floeflow.column.params import ColumnParams, zero_layer_params
from floeflow.column.schemes import advance_columns as advance_slice
from floeflow.column.settings import column_settings
from floeflow.column.shortwave.sun import day_of_year, sun_height
from floeflow.core.collective import on_all
from floeflow.core.grids import scene_crs, to_lonlat
from floeflow.dynamics.bonds.refreeze import Cold, refreeze
from floeflow.dynamics.motion import engine_params
from floeflow.scene import Scene
from floeflow.scene.effects import column_forcing_variables, column_variables
from floeflow.state.elements import Arrays
from floeflow.state.schema import MOBILE

Budget = dict[str, float]


def column_params(scene: Scene) -> ColumnParams:
    """Constants of zero-layer ice in the scene."""
    return zero_layer_params(column_settings(scene))


def forcing_sampler(
    scene: Scene, state: xr.Dataset, forcing: xr.Dataset, rows: np.ndarray
) -> Callable[[float], dict[str, np.ndarray]]:
    """Forcing of some elements as a function of time.

    With a mixed layer and ocean drag the ice's drift against the current gives the friction
    velocity under it, sqrt(C_w) |u_w - u|, with the velocity at the window's end.
    """
    names = column_forcing_variables(scene.effects)
    rubs = "mixed_layer" in scene.effects and "ocean_drag" in scene.effects
    names = (*names, "ocean_u", "ocean_v") if rubs else names
    u, v, x, y = (state[name].values[rows] for name in "uvxy")
    series = sample_series(forcing, names, x, y)
    lit = column_settings(scene).needs_sun
    lon, lat = to_lonlat(scene_crs(scene.domain), x, y) if lit else (x, y)

    def sample(t: float) -> dict[str, np.ndarray]:
        values = series(t)
        if rubs:
            slip = np.hypot(values.pop("ocean_u") - u, values.pop("ocean_v") - v)
            values["friction_velocity"] = np.sqrt(scene.dynamics.ocean_drag) * slip
        if lit:
            values["sun_height"] = sun_height(day_of_year(scene.time.start, t), lat, lon)
        return values

    return sample


def advance_columns(
    comm: MPI.Comm,
    scene: Scene,
    state: xr.Dataset,
    forcing: xr.Dataset,
    window: tuple[float, float],
    first_area: np.ndarray,
) -> tuple[xr.Dataset, Arrays]:
    """Advance the columns of all mobile elements over a window.

    Parameters
    ----------
    comm : MPI.Comm
        Collective; every rank has the whole state and gets the whole result.
    scene : Scene
        The scene.
    state : xarray.Dataset
        State after the dynamics of the window.
    forcing : xarray.Dataset
        The window's forcing on the scene's grid.
    window : tuple of float
        Start and end of the window, s since the scene's start.
    first_area : ndarray
        Areas of the elements before the window's ridging (m2), (n,).

    Returns
    -------
    tuple of xarray.Dataset and dict
        State with new columns; terms of the budgets of each mobile element, over its area:
        ``growth_<term>`` (m3 of ice), ``snow_<term>`` (m3 of snow), ``energy_<term>`` (J),
        ``water_<term>`` and ``salt_<term>`` (kg), (n,). `totals` adds them up.
    """
    settings = column_settings(scene)
    names = column_variables(scene.effects, settings.scheme)
    mobile = np.flatnonzero(state["type"].values == MOBILE)
    mine = np.array_split(mobile, comm.size)[comm.rank]
    before = {name: state[name].values[mine] for name in names}
    closed = None
    if "redistribution" in scene.effects:
        closed = 1.0 - state["area"].values[mine] / first_area[mine]

    def advance() -> tuple[Arrays, Arrays]:
        sample = forcing_sampler(scene, state, forcing, mine)
        return advance_slice(before, sample, window, settings, closed)

    after, terms = on_all(comm, advance)
    result = state.copy()
    for name in names:
        whole = state[name].values.copy()
        whole[mobile] = np.concatenate(comm.allgather(after[name]))
        result[name] = (state[name].dims, whole)
    area = state["area"].values[mobile]
    each = {name: area * np.concatenate(comm.allgather(values)) for name, values in terms.items()}
    return result, each


def totals(each: Arrays) -> Budget:
    """Terms of the budgets over all elements.

    Added up on the whole arrays, so that the sums are the same on any number of ranks.
    """
    return {name: float(values.sum()) for name, values in each.items()}


def freeze_window(
    scene: Scene,
    state: xr.Dataset,
    touched: Arrays,
    forcing: xr.Dataset,
    window: tuple[float, float],
) -> tuple[xr.Dataset, int]:
    """Let cracks and contacts of a window refreeze; see `floeflow.dynamics.bonds.refreeze`.

    Parameters
    ----------
    scene : Scene
        The scene.
    state : xarray.Dataset
        State after the dynamics and the column of the window.
    touched : dict of ndarray
        Contact table at the window's start.
    forcing : xarray.Dataset
        The window's forcing on the scene's grid.
    window : tuple of float
        Start and end of the window, s since the scene's start.

    Returns
    -------
    tuple of xarray.Dataset and int
        New state, and the number of bonds that formed.
    """
    ice, d = column_params(scene), scene.dynamics
    growth = 2.0 * ice.ice_conductivity / (ice.ice_density * ice.latent_fusion)
    cold = Cold(
        *(d.refreeze_time, d.refreeze_temperature, d.refreeze_thickness),
        *(ice.freezing_temperature, growth, scene.packing.coast_bonds),
    )

    def air(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        sample = sample_series(forcing, ("air_temperature",), x, y)
        return sample(0.5 * (window[0] + window[1]))["air_temperature"]

    return refreeze(state, touched, air, cold, engine_params(scene), window[1] - window[0])
