# SPDX-License-Identifier: GPL-2.0-or-later
"""Thickness of ice by place and day of the year, where a mask has none.

Drawn up in round numbers after Bourke and Garrett (1987), Rothrock et al. (2008) and Worby et al.
(2008), for the ice of about 1960 to 2000: north of Greenland 5 m, near the Siberian coast 2 m, over
the year within a tenth of the 3.3 m that submarines found from 1975 to 2000 (drafts of 2.97 m).
Numbers are for the start of a run, not for work on a place or a year.
"""

from __future__ import annotations

from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from floeflow.core.monthly import at_day, blend, days_of_year

Array = NDArray[np.float64]

# Longitude, latitude: mean thickness (m) when the ice is thickest and when it is thinnest.
NORTH: dict[tuple[float, float], tuple[float, float]] = {
    (0.0, 90.0): (4.3, 3.2),
    (-60.0, 84.0): (5.4, 4.5),
    (-100.0, 82.0): (5.2, 4.2),
    (-20.0, 84.0): (4.8, 3.8),
    (-150.0, 75.0): (3.7, 2.5),
    (180.0, 80.0): (4.0, 2.8),
    (180.0, 74.0): (3.1, 1.7),
    (150.0, 84.0): (3.7, 2.6),
    (110.0, 82.0): (3.0, 1.9),
    (40.0, 84.0): (3.0, 2.0),
    (-8.0, 80.0): (3.0, 2.0),
    (-15.0, 76.0): (2.2, 1.2),
    (-24.0, 70.0): (1.2, 0.5),
    (135.0, 75.0): (2.0, 0.6),
    (80.0, 75.0): (1.6, 0.3),
    (75.0, 79.0): (1.8, 0.6),
    (40.0, 78.0): (1.3, 0.4),
    (45.0, 74.0): (0.8, 0.2),
    (-70.0, 73.0): (1.5, 0.4),
    (-58.0, 66.0): (1.0, 0.3),
    (-170.0, 68.0): (1.4, 0.2),
    (-90.0, 70.0): (1.9, 1.0),
    (-145.0, 71.0): (2.3, 1.1),
    (-175.0, 62.0): (0.7, 0.2),
    (-85.0, 58.0): (1.5, 0.2),
    (150.0, 57.0): (0.8, 0.2),
}
SOUTH: dict[tuple[float, float], tuple[float, float]] = {
    (-50.0, -70.0): (1.8, 1.5),
    (0.0, -67.0): (0.7, 0.5),
    (0.0, -60.0): (0.5, 0.3),
    (60.0, -66.0): (0.7, 0.5),
    (120.0, -65.0): (0.8, 0.6),
    (180.0, -73.0): (0.8, 0.6),
    (180.0, -62.0): (0.5, 0.3),
    (-110.0, -70.0): (1.3, 1.0),
}
# Share of the way from the thinnest to the thickest, January to December.
SEASON_NORTH = (0.55, 0.70, 0.85, 0.97, 1.00, 0.85, 0.50, 0.12, 0.00, 0.10, 0.25, 0.40)
SEASON_SOUTH = (0.20, 0.05, 0.00, 0.10, 0.25, 0.40, 0.55, 0.75, 0.90, 1.00, 0.90, 0.55)
# A place of the table rules alone within this (m).
REACH = 2.5e5


def climatological_thickness(lon: Array, lat: Array, day: datetime) -> Array:
    """Mean thickness of closed ice (m) at places (degrees), all of one hemisphere, on a day.

    Parameters
    ----------
    lon : ndarray
        Degrees.
    lat : ndarray
        Degrees.
    day : datetime
        Date.

    Returns
    -------
    ndarray
        m, of the shape of ``lon``.
    """
    northern = bool(lat.mean() > 0)
    table, season = (NORTH, SEASON_NORTH) if northern else (SOUTH, SEASON_SOUTH)
    weights = blend(lon.ravel(), lat.ravel(), np.array(list(table), float), REACH)
    thick, thin = (weights @ np.array(list(table.values()))).T
    share = float(at_day(np.array(season), days_of_year(day, np.zeros(1)))[0])
    return np.asarray((thin + share * (thick - thin)).reshape(lon.shape))
