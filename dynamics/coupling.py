# SPDX-License-Identifier: GPL-2.0-or-later
"""The column's share of a window: every rank takes a slice of the elements.

A column knows nothing of its neighbours, so slices give the same bits on any number of ranks.
"""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import xarray as xr
from mpi4py import MPI

from floeflow.column.forcing import column_sampler, sample_series
from floeflow.column.params import ColumnParams
from floeflow.column.state import ColumnFluxes, ColumnState, column_energy
from floeflow.column.window import advance_window
from floeflow.config import Scene
from floeflow.dynamics.collective import on_all
from floeflow.dynamics.elements import Arrays
from floeflow.dynamics.motion import engine_params
from floeflow.dynamics.refreeze import Cold, refreeze
from floeflow.state.schema import MOBILE

Budget = dict[str, float]


def column_params(scene: Scene) -> ColumnParams:
    """Constants of the scene's columns."""
    return ColumnParams(
        new_ice_thickness=scene.column.new_ice_thickness,
        ocean_salinity=scene.column.ocean_salinity,
    )


def column_state(state: xr.Dataset, rows: np.ndarray) -> ColumnState:
    """Columns of some elements of a state."""
    names = [field.name for field in fields(ColumnState)]
    return ColumnState(**{name: state[name].values[rows].copy() for name in names})


def advance_columns(
    comm: MPI.Comm,
    scene: Scene,
    state: xr.Dataset,
    forcing: xr.Dataset,
    window: tuple[float, float],
) -> tuple[xr.Dataset, Budget]:
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

    Returns
    -------
    tuple of xarray.Dataset and dict
        State with new columns; terms of the budgets, integrated over the elements' areas:
        ``growth_<term>`` (m3 of ice), ``snow_<term>`` (m3 of snow), ``energy_<term>`` (J).
    """
    params = column_params(scene)
    mobile = np.flatnonzero(state["type"].values == MOBILE)
    mine = np.array_split(mobile, comm.size)[comm.rank]
    before = column_state(state, mine)

    def advance() -> tuple[ColumnState, ColumnFluxes]:
        sample = column_sampler(forcing, state["x"].values[mine], state["y"].values[mine])
        step, scheme = scene.column.step, scene.column.scheme
        return advance_window(before, sample, *window, step, params, scheme)

    after, fluxes = on_all(comm, advance)
    result = state.copy()
    for field in fields(ColumnState):
        whole = state[field.name].values.copy()
        whole[mobile] = np.concatenate(comm.allgather(getattr(after, field.name)))
        result[field.name] = (state[field.name].dims, whole)
    # Integrated on the whole arrays, so that the sums are the same on any number of ranks.
    parts = {
        field.name: np.concatenate(comm.allgather(getattr(fluxes, field.name)))
        for field in fields(ColumnFluxes)
    }
    budget = _integrate(ColumnFluxes(**parts), state["area"].values[mobile])
    start = column_energy(column_state(state, mobile), params)
    end = column_energy(column_state(result, mobile), params)
    budget["energy_stored"] = float(state["area"].values[mobile] @ (end - start))
    return result, budget


def freeze_window(
    scene: Scene,
    state: xr.Dataset,
    touched: Arrays,
    forcing: xr.Dataset,
    window: tuple[float, float],
) -> tuple[xr.Dataset, int]:
    """Let cracks and contacts of a window refreeze; see `floeflow.dynamics.refreeze`.

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


# How each flux enters the budgets, and with which sign.
_ICE_TERMS = {
    "growth_base": 1.0,
    "new_ice": 1.0,
    "melt_top": -1.0,
    "melt_base": -1.0,
    "melt_lateral": -1.0,
    "sublimation_ice": -1.0,
}
_SNOW_TERMS = {"snowfall": 1.0, "snow_melt": -1.0, "sublimation_snow": -1.0}
_ENERGY_TERMS = {
    "energy_atmosphere": 1.0,
    "energy_ocean": 1.0,
    "energy_snowfall": 1.0,
    "energy_to_ocean": -1.0,
}


def _integrate(fluxes: ColumnFluxes, area: np.ndarray) -> Budget:
    budget = {}
    for name, sign in _ICE_TERMS.items():
        term = name.removeprefix("growth_").removesuffix("_ice") if name != "new_ice" else name
        budget[f"growth_{term}"] = sign * float(area @ getattr(fluxes, name).sum(axis=1))
    for name, sign in _SNOW_TERMS.items():
        term = name.removeprefix("snow_").removesuffix("_snow")
        budget[f"snow_{term}"] = sign * float(area @ getattr(fluxes, name).sum(axis=1))
    for name, sign in _ENERGY_TERMS.items():
        budget[name] = sign * float(area @ getattr(fluxes, name))
    return budget
