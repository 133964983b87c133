# SPDX-License-Identifier: GPL-2.0-or-later
"""Zero-layer columns as runs know them: by the names of the state, over a window."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from floeflow.column.ocean.slab import Sea, sea_energy
from floeflow.column.params import ColumnParams, Settings, zero_layer_params
from floeflow.column.state import Array, ColumnFluxes, ColumnForcing, ColumnState, column_energy
from floeflow.column.window import advance_window

Columns = dict[str, Array]


def advance(
    columns: Columns,
    sample: Callable[[float], dict[str, Array]],
    window: tuple[float, float],
    settings: Settings,
) -> tuple[Columns, dict[str, Array]]:
    """Advance columns over a window; see `floeflow.column.schemes.Scheme`.

    Parameters
    ----------
    columns : dict of ndarray
        By the names of the state's schema; temperatures in K.
    sample : callable
        Forcing at the elements at a time (s), by the names of the forcing.
    window : tuple of float
        Start and end (s).
    settings : Settings
        Processes, categories and step.

    Returns
    -------
    tuple of dict of ndarray
        Columns at the end of the window; terms of `budget_terms`.

    Raises
    ------
    FloeError
        For a window that is not positive, or ice without area.
    UnsolvedError
        Where no temperature balances the fluxes.
    """
    params = zero_layer_params(settings)
    state, sea = _state(columns), _sea(columns)

    def forcing(t: float) -> ColumnForcing:
        return column_forcing(sample(t), len(state.ice_fraction))

    state, sea, fluxes = advance_window(state, forcing, *window, settings.step, params, sea)
    after = {name: getattr(state, name) for name in columns if hasattr(state, name)}
    if sea is not None:
        after |= {"sea_temperature": sea.temperature, "pending_freeze": sea.pending_freeze}
    return after, budget_terms(fluxes, params)


def stored(columns: Columns, settings: Settings) -> dict[str, Array]:
    """Energy (J/m2) and water (kg/m2) of columns, (n,) each.

    Parameters
    ----------
    columns : dict of ndarray
        By the names of the state's schema.
    settings : Settings
        Depth and freezing point of the mixed layer.

    Returns
    -------
    dict of ndarray
        ``energy`` of ice, snow and mixed layer, ``water`` of ice and snow.
    """
    params, state, sea = zero_layer_params(settings), _state(columns), _sea(columns)
    energy = column_energy(state, params)
    if sea is not None:
        energy = energy + sea_energy(sea, params)
    water = params.ice_density * state.ice_volume + params.snow_density * state.snow_volume
    return {"energy": energy, "water": water.sum(axis=1)}


def column_forcing(values: dict[str, Array], count: int) -> ColumnForcing:
    """Forcing of a step; what no effect reads is not there and counts as none.

    Parameters
    ----------
    values : dict of ndarray
        Forcing at the elements by the names and in the units of the state's forcing, (n,).
    count : int
        Number of elements.

    Returns
    -------
    ColumnForcing
        Zeros for snowfall, short-wave radiation and friction where they are not there.
    """
    none = np.zeros(count)
    return ColumnForcing(
        air_temperature=values["air_temperature"],
        specific_humidity=values["specific_humidity"],
        wind_speed=np.hypot(values["wind_u"], values["wind_v"]),
        shortwave_down=values.get("shortwave_down", none),
        longwave_down=values["longwave_down"],
        snowfall=values.get("snowfall", none),
        air_pressure=values["air_pressure"],
        ocean_heat_flux=values["ocean_heat_flux"],
        friction_velocity=values.get("friction_velocity", none),
    )


def budget_terms(fluxes: ColumnFluxes, params: ColumnParams) -> dict[str, Array]:
    """Terms of the budgets with their signs, by the names of the series, (n,) each.

    Parameters
    ----------
    fluxes : ColumnFluxes
        What the steps moved.
    params : ColumnParams
        Constants.

    Returns
    -------
    dict of ndarray
        ``growth_*`` (m of ice), ``snow_*`` (m of snow), ``energy_*`` (J/m2), ``water_*`` (kg/m2).
    """
    total = {
        name: getattr(fluxes, name).sum(axis=1)
        for name in (
            *("growth_base", "new_ice", "melt_top", "melt_base", "melt_lateral"),
            *("sublimation_ice", "snowfall", "snow_melt", "sublimation_snow"),
        )
    }
    vapour = params.ice_density * total["sublimation_ice"]
    vapour = vapour + params.snow_density * total["sublimation_snow"]
    melted = total["melt_top"] + total["melt_base"] + total["melt_lateral"]
    grown = total["growth_base"] + total["new_ice"]
    drained = params.ice_density * (melted - grown) + params.snow_density * total["snow_melt"]
    return {
        "growth_base": total["growth_base"],
        "growth_new_ice": total["new_ice"],
        "growth_melt_top": -total["melt_top"],
        "growth_melt_base": -total["melt_base"],
        "growth_melt_lateral": -total["melt_lateral"],
        "growth_sublimation": -total["sublimation_ice"],
        "snow_snowfall": total["snowfall"],
        "snow_melt": -total["snow_melt"],
        "snow_sublimation": -total["sublimation_snow"],
        "energy_atmosphere": fluxes.energy_atmosphere,
        "energy_ocean": fluxes.energy_ocean,
        "energy_snowfall": fluxes.energy_snowfall,
        "energy_to_ocean": -fluxes.energy_to_ocean,
        "water_snowfall": params.snow_density * total["snowfall"],
        "water_vapour": -vapour,
        "water_ocean": -drained,
    }


def _state(columns: Columns) -> ColumnState:
    fraction = columns["ice_fraction"]
    return ColumnState(
        fraction,
        columns["ice_volume"],
        columns.get("snow_volume", np.zeros_like(fraction)),
        columns["surface_temperature"],
    )


def _sea(columns: Columns) -> Sea | None:
    if "sea_temperature" not in columns:
        return None
    return Sea(columns["sea_temperature"], columns["pending_freeze"])
