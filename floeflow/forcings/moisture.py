# SPDX-License-Identifier: GPL-2.0-or-later
"""Humidity and snowfall from what files have instead of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from floeflow.core.constants import ZERO_CELSIUS

Array = NDArray[np.float64]


def dew_point_humidity(dew_point: Array, pressure: Array) -> Array:
    """Specific humidity (kg/kg) from dew point (K, over water) and pressure (Pa).

    Saturation over water after Buck (1981) with the constants of IFS documentation, part IV.

    Parameters
    ----------
    dew_point : ndarray
        K.
    pressure : ndarray
        Pa.

    Returns
    -------
    ndarray
        kg/kg.
    """
    vapour = 611.21 * np.exp(17.502 * (dew_point - 273.16) / (dew_point - 32.19))
    return np.asarray(0.621981 * vapour / (pressure - 0.378019 * vapour))


def snow_of_precipitation(precipitation: Array, air_temperature: Array) -> Array:
    """Snowfall (as the precipitation): all of it in air below 0 degC, none above.

    Parameters
    ----------
    precipitation : ndarray
        kg/m2/s, or any other unit.
    air_temperature : ndarray
        K.

    Returns
    -------
    ndarray
        In the unit of the precipitation.
    """
    return np.where(air_temperature < ZERO_CELSIUS, precipitation, 0.0)
