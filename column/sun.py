# SPDX-License-Identifier: GPL-2.0-or-later
"""Height of the sun over a place, which light of many directions asks for."""

from __future__ import annotations

from datetime import datetime, timedelta

import numpy as np

from floeflow.column.state import Array

_DAY = 86400.0


def sun_height(lon: Array, lat: Array, start: datetime, seconds: float) -> Array:
    """Cosine of the sun's distance from the zenith, zero at night.

    Declination and equation of time by Spencer (1971), Fourier series representation of the
    position of the sun, Search 2, 172.

    Parameters
    ----------
    lon, lat : ndarray
        Degrees east and north, (n,).
    start : datetime
        UTC.
    seconds : float
        Since the start.
    """
    now = start + timedelta(seconds=seconds)
    midnight = datetime(now.year, now.month, now.day)
    of_day = (now.replace(tzinfo=None) - midnight).total_seconds() / _DAY
    angle = 2.0 * np.pi * (now.timetuple().tm_yday - 1 + of_day) / 365.0
    sines = [np.sin(k * angle) for k in (1, 2, 3)]
    cosines = [np.cos(k * angle) for k in (1, 2, 3)]
    declination = (
        0.006918
        - 0.399912 * cosines[0]
        + 0.070257 * sines[0]
        - 0.006758 * cosines[1]
        + 0.000907 * sines[1]
        - 0.002697 * cosines[2]
        + 0.00148 * sines[2]
    )
    ahead = 0.000075 + 0.001868 * cosines[0] - 0.032077 * sines[0]
    ahead += -0.014615 * cosines[1] - 0.040849 * sines[1]
    hour = 2.0 * np.pi * (of_day - 0.5) + np.radians(lon) + ahead
    place = np.radians(lat)
    height = np.sin(place) * np.sin(declination)
    height = height + np.cos(place) * np.cos(declination) * np.cos(hour)
    return np.asarray(np.maximum(height, 0.0))
