# SPDX-License-Identifier: GPL-2.0-or-later
"""Air over ice and sea: temperature, humidity, cloud, radiation and snow from monthly tables."""

from __future__ import annotations

from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from floeflow.core.constants import STEFAN_BOLTZMANN, ZERO_CELSIUS
from floeflow.core.monthly import at_day, blend
from floeflow.core.sun import sun_height
from floeflow.forcings.climatology import tables

Array = NDArray[np.float64]

Stations = dict[tuple[float, float], tuple[float, ...]]

SOLAR = 1361.0
# Relative humidity over ice (Andreas et al. 2002: near saturation) and over open water.
HUMID_ICE, HUMID_SEA = 0.95, 0.82
# Over this distance (m) a station rules alone.
REACH = 2.5e5
MELTING_AIR = 273.25  # K
# Air warmer than this (K) brings rain, colder than the first snow.
SNOW_BELOW, RAIN_ABOVE = 271.15, 273.45


def station_field(lon: Array, lat: Array, north: Stations, south: Stations, days: Array) -> Array:
    """A monthly table of stations at places, (times, places).

    Parameters
    ----------
    lon : ndarray
        Degrees, (places,).
    lat : ndarray
        Degrees, (places,).
    north : Stations
        Monthly values by place, in the Arctic.
    south : Stations
        Monthly values by place, in the Antarctic.
    days : ndarray
        Of the year, from 0, (times,).

    Returns
    -------
    ndarray
        In the table's unit, (times, places).
    """
    table = north if lat.mean() > 0 else south
    weights = blend(lon, lat, np.array(list(table), float), REACH)
    return at_day(np.array(list(table.values()), float).T, days) @ weights.T


def air_temperature(lon: Array, lat: Array, days: Array, warm: Array) -> Array:
    """K, (times, places).

    Melting ice keeps the air above it near the melting point (Lindsay 1998), which stations on
    land do not tell: where the sea is cold (``warm`` is 0) the air is at most `MELTING_AIR`.

    Parameters
    ----------
    lon : ndarray
        Degrees, (places,).
    lat : ndarray
        Degrees, (places,).
    days : ndarray
        Of the year, from 0, (times,).
    warm : ndarray
        0 where the sea is at its freezing point, 1 where it is open, (times, places).

    Returns
    -------
    ndarray
        K, (times, places).
    """
    found = station_field(lon, lat, tables.AIR_NORTH, tables.AIR_SOUTH, days) + ZERO_CELSIUS
    return np.asarray(found - (1.0 - warm) * np.maximum(found - MELTING_AIR, 0.0))


def specific_humidity(temperature: Array, pressure: Array, warm: Array) -> Array:
    """kg/kg: near saturation over ice (Murray 1967), less over warm water.

    Parameters
    ----------
    temperature : ndarray
        Of the air (K), (times, places).
    pressure : ndarray
        Pa, (times, places).
    warm : ndarray
        0 over ice, 1 over open sea, (times, places).

    Returns
    -------
    ndarray
        kg/kg, (times, places).
    """
    over = temperature - ZERO_CELSIUS
    ice = 610.78 * np.exp(21.8745584 * (temperature - 273.16) / (temperature - 7.66))
    sea = 610.78 * np.exp(17.2693882 * (temperature - 273.16) / (temperature - 35.86))
    cold = np.clip(-over, 0.0, 1.0)
    saturated = cold * ice + (1.0 - cold) * sea
    humid = HUMID_ICE + warm * (HUMID_SEA - HUMID_ICE)
    vapour = humid * saturated
    return np.asarray(0.622 * vapour / (pressure - 0.378 * vapour))


def cloud_cover(warm: Array, days: Array) -> Array:
    """Share of the sky, (times, places).

    Parameters
    ----------
    warm : ndarray
        0 over ice, 1 over open sea, (times, places).
    days : ndarray
        Of the year, from 0, (times,).

    Returns
    -------
    ndarray
        0 to 1, (times, places).
    """
    pack, sea = (at_day(np.array(t), days) for t in (tables.CLOUD_PACK, tables.CLOUD_SEA))
    return np.asarray(pack[:, None] + warm * (sea - pack)[:, None])


def longwave(temperature: Array, cloud: Array) -> Array:
    """Downward, W/m2 (Maykut and Church 1973).

    Parameters
    ----------
    temperature : ndarray
        Of the air (K), (times, places).
    cloud : ndarray
        Share of the sky, (times, places).

    Returns
    -------
    ndarray
        W/m2, (times, places).
    """
    return np.asarray(STEFAN_BOLTZMANN * temperature**4 * (0.7855 + 0.2232 * cloud**2.75))


def shortwave(
    lon: Array, lat: Array, start: datetime, days: Array, vapour: Array, cloud: Array
) -> Array:
    """Downward, W/m2: clear sky by Zillman (1972), cloud by Parkinson and Washington (1979).

    ``vapour`` is the vapour pressure (Pa); ``days`` of the year, from 0.

    Parameters
    ----------
    lon : ndarray
        Degrees, (places,).
    lat : ndarray
        Degrees, (places,).
    start : datetime
        Time of day 0, in UTC.
    days : ndarray
        Of the year, from 0, (times,).
    vapour : ndarray
        Vapour pressure (Pa), (times, places).
    cloud : ndarray
        Share of the sky, (times, places).

    Returns
    -------
    ndarray
        W/m2, (times, places).
    """
    high = np.maximum(sun_height(days[:, None] + 1.0, lat, lon), 0.0)
    clear = SOLAR * high**2 / (1e-5 * vapour * (high + 2.7) + 1.085 * high + 0.10)
    return np.asarray(clear * (1.0 - 0.6 * cloud**3))


def snowfall(temperature: Array, warm: Array, days: Array) -> Array:
    """kg/m2/s, (times, places).

    Parameters
    ----------
    temperature : ndarray
        Of the air (K), (times, places).
    warm : ndarray
        0 over ice, 1 over open sea, (times, places).
    days : ndarray
        Of the year, from 0, (times,).

    Returns
    -------
    ndarray
        kg/m2/s, (times, places).
    """
    rate = at_day(np.array(tables.RAIN_PACK, float), days)[:, None] / (30.4 * 86400.0)
    frozen = np.clip((RAIN_ABOVE - temperature) / (RAIN_ABOVE - SNOW_BELOW), 0.0, 1.0)
    return np.asarray(rate * (1.0 + tables.WETTER * warm) * frozen)
