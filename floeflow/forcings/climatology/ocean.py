# SPDX-License-Identifier: GPL-2.0-or-later
"""The sea: temperature, currents, and the heat that currents bring.

The heat is what an open mixed layer needs to follow the tabled temperature under the climatology's
own air (the q-flux of slab oceans; Hansen et al. 1984): what its surface loses, plus what it
stores. Where it freezes in some month, ice gets the small heat of deep water.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floeflow.core.constants import (
    AIR_DENSITY,
    EARTH_RADIUS,
    HEAT_AIR,
    LATENT_VAPOUR,
    STEFAN_BOLTZMANN,
    ZERO_CELSIUS,
)
from floeflow.core.monthly import MIDDLES, east_north, unit
from floeflow.forcings.climatology import tables
from floeflow.forcings.climatology.air import station_field

Array = NDArray[np.float64]

COLDEST = -1.8 + ZERO_CELSIUS  # of the tables (K)
# Above freezing by this (K) the sea counts as warm water that stays open.
OPEN = 1.2
# Currents bring heat where the coldest month of the tables lies above freezing by more than the
# first (K), all of it from the second on: the edge of the winter's ice lies between (about 0 degC
# at the surface), and ice that drifts over colder water is not melted by a sea that it covers.
EDGE = (0.8, 2.0)
# Bulk coefficient and albedo of the sea (Large and Pond 1982, rounded).
TRANSFER, ALBEDO = 1.2e-3, 0.06
LEAST_HEAT, MOST_HEAT = -150.0, 450.0  # W/m2
WATER_HEAT = 4218.0 * 1026.0  # J/m3/K


def sea_temperature(lon: Array, lat: Array, days: Array) -> Array:
    """K, (times, places); at least the freezing point of the tables.

    Parameters
    ----------
    lon : ndarray
        Degrees, (places,).
    lat : ndarray
        Degrees, (places,).
    days : ndarray
        Of the year, from 0, (times,).

    Returns
    -------
    ndarray
        K, (times, places).
    """
    found = station_field(lon, lat, tables.SEA_NORTH, tables.SEA_SOUTH, days) + ZERO_CELSIUS
    return np.maximum(found, COLDEST)


def warmth(temperature: Array) -> Array:
    """0 where the sea is at its freezing point, rising to 1 where it is open.

    Parameters
    ----------
    temperature : ndarray
        Of the sea (K), any shape.

    Returns
    -------
    ndarray
        0 to 1, of that shape.
    """
    part = np.clip((temperature - COLDEST) / OPEN, 0.0, 1.0)
    return np.asarray(part * part * (3.0 - 2.0 * part))


@dataclass(frozen=True)
class Weather:
    """Air over the sea at some days: K, kg/kg, Pa, m/s, W/m2 (shortwave a mean of the day)."""

    temperature: Array
    humidity: Array
    pressure: Array
    wind: Array
    shortwave: Array
    longwave: Array


def surface_gain(sea: Array, air: Weather) -> Array:
    """Heat into open water (W/m2).

    Parameters
    ----------
    sea : ndarray
        Temperature of the sea (K), (times, places).
    air : Weather
        Air above it, (times, places) each.

    Returns
    -------
    ndarray
        W/m2, (times, places).
    """
    vapour = 610.78 * np.exp(17.2693882 * (sea - 273.16) / (sea - 35.86))
    saturated = 0.98 * 0.622 * vapour / (air.pressure - 0.378 * vapour)
    exchange = AIR_DENSITY * TRANSFER * air.wind
    turbulent = HEAT_AIR * (air.temperature - sea) + LATENT_VAPOUR * (air.humidity - saturated)
    net = (1.0 - ALBEDO) * air.shortwave + air.longwave - STEFAN_BOLTZMANN * sea**4
    return np.asarray(net + exchange * turbulent)


def open_all_year(lon: Array, lat: Array) -> Array:
    """1 where the tables have warm water in every month, 0 where it freezes in some, (places,).

    Parameters
    ----------
    lon : ndarray
        Degrees, (places,).
    lat : ndarray
        Degrees, (places,).

    Returns
    -------
    ndarray
        0 to 1, (places,).
    """
    above = sea_temperature(lon, lat, MIDDLES).min(axis=0) - COLDEST
    part = np.clip((above - EDGE[0]) / (EDGE[1] - EDGE[0]), 0.0, 1.0)
    return np.asarray(part * part * (3.0 - 2.0 * part))


def heat_convergence(
    sea: Array, tomorrow: Array, air: Weather, depth: float, part: Array, northern: bool
) -> Array:
    """Heat that currents bring to the mixed layer (W/m2).

    Parameters
    ----------
    sea, tomorrow : ndarray
        Tabled temperature at some days and a day later (K).
    air : Weather
        Over it.
    depth : float
        Of the mixed layer (m).
    part : ndarray
        From `open_all_year`. Elsewhere the sea's own ice makes the seasons: what the summer's sun
        brings melts it, and no current takes that away.
    northern : bool
        Hemisphere.

    Returns
    -------
    ndarray
        W/m2, positive into the layer, of the shape of the temperatures.
    """
    stored = WATER_HEAT * depth * (tomorrow - sea) / 86400.0
    needed = np.clip(stored - surface_gain(sea, air), LEAST_HEAT, MOST_HEAT)
    under_ice = tables.HEAT_PACK if northern else tables.HEAT_SOUTH
    return np.asarray(part * needed + (1.0 - part) * under_ice)


@dataclass(frozen=True)
class Stream:
    """A current along a path of places (longitude, latitude), m/s and m."""

    path: tuple[tuple[float, float], ...]
    speed: float
    width: float


@dataclass(frozen=True)
class Whirl:
    """A gyre around a place: largest speed (m/s, positive anticlockwise) at a radius (m)."""

    place: tuple[float, float]
    speed: float
    radius: float


# Speeds near the surface: Rudels (2015), Woodgate et al. (1999, East Greenland Current; with the
# gyre of the Greenland Sea 5 cm/s over the ice of Fram Strait, as Smedsrud et al. 2011 found),
# Beszczynska-Moeller et al. (2012, West Spitsbergen Current), Proshutinsky and Johnson (1997).
STREAMS_NORTH = (
    Stream(((160, 77), (165, 84), (0, 89.5), (-10, 85), (-5, 81)), 0.03, 2.5e5),  # Transpolar Drift
    Stream(((-5, 81), (-8, 78), (-12, 75), (-19, 71.5), (-24, 69.5), (-30, 67), (-37, 65),
            (-41, 62), (-43, 59.5)), 0.05, 1.1e5),  # East Greenland Current
    Stream(((-4, 61), (3, 64), (8, 67), (13, 70), (15, 73), (10, 77), (9, 79), (14, 80.7)), 0.12,
           1.2e5),  # Norwegian Atlantic and West Spitsbergen Currents
    Stream(((15, 71.5), (25, 72.5), (35, 72.5), (45, 73.5), (52, 75.5)), 0.06, 1.3e5),  # North Cape
    Stream(((-46, 60), (-52, 63), (-56, 67), (-60, 71)), 0.08, 1.0e5),  # West Greenland Current
    Stream(((-74, 76), (-68, 72), (-62, 67), (-62, 63), (-58, 58), (-54, 54)), 0.08,
           1.2e5),  # Baffin
    Stream(((-170, 64), (-169, 66), (-170, 69), (-165, 71)), 0.15, 8.0e4),  # Bering Strait
)  # fmt: skip
WHIRLS_NORTH = (
    Whirl((-148, 76.5), -0.06, 4.5e5),  # Beaufort Gyre
    Whirl((-3, 75), 0.05, 2.5e5),  # Greenland Sea
)
STREAMS_SOUTH = (
    Stream(tuple((lon, -56.0) for lon in range(-180, 181, 20)), 0.12, 5.0e5),  # Circumpolar
    Stream(tuple((lon, -67.0) for lon in range(160, -61, -20)), 0.05, 2.0e5),  # along the coast
)
WHIRLS_SOUTH = (
    Whirl((-25, -66), -0.06, 6.0e5),  # Weddell Gyre
    Whirl((-170, -68), -0.05, 5.0e5),  # Ross Gyre
)
# Corners of a path lie this far apart (rad) when it is drawn as a chain of short pieces.
PIECE = 0.01


def currents(lon: Array, lat: Array) -> tuple[Array, Array]:
    """Steady current towards east and north (m/s), (places,) each.

    Parameters
    ----------
    lon : ndarray
        Degrees, (places,).
    lat : ndarray
        Degrees, (places,).

    Returns
    -------
    east, north : ndarray
        m/s, (places,) each.
    """
    northern = bool(lat.mean() > 0)
    here, (east, north) = unit(lon, lat), east_north(lon, lat)
    flow = np.zeros_like(here)
    for stream in STREAMS_NORTH if northern else STREAMS_SOUTH:
        flow += _along(here, stream)
    for whirl in WHIRLS_NORTH if northern else WHIRLS_SOUTH:
        centre = unit(np.array(float(whirl.place[0])), np.array(float(whirl.place[1])))
        # Around the centre, anticlockwise as seen from above.
        around = np.cross(centre, here)
        size = np.linalg.norm(around, axis=1)
        distance = EARTH_RADIUS * np.sqrt(2.0 * np.maximum(1.0 - here @ centre, 0.0))
        far = distance / whirl.radius
        speed = whirl.speed * far * np.exp(0.5 * (1.0 - far**2))
        flow += (speed / np.where(size > 0.0, size, 1.0))[:, None] * around
    return (flow * east).sum(axis=1), (flow * north).sum(axis=1)


def _along(here: Array, stream: Stream) -> Array:
    """Flow of a stream at places (unit vectors), as vectors in space (m/s)."""
    corners = unit(*(np.array(part, float) for part in zip(*stream.path, strict=True)))
    points = []
    for a, b in zip(corners[:-1], corners[1:], strict=True):
        count = max(2, int(np.linalg.norm(b - a) / PIECE))
        part = np.linspace(0.0, 1.0, count, endpoint=False)[:, None]
        points.append((1.0 - part) * a + part * b)
    chain = np.concatenate([*points, corners[-1:]])
    chain /= np.linalg.norm(chain, axis=1, keepdims=True)
    ahead = np.gradient(chain, axis=0)
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    near = ((here[:, None, :] - chain[None, :, :]) ** 2).sum(axis=-1) * EARTH_RADIUS**2
    nearest = near.argmin(axis=1)
    reach = np.exp(-0.5 * near.min(axis=1) / stream.width**2)
    return np.asarray(stream.speed * reach[:, None] * ahead[nearest])
