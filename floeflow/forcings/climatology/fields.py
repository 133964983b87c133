# SPDX-License-Identifier: GPL-2.0-or-later
"""Any variable of the forcing at any places and times."""

from __future__ import annotations

from collections.abc import Iterable
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from floeflow.core.monthly import days_of_year
from floeflow.forcings.climatology import air, ocean
from floeflow.forcings.climatology.wind import pressure_and_wind
from floeflow.scene.blocks import Climatology

Array = NDArray[np.float64]

NAMES = (
    *("wind_u", "wind_v", "ocean_u", "ocean_v", "air_temperature", "specific_humidity"),
    *("air_pressure", "shortwave_down", "longwave_down", "snowfall", "ocean_heat_flux"),
    "sea_surface_temperature",
)
# Speed of the wind (m/s) for which the heat of currents is made out.
MEAN_WIND = 6.5
MEAN_PRESSURE = 1.01e5  # Pa


def fields(
    lon: Array,
    lat: Array,
    start: datetime,
    seconds: Array,
    names: Iterable[str],
    settings: Climatology,
    depth: float,
) -> dict[str, Array]:
    """Variables of the forcing.

    Parameters
    ----------
    lon, lat : ndarray
        Degrees, (places,), all of one hemisphere.
    start : datetime
        Time 0.
    seconds : ndarray
        Times since then (s), (times,).
    names : iterable of str
        Of `NAMES`; wind and current are towards east (``_u``) and north (``_v``).
    settings : Climatology
        Seed of the storms and their number, offset of the temperature.
    depth : float
        Of the mixed layer, for the heat that currents bring (m).

    Returns
    -------
    dict of ndarray
        SI units, (times, places) each.
    """
    wanted, days = set(names), days_of_year(start, seconds)
    shape = (len(days), lon.size)
    sea = ocean.sea_temperature(lon, lat, days)
    warm = ocean.warmth(sea)
    temperature = air.air_temperature(lon, lat, days, warm) + settings.temperature_offset
    cloud = air.cloud_cover(warm, days)
    pressure, wind_u, wind_v = pressure_and_wind(
        lon, lat, start, seconds, days, settings.seed, settings.storminess
    )
    humidity = air.specific_humidity(temperature, pressure, warm)
    down = air.longwave(temperature, cloud)
    found = {
        "wind_u": wind_u,
        "wind_v": wind_v,
        "air_temperature": temperature,
        "specific_humidity": humidity,
        "air_pressure": pressure,
        "longwave_down": down,
        "snowfall": air.snowfall(temperature, warm, days),
        "sea_surface_temperature": sea,
    }
    vapour = humidity * pressure / 0.622
    if "shortwave_down" in wanted:
        found["shortwave_down"] = air.shortwave(lon, lat, start, days, vapour, cloud)
    if wanted & {"ocean_u", "ocean_v"}:
        east, north = ocean.currents(lon, lat)
        found |= {"ocean_u": np.broadcast_to(east, shape), "ocean_v": np.broadcast_to(north, shape)}
    if "ocean_heat_flux" in wanted:
        found["ocean_heat_flux"] = _heat(lon, lat, start, days, settings, depth)
    return {name: np.asarray(found[name]) for name in NAMES if name in wanted}


def _heat(
    lon: Array, lat: Array, start: datetime, days: Array, settings: Climatology, depth: float
) -> Array:
    """Heat that currents bring, from days' means: neither offset nor storms change it."""
    known, index = np.unique(np.floor(days), return_inverse=True)
    sea, tomorrow = (ocean.sea_temperature(lon, lat, known + step) for step in (0.0, 1.0))
    warm = ocean.warmth(sea)
    temperature = air.air_temperature(lon, lat, known + 0.5, warm)
    cloud = air.cloud_cover(warm, known)
    pressure = np.full_like(sea, MEAN_PRESSURE)
    humidity = air.specific_humidity(temperature, pressure, warm)
    vapour = humidity * pressure / 0.622
    hours = (np.arange(8) + 0.5) / 8.0
    sun = np.mean(
        [air.shortwave(lon, lat, start, known + part, vapour, cloud) for part in hours], axis=0
    )
    weather = ocean.Weather(
        temperature,
        humidity,
        pressure,
        np.full_like(sea, MEAN_WIND),
        sun,
        air.longwave(temperature, cloud),
    )
    part, northern = ocean.open_all_year(lon, lat), bool(lat.mean() > 0)
    return ocean.heat_convergence(sea, tomorrow, weather, depth, part, northern)[index]
