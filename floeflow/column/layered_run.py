# SPDX-License-Identifier: GPL-2.0-or-later
"""Layered columns as runs know them: by the names of the state, in kelvin, over a window."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from floeflow.column.layered import LayeredState, ice_energy, pack_forcing, step
from floeflow.column.params import INFRARED, VISIBLE, Settings
from floeflow.column.physics import KELVIN, Physics
from floeflow.column.records import LEVEL
from floeflow.column.state import Array
from floeflow.column.thermodynamics.enthalpy import salinity_profile
from floeflow.column.thermodynamics.mush import liquidus
from floeflow.column.thickness.categories import category_bounds
from floeflow.column.window import sub_steps
from floeflow.core.constants import GAS_AIR

Columns = dict[str, Array]

# Steps of an hour are those for which the share that flushing may wash out was chosen (s).
HOUR = 3600.0
# Numbers of forcing that are packed at once: bounds the memory.
BLOCK = 4_000_000
# Counts among the terms: solves of temperatures, those that the second method did, and those that
# ended short of their tolerance.
SOLVES = ("temperature_solves", "temperature_rescued", "temperature_unconverged")


def layered_physics(settings: Settings) -> Physics:
    """Constants of layered ice under these settings.

    Parameters
    ----------
    settings : Settings
        What the column is asked for.

    Returns
    -------
    Physics
        SI units; temperatures in degC, salinities in 1e-3.
    """
    defaults, keys = Physics(), settings.physics
    tuned = {name: getattr(keys, name) for name in Physics._fields if hasattr(keys, name)}
    mushy, convergent = settings.scheme == "mushy", settings.variant == "convergent"
    return Physics(
        **tuned,
        fresh_conductivity=keys.ice_conductivity,
        bubbly=keys.conductivity == "pringle",
        mushy=mushy,
        mixed=settings.has("mixed_layer"),
        frazil=settings.has("frazil"),
        delta_eddington=settings.needs_sun,
        ponds=settings.has("ponds"),
        ponds_cover_level=not convergent,
        flush_time=HOUR if convergent else 0.0,
        drained_by_depth=convergent,
        redistribute_light=convergent and mushy,
        lateral_rate=defaults.lateral_rate if settings.has("lateral_melt") else 0.0,
        new_ice_thickness=settings.new_ice_thickness,
        least_thickness=defaults.least_thickness if settings.categories > 1 else 0.1,
    )


def freezing_point(settings: Settings) -> float:
    """Freezing point of the sea (degC): the liquidus of brine for mush, else a straight line.

    Parameters
    ----------
    settings : Settings
        What the column is asked for.

    Returns
    -------
    float
        degC.
    """
    if settings.scheme == "mushy":
        return float(liquidus.py_func(settings.ocean_salinity))
    return -Physics().melting_slope * settings.ocean_salinity


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
        Scheme, processes, categories and step.

    Returns
    -------
    tuple of dict of ndarray
        Columns at the end of the window; terms of `budget_terms`.

    Raises
    ------
    FloeError
        For a window that is not positive, a forcing variable that is missing, or forcing that is
        not finite.
    UnsolvedError
        Where no temperatures balance the fluxes.
    """
    p, bounds = layered_physics(settings), category_bounds(settings.categories)
    steps, dt = sub_steps(*window, settings.step)
    state = layered_state(columns, settings)
    count = len(state.ice_fraction)
    block = max(1, BLOCK // max(count, 1))
    total: dict[str, Array] = {}
    for first in range(0, steps, block):
        part = range(first, min(first + block, steps))
        weather = [step_forcing(sample(window[0] + (k + 0.5) * dt), settings) for k in part]
        values = {
            name: np.stack([np.broadcast_to(each[name], count) for each in weather])
            for name in weather[0]
        }
        state, sums = step(state, pack_forcing(values, len(part), count), dt, bounds, p)
        total = {name: total.get(name, 0.0) + value for name, value in sums.items()}
    return _columns(state, columns), budget_terms(total, p)


def step_forcing(values: dict[str, Array], settings: Settings) -> dict[str, Array]:
    """Forcing of a step as the kernel names it; what no effect reads counts as none.

    The air at the height of the forcing is taken as it stands for its potential temperature.

    Parameters
    ----------
    values : dict of ndarray
        Forcing at the elements by the names and in the units of the state's forcing, (n,).
    settings : Settings
        Whether the sun's height is needed, salinity and depth of the sea, and the air's density.

    Returns
    -------
    dict of ndarray
        By the names of `records.FORCING` (units there), (n,).
    """
    air = values["air_temperature"]
    none = np.zeros_like(air)
    dry = GAS_AIR * air * (1.0 + Physics().virtual * values["specific_humidity"])
    given = settings.physics.air_density
    light = values.get("shortwave_down", none)
    sun = {"sun_height": values["sun_height"]} if settings.needs_sun else {}
    return sun | {
        "potential_temperature": air,
        "humidity": values["specific_humidity"],
        "density": np.full_like(air, given) if given > 0.0 else values["air_pressure"] / dry,
        "wind": np.hypot(values["wind_u"], values["wind_v"]),
        "longwave": values["longwave_down"],
        "visible": VISIBLE * light,
        "infrared": INFRARED * light,
        "snowfall": values.get("snowfall", none),
        "sea_salinity": values.get("sea_salinity", np.full_like(air, settings.ocean_salinity)),
        "deep_heat": values["ocean_heat_flux"],
        "mixed_depth": np.full_like(air, settings.mixed_layer_depth),
        "ocean_friction": values.get("friction_velocity", none),
    }


def stored(columns: Columns, settings: Settings) -> dict[str, Array]:
    """Energy (J/m2), water and of mush salt (kg/m2) of columns, (n,) each.

    Parameters
    ----------
    columns : dict of ndarray
        By the names of the state's schema.
    settings : Settings
        Which budgets there are: salt of mush, ponds.

    Returns
    -------
    dict of ndarray
        ``energy`` (J/m2, of ice and snow and of the mixed layer), ``water`` (kg/m2), of mush
        ``salt`` (kg/m2), with ponds ``pond`` (m of water), (n,).
    """
    p, state = layered_physics(settings), layered_state(columns, settings)
    energy = ice_energy(state)
    if "sea_temperature" in columns:
        warmer = state.sea_temperature - freezing_point(settings)
        heat = p.heat_water * p.water_density * settings.mixed_layer_depth * warmer
        energy = energy + heat - state.pending_freeze
    water = p.ice_density * state.ice_volume + p.snow_density * state.snow_volume
    kept = {"energy": energy, "water": water.sum(axis=1)}
    if p.mushy:
        salt = state.ice_salinity.mean(axis=2) * state.ice_volume
        kept["salt"] = 1e-3 * p.ice_density * salt.sum(axis=1)
    if p.ponds:
        kept["pond"] = pond_water(state)
    return kept


def pond_water(state: LayeredState) -> Array:
    """Water in ponds (m per area), (n,).

    Parameters
    ----------
    state : LayeredState
        n elements with their categories.

    Returns
    -------
    ndarray
        m of water over the element's area, (n,).
    """
    wet = state.ice_fraction * state.level_area * state.pond_area
    return np.asarray((wet * state.pond_depth).sum(axis=1))


def budget_terms(sums: dict[str, Array], p: Physics) -> dict[str, Array]:
    """Terms of the budgets with their signs, by the names of the series, (n,) each.

    Parameters
    ----------
    sums : dict of ndarray
        Budget terms of the kernel by the names of `records.SUMS`, (n,).
    p : Physics
        Constants.

    Returns
    -------
    dict of ndarray
        ``growth_*`` (m of ice), ``snow_*`` (m of snow), ``energy_*`` and ``light_*`` (J/m2),
        ``water_*`` and ``salt_*`` (kg/m2), ``pond_*`` (m of water), ``temperature_*`` (counts).
    """
    melts = ("melt_top", "melt_bottom", "melt_lateral", "cleared_ice")
    drained = p.ice_density * sum(sums[name] for name in melts)
    drained = drained - p.ice_density * (sums["growth"] + sums["new_ice"] + sums["snow_ice"])
    drained = drained + p.snow_density * (sums["melt_snow"] + sums["flooded_snow"])
    terms = {
        "growth_base": sums["growth"],
        "growth_new_ice": sums["new_ice"],
        "growth_snow_ice": sums["snow_ice"],
        "growth_melt_top": -sums["melt_top"],
        "growth_melt_base": -sums["melt_bottom"] - sums["cleared_ice"],
        "growth_melt_lateral": -sums["melt_lateral"],
        "growth_sublimation": -sums["sublimation_ice"],
        "snow_snowfall": sums["snowfall"],
        "snow_melt": -sums["melt_snow"],
        "snow_sublimation": -sums["sublimation_snow"],
        "snow_flooded": -sums["flooded_snow"],
        "energy_atmosphere": sums["air_to_ice"] + sums["air_to_sea"] + sums["light_to_sea"],
        "energy_ocean": sums["deep_to_sea"],
        "energy_snowfall": sums["snowfall_energy"],
        "water_snowfall": p.snow_density * sums["snowfall"],
        "water_vapour": -sums["vapour_ice"],
        "water_ocean": -drained,
        "light_to_sea": sums["light_to_sea"],
        **{name: sums[name.removeprefix("temperature_")] for name in SOLVES},
    }
    if p.mushy:
        terms["salt_ocean"] = 1e-3 * p.ice_density * sums["salt_to_ice"]
    if p.ponds:
        terms["pond_gain"] = sums["pond_gain"]
        terms |= {name: -sums[name] for name in ("pond_frozen", "pond_drained", "pond_lost")}
    return terms


def layered_state(columns: Columns, settings: Settings) -> LayeredState:
    """Columns in the terms of the kernel: degrees Celsius, and arrays for what is absent.

    Parameters
    ----------
    columns : dict of ndarray
        By the names of the state's schema; temperatures in K.
    settings : Settings
        Layers, and the freezing point of a sea that has no mixed layer.

    Returns
    -------
    LayeredState
        Fixed salinity profile, no snow, no ponds and a sea at its freezing point where the state
        has none.
    """
    fraction, enthalpy = columns["ice_fraction"], columns["ice_enthalpy"]
    count = len(fraction)
    salinity = columns.get("ice_salinity")
    if salinity is None:
        profile = salinity_profile(settings.layers, Physics())
        salinity = np.broadcast_to(profile, enthalpy.shape) * (fraction > 0.0)[..., None]
    sea = columns.get("sea_temperature", np.full(count, freezing_point(settings) + KELVIN))
    return LayeredState(
        fraction,
        columns["ice_volume"],
        columns.get("snow_volume", np.zeros_like(fraction)),
        columns["surface_temperature"] - KELVIN,
        enthalpy,
        columns.get("snow_enthalpy", np.zeros((*fraction.shape, 1))),
        salinity,
        sea - KELVIN,
        columns.get("pending_freeze", np.zeros(count)),
        **{name: columns[name] for name in LEVEL if name in columns},
    )


def _columns(state: LayeredState, like: Columns) -> Columns:
    kelvin = {
        "surface_temperature": state.surface_temperature + KELVIN,
        "sea_temperature": state.sea_temperature + KELVIN,
    }
    return {name: kelvin[name] if name in kelvin else getattr(state, name) for name in like}
