# SPDX-License-Identifier: GPL-2.0-or-later
"""A single column through its forcing: records of its state and what became of its budgets."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import xarray as xr

from floeflow.column.initial_columns import first_columns, layer_temperatures
from floeflow.column.layered_run import freezing_point
from floeflow.column.params import Settings
from floeflow.column.physics import KELVIN
from floeflow.column.schemes import advance_columns
from floeflow.column.state import Array
from floeflow.scene.effects import EFFECTS, column_variables
from floeflow.scene.physics import ColumnPhysics

Columns = dict[str, Array]

# Layers in which the temperatures of zero-layer ice, which are linear, are told.
SHOWN_LAYERS = 7

UNITS = {
    "ice_fraction": ("1", "share under ice"),
    "ice_volume": ("m", "ice volume per area"),
    "snow_volume": ("m", "snow volume per area"),
    "ice_thickness": ("m", "mean thickness of the ice"),
    "snow_thickness": ("m", "mean thickness of the snow on the ice"),
    "surface_temperature": ("K", "temperature of the surface, mean over the ice"),
    "ice_temperature": ("K", "temperature of ice layers, top first, mean over the ice"),
    "snow_temperature": ("K", "temperature of the snow, mean over the ice"),
    "sea_temperature": ("K", "temperature of the mixed layer, or freezing point"),
    "air_temperature": ("K", "temperature of the air"),
    "ice_salinity": ("1e-3", "salinity of ice layers, top first, mean over the ice"),
}


def start_columns(
    settings: Settings, thickness: float, fraction: float, snow: float, surface: float
) -> Columns:
    """One element of ice of a thickness (m) under snow (m), its surface at a temperature (K).

    Parameters
    ----------
    settings : Settings
        Scheme, processes and categories.
    thickness : float
        Of the ice (m).
    fraction : float
        Share of the area under ice.
    snow : float
        Depth of the snow (m).
    surface : float
        Temperature of the surface (K).

    Returns
    -------
    dict of ndarray
        By the names of the state's schema, (1, ...).
    """
    a = np.array([fraction if thickness > 0.0 else 0.0])
    every = first_columns(a, a * thickness, np.array([snow]), surface, settings)
    effects = [name for name in EFFECTS if name in ("thermodynamics", *settings.processes)]
    return {name: every[name] for name in column_variables(effects, settings.scheme)}


def run_column(
    columns: Columns,
    sample: Callable[[float], dict[str, Array]],
    length: float,
    every: float,
    settings: Settings,
) -> tuple[xr.Dataset, dict[str, float]]:
    """Advance one column and record it.

    Parameters
    ----------
    columns : dict of ndarray
        From `start_columns`.
    sample : callable
        Forcing at a time (s).
    length, every : float
        How long, and how long between records (s).
    settings : Settings
        Of the columns.

    Returns
    -------
    xarray.Dataset
        On ``time`` (s), start and end included: means over the ice, per category areas and
        volumes, and the budgets' terms of the time before each record.
    dict of float
        Largest residual of the energy (W/m2), water (kg/m2) and salt (kg/m2) of a record.
    """
    times = np.append(np.arange(0.0, length - 1e-6, every), length)
    rows, kept = [_record(columns, sample(times[0]), settings)], []
    worst: dict[str, float] = {}
    for t0, t1 in zip(times[:-1], times[1:], strict=True):
        columns, terms = advance_columns(columns, sample, (float(t0), float(t1)), settings)
        rows.append(_record(columns, sample(float(t1) - 1e-6), settings))
        kept.append({name: float(value[0]) for name, value in terms.items()})
        for kind, left in residuals(kept[-1], float(t1 - t0)).items():
            worst[kind] = max(worst.get(kind, 0.0), abs(left))
    data = xr.Dataset(coords={"time": times})
    for name in rows[0]:
        values = np.stack([row[name] for row in rows])
        dims = ("time", *{1: (), 2: _dims(name)}[values.ndim])
        units, text = UNITS[name.removesuffix("_category")]
        data[name] = (dims, values, {"units": units, "long_name": text})
    for name in kept[0] if kept else ():
        data[name] = ("time", np.array([0.0, *(row[name] for row in kept)]))
        data[name].attrs["units"] = "J m-2" if name.startswith("energy") else "kg m-2"
        if name.startswith(("growth", "snow")):
            data[name].attrs["units"] = "m"
        elif name.startswith(("temperature_", "ice_area_")):
            data[name].attrs["units"] = "1"
    return data, worst


def _dims(name: str) -> tuple[str, ...]:
    return ("category",) if name.endswith("_category") else ("ice_layer",)


def residuals(terms: dict[str, float], seconds: float) -> dict[str, float]:
    """What the terms leave unexplained: energy (W/m2), water and salt (kg/m2).

    Parameters
    ----------
    terms : dict of float
        Of the budgets, summed over time (J/m2, kg/m2).
    seconds : float
        Length of time (s).

    Returns
    -------
    dict of float
        By ``energy``, ``water`` and ``salt``.
    """
    found = {}
    for kind, per in (("energy", seconds), ("water", 1.0), ("salt", 1.0)):
        stored = terms.get(f"{kind}_stored")
        if stored is not None:
            named = sum(value for name, value in terms.items() if name.startswith(f"{kind}_"))
            found[kind] = (2.0 * stored - named) / per
    return found


def _record(columns: Columns, weather: dict[str, Array], settings: Settings) -> dict[str, Array]:
    """What is told of a moment; means over the ice are not a number where there is none."""
    area, ice = columns["ice_fraction"][0], columns["ice_volume"][0]
    covered = area.sum()
    share = area / covered if covered > 0.0 else np.full_like(area, np.nan)
    sea = columns.get("sea_temperature", np.array([freezing_point(settings) + KELVIN]))
    snow = columns.get("snow_volume", np.zeros((1, area.size)))[0]
    row = {
        "ice_fraction": covered,
        "ice_volume": ice.sum(),
        "snow_volume": snow.sum(),
        "ice_thickness": ice.sum() / covered if covered > 0.0 else np.nan,
        "snow_thickness": snow.sum() / covered if covered > 0.0 else np.nan,
        "surface_temperature": (share * columns["surface_temperature"][0]).sum(),
        "sea_temperature": sea[0],
        "air_temperature": weather["air_temperature"][0],
    }
    row |= _layers(columns, share, float(sea[0]), settings)
    if area.size > 1:
        row |= {"ice_fraction_category": area, "ice_volume_category": ice}
    return {name: np.asarray(value, dtype=float) for name, value in row.items()}


def _layers(columns: Columns, share: Array, sea: float, settings: Settings) -> Columns:
    there = columns["ice_fraction"][0] > 0.0
    if "ice_enthalpy" not in columns:
        middles = (np.arange(SHOWN_LAYERS) + 0.5) / SHOWN_LAYERS
        top = columns["surface_temperature"][0][:, None]
        if "snow_volume" in columns:
            top = _snow_base(columns, sea, settings.physics)[:, None]
        layers = top + (freezing_point(settings) + KELVIN - top) * middles
        return {"ice_temperature": (share[:, None] * layers)[there].sum(axis=0) + _nothing(there)}
    snow, ice = layer_temperatures(columns, settings)
    row = {"ice_temperature": (share[:, None] * ice[0])[there].sum(axis=0) + _nothing(there)}
    if "snow_volume" in columns:
        white = columns["snow_volume"][0]
        mean = (white * np.nan_to_num(snow[0, :, 0])).sum()
        row["snow_temperature"] = mean / white.sum() if white.sum() > 0.0 else np.nan
    if "ice_salinity" in columns:
        salt = (share[:, None] * columns["ice_salinity"][0])[there].sum(axis=0)
        row["ice_salinity"] = salt + _nothing(there)
    return row


def _nothing(there: Array) -> float:
    return 0.0 if there.any() else np.nan


def _snow_base(columns: Columns, sea: float, keys: ColumnPhysics) -> Array:
    """Temperature (K) between zero-layer ice and its snow, from their resistances."""
    ice = columns["ice_volume"][0] / keys.ice_conductivity
    snow = columns["snow_volume"][0] / keys.snow_conductivity
    top = columns["surface_temperature"][0]
    whole = np.where(ice + snow > 0.0, ice + snow, 1.0)
    return np.asarray(top + (sea - top) * snow / whole)
