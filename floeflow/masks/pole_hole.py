# SPDX-License-Identifier: GPL-2.0-or-later
"""The hole that satellites leave around the North Pole: found, and filled to its rim's mean.

It is neither land nor open water. Files flag it, or have no value there; then it is what is missing
all round the pole, north of all known values, in high latitudes. Around the South Pole there is
land, and no hole.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

# Holes reached down to 84.5 N (SMMR); no land lies north of 83.7 N.
LOWEST, LAND_ENDS = 80.0, 83.7
# Width of the rim whose mean fills the hole, and of the ragged edge that belongs to it (degrees).
RIM, RAGGED = 1.0, 0.5


@dataclass(frozen=True)
class Hole:
    """A hole.

    Parameters
    ----------
    cells : ndarray of bool
        Where it is, (ny, nx).
    south : float
        Its southernmost latitude (degrees).
    """

    cells: Flags
    south: float


def find_hole(known: Flags, flagged: Flags | None, lat: Array) -> Hole | None:
    """The hole at the North Pole.

    Parameters
    ----------
    known : ndarray of bool
        Where the file has a value, (ny, nx).
    flagged : ndarray of bool or None
        Where it says that there is the hole.
    lat : ndarray
        Latitudes (degrees), (ny, nx); NaN where there is no place.

    Returns
    -------
    Hole or None
        None without a hole.
    """
    placed = np.isfinite(lat)
    if flagged is not None and flagged.any():
        return Hole(flagged, float(lat[flagged & placed].min(initial=90.0)))
    northern = known & placed & (lat > 0)
    if not northern.any():
        return None
    top = float(lat[northern].max())
    if top < LOWEST:
        return None
    beyond = placed & ~known & (lat > top)
    if not beyond.any():
        return None
    south = max(top - RAGGED, LAND_ENDS) if top > LAND_ENDS else top
    ragged = placed & ~known & (lat > south)
    return Hole(ragged, float(lat[ragged].min()))


def rim_mean(values: Array, south: float, lat: Array) -> float | None:
    """Mean of the known values on the rim of a hole, each weighted by its latitude's circle.

    Returns None where there are none.

    Parameters
    ----------
    values : ndarray
        On the grid; NaN where unknown.
    south : float
        Latitude of the hole's rim (degrees north).
    lat : ndarray
        Latitudes of the values (degrees north).

    Returns
    -------
    float or None
        In the unit of the values.
    """
    rim = np.isfinite(values) & (lat >= south - RIM)
    if not rim.any():
        return None
    weight = np.cos(np.radians(lat[rim]))
    return float((values[rim] * weight).sum() / weight.sum())
