# SPDX-License-Identifier: GPL-2.0-or-later
"""The time series and budgets of one window."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from floeflow.column.settings import column_settings
from floeflow.coupling.sea.water import read_water

if TYPE_CHECKING:
    from floeflow.coupling.sea.places import SeaPlaces
    from floeflow.dynamics.motion import Motion
    from floeflow.scene import Scene

UNITS = {
    "time": "s",
    "kinetic_energy": "J",
    "elastic_energy": "J",
    "intact_bonds": "1",
    "drift_speed": "m s-1",
    "largest_speed": "m s-1",
}
PREFIX_UNITS = {
    "momentum_": "kg m s-1",
    "impulse_": "N s",
    "work_": "J",
    "dissipation_": "J",
    "ice_area_": "m2",
    "ridged_": "m2",
    "bonds_": "1",
    "ice_volume_": "m3",
    "snow_volume_": "m3",
    "growth_": "m3",
    "snow_": "m3",
    "energy_": "J",
    "water_": "kg",
    "light_": "J",
    "salt_": "kg",
    "temperature_": "1",
    "pond_": "m3",
    "remap_momentum_": "kg m s-1",
    "remap_energy": "J",
    "remap_": "1",
    "merge_momentum_": "kg m s-1",
    "merge_energy": "J",
    "merge_": "1",
    "wall_force_": "N",
    "sea_heat_": "J",
    "sea_salt_": "kg",
    "sea_joined": "m2",
    "sea_melted_back": "m3",
    "sea_": "1",
    "export_ice_area_": "m2",
    "export_ice_volume_": "m3",
    "export_snow_volume_": "m3",
    "export_energy_": "J",
    "export_water_": "kg",
    "export_salt_": "kg",
    "export_": "1",
    "inflow_ice_area_": "m2",
    "inflow_ice_volume_": "m3",
    "inflow_snow_volume_": "m3",
    "inflow_energy_": "J",
    "inflow_water_": "kg",
    "inflow_salt_": "kg",
    "inflow_": "1",
    "crowded_area": "m2",
    "gate_area_": "m2",
    "gate_volume_": "m3",
    "coast_": "1",
}


def volumes(state: xr.Dataset, moment: str) -> dict[str, float]:
    """Ice area (m2), ice volume and, where there is snow, snow volume (m3) of a state.

    Parameters
    ----------
    state : xarray.Dataset
        Elements.
    moment : str
        Word that ends each name, such as ``start``.

    Returns
    -------
    dict of float
        ``ice_area_<moment>`` (m2), ``ice_volume_<moment>`` and ``snow_volume_<moment>`` (m3).
    """
    area = state["area"].values
    totals = {
        "ice_area": state["ice_fraction"].values.sum(axis=1),
        "ice_volume": state["ice_volume"].values.sum(axis=1),
    }
    if "snow_volume" in state:
        totals["snow_volume"] = state["snow_volume"].values.sum(axis=1)
    return {f"{name}_{moment}": float(area @ each) for name, each in totals.items()}


def sea_change(
    scene: Scene, before: xr.Dataset, after: xr.Dataset, places: SeaPlaces
) -> dict[str, float]:
    """By how much the mixed layer's heat (J) and salt (kg) have changed, from two states.

    Parameters
    ----------
    scene : Scene
        Settings of the columns.
    before : xarray.Dataset
        States with a mixed layer.
    after : xarray.Dataset
        States with a mixed layer.
    places : SeaPlaces
        Area of the sea in each cell.

    Returns
    -------
    dict of float
        ``sea_heat_stored`` (J) and ``sea_salt_stored`` (kg).
    """
    settings = column_settings(scene)
    first, last = (read_water(state, places.area, settings) for state in (before, after))
    return {
        "sea_heat_stored": float(places.area.ravel() @ (last.heat - first.heat)),
        "sea_salt_stored": last.total_salt - first.total_salt,
    }


def series_dataset(motion: Motion, budget: dict[str, float], start: float) -> xr.Dataset:
    """Series (dim ``sample``) and budget scalars of a window.

    Parameters
    ----------
    motion : Motion
        What the dynamics left: samples and impulses.
    budget : dict
        Volumes and terms of the column.
    start : float
        Time of the window's start, s since the scene's start.

    Returns
    -------
    xarray.Dataset
        Variables with units; ``time`` of the samples in s since the scene's start.
    """
    # A dataset made at once: one that grows by a variable at a time takes a second for 200.
    data: dict[str, tuple[Any, ...]] = {}
    for name, values in motion.samples.items():
        array = np.asarray(values, dtype=float)
        if name == "time":
            array = array + start
        data[name] = ("sample", array, {"units": UNITS.get(name) or _unit(name)})
    for name, value in {**motion.budget, **budget}.items():
        data[name] = ((), float(value), {"units": _unit(name)})
    return xr.Dataset(data)


def _unit(name: str) -> str:
    return next(unit for prefix, unit in PREFIX_UNITS.items() if name.startswith(prefix))
