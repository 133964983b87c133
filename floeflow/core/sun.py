# SPDX-License-Identifier: GPL-2.0-or-later
"""Height of the sun over a place, which light of many directions asks for."""

from __future__ import annotations

from datetime import datetime, timedelta

import numpy as np
from numpy.typing import ArrayLike, NDArray

# The orbit of 1950 by Berger (1978).
ECCENTRICITY = 0.016723932996732707
OBLIQUITY = 23.446271289397863  # degrees
PERIHELION = 102.03904951763556  # longitude, degrees from the vernal equinox
EQUINOX = 80.5  # day of the year, 1 January at 0 h being 1
YEAR = 365.0  # days


def sun_height(
    day: ArrayLike, latitude: ArrayLike, longitude: ArrayLike = 0.0
) -> NDArray[np.float64]:
    """Cosine of the angle between sun and zenith, negative below the horizon; Berger (1978).

    Parameters
    ----------
    day : array_like
        Day of the year with its fraction in universal time, 1 at the first of January, 0 h.
    latitude, longitude : array_like
        Degrees.

    Returns
    -------
    ndarray
        As the arguments broadcast.
    """
    day, latitude, longitude = (np.asarray(a, dtype=float) for a in (day, latitude, longitude))
    e, perihelion = ECCENTRICITY, np.radians(PERIHELION + 180.0)
    b = np.sqrt(1.0 - e * e)
    mean = 2.0 * (
        (e / 2.0 + e**3 / 8.0) * (1.0 + b) * np.sin(perihelion)
        - e**2 / 4.0 * (0.5 + b) * np.sin(2.0 * perihelion)
        + e**3 / 8.0 * (1.0 / 3.0 + b) * np.sin(3.0 * perihelion)
    )
    mean = mean + (day - EQUINOX) * 2.0 * np.pi / YEAR
    m = mean - perihelion
    true = mean + (2.0 * e - e**3 / 4.0) * np.sin(m) + 1.25 * e**2 * np.sin(2.0 * m)
    true = true + 13.0 / 12.0 * e**3 * np.sin(3.0 * m)
    declination = np.arcsin(np.sin(np.radians(OBLIQUITY)) * np.sin(true))
    hour = (day % 1.0 - 0.5) * 2.0 * np.pi + np.radians(longitude)
    high = np.sin(np.radians(latitude)) * np.sin(declination)
    return np.asarray(high + np.cos(np.radians(latitude)) * np.cos(declination) * np.cos(hour))


def day_of_year(start: datetime, seconds: float) -> float:
    """Day of the year with its fraction, as `sun_height` takes it, so many seconds after a time.

    Parameters
    ----------
    start : datetime
        A time, UTC.
    seconds : float
        s after it.

    Returns
    -------
    float
        From 1.
    """
    now = start + timedelta(seconds=seconds)
    of_day = timedelta(hours=now.hour, minutes=now.minute, seconds=now.second)
    fraction = (of_day + timedelta(microseconds=now.microsecond)) / timedelta(days=1)
    return now.timetuple().tm_yday + fraction
