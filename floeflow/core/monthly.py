# SPDX-License-Identifier: GPL-2.0-or-later
"""Monthly tables as smooth functions of time and place."""

from __future__ import annotations

from datetime import datetime, timedelta

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from floeflow.core.constants import EARTH_RADIUS

Array = NDArray[np.float64]
Table = tuple[float, ...]

# Middles of the months (days since the year's first).
MIDDLES = np.array([15.5, 45, 74.5, 105, 135.5, 166, 196.5, 227.5, 258, 288.5, 319, 349.5])
YEAR = 365.0  # days


def days_of_year(start: datetime, seconds: Array) -> Array:
    """Days since the year's first, with fractions, of times in seconds since a start.

    Parameters
    ----------
    start : datetime
        Time of 0 s.
    seconds : ndarray
        s, (n,).

    Returns
    -------
    ndarray
        Days, (n,).
    """
    found = []
    for each in np.atleast_1d(seconds):
        now = start + timedelta(seconds=float(each))
        first = now.replace(month=1, day=1, hour=0, minute=0, second=0, microsecond=0)
        found.append((now - first) / timedelta(days=1))
    return np.array(found)


def at_day(table: Array, day: Array) -> Array:
    """A table of 12 months, (12, ...), at days of the year, (n, ...): periodic and smooth.

    A spline through the middles of the months; where it would pass the table's bounds (a cover
    above 1) it is held there.

    Parameters
    ----------
    table : ndarray
        One row a month, (12, ...).
    day : ndarray
        Day of the year, from 0, (n,).

    Returns
    -------
    ndarray
        In the unit of the table.
    """
    table = np.asarray(table, dtype=float)
    knots = np.append(MIDDLES, MIDDLES[0] + YEAR)
    spline = CubicSpline(knots, np.concatenate([table, table[:1]]), bc_type="periodic")
    return np.clip(spline(np.asarray(day)), table.min(axis=0), table.max(axis=0))


def unit(lon: Array, lat: Array) -> Array:
    """Unit vectors of places (degrees), (..., 3).

    Parameters
    ----------
    lon : ndarray
        Degrees.
    lat : ndarray
        Degrees.

    Returns
    -------
    ndarray
        1.
    """
    lam, phi = np.radians(lon), np.radians(lat)
    return np.stack([np.cos(phi) * np.cos(lam), np.cos(phi) * np.sin(lam), np.sin(phi)], axis=-1)


def east_north(lon: Array, lat: Array) -> tuple[Array, Array]:
    """Unit vectors that point east and north at places, (..., 3) each.

    Parameters
    ----------
    lon : ndarray
        Degrees.
    lat : ndarray
        Degrees.

    Returns
    -------
    tuple of ndarray
        1.
    """
    lam, phi = np.radians(lon), np.radians(lat)
    east = np.stack([-np.sin(lam), np.cos(lam), np.zeros_like(lam)], axis=-1)
    north = np.stack([-np.sin(phi) * np.cos(lam), -np.sin(phi) * np.sin(lam), np.cos(phi)], axis=-1)
    return east, north


def blend(lon: Array, lat: Array, stations: Array, reach: float) -> Array:
    """Weights of stations at places: Shepard's, of the fourth power, smooth within a reach.

    Parameters
    ----------
    lon, lat : ndarray
        Degrees, (n,).
    stations : ndarray
        Longitude and latitude of the stations, (m, 2).
    reach : float
        Distance (m) within which a station rules alone.

    Returns
    -------
    ndarray
        (n, m): rows add up to 1.
    """
    far = unit(lon, lat)[:, None, :] - unit(stations[:, 0], stations[:, 1])[None, :, :]
    distance = EARTH_RADIUS * np.sqrt((far**2).sum(axis=-1))
    weight = 1.0 / (distance**2 + reach**2) ** 2
    return np.asarray(weight / weight.sum(axis=1, keepdims=True))


def bump(lon: Array, lat: Array, place: tuple[float, float], width: float) -> Array:
    """A bell of height 1 around a place (longitude, latitude), with a width (m), (n,).

    Parameters
    ----------
    lon : ndarray
        Degrees.
    lat : ndarray
        Degrees.
    place : tuple of float
        Longitude and latitude of its middle (degrees).
    width : float
        m.

    Returns
    -------
    ndarray
        0 to 1.
    """
    cosine = unit(lon, lat) @ unit(np.array(place[0]), np.array(place[1]))
    return np.asarray(np.exp((cosine - 1.0) * (EARTH_RADIUS / width) ** 2))
