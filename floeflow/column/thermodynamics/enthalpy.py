# SPDX-License-Identifier: GPL-2.0-or-later
"""Enthalpy, temperature, salinity and conductivity of ice and snow layers.

Enthalpy (J/m3) is the energy that is missing to melt the ice and to bring its water to 0 degC: it
is negative. A layer of salinity S melts over a range of temperature, as its brine grows; at
``Tm = -melting_slope * S`` it is all brine. "Theory" here and in the other modules of the layered
column is docs/theory/column_bl99.md.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from floeflow.column.physics import TINY, Physics, jit


def salinity_profile(layers: int, p: Physics) -> NDArray[np.float64]:
    """Salinity at the middles of equal ice layers (Bitz and Lipscomb 1999; theory, eq. 6).

    A fit to the profiles of multi-year ice of Schwarzacher (1959): fresh at the top, saltiest at
    the bottom.

    Parameters
    ----------
    layers : int
        Number of ice layers.
    p : Physics
        Constants.

    Returns
    -------
    ndarray
        1e-3, (layers,), top first.
    """
    z = (np.arange(layers) + 0.5) / layers
    shape = 1.0 - np.cos(math.pi * z ** (0.407 / (0.573 + z)))
    profile = np.maximum(0.5 * p.bottom_salinity * shape, p.top_salinity_floor)
    # Where even the bottom is fresher than the floor the ice is taken as fresh.
    return np.asarray(profile if p.bottom_salinity > p.top_salinity_floor else 0.0 * profile)


@jit
def ice_enthalpy(temperature: float, melting: float, p: Physics) -> float:
    """Enthalpy (J/m3) of ice at a temperature (degC) (Bitz and Lipscomb 1999; theory, eq. 3).

    Parameters
    ----------
    temperature : float
        degC, at most ``melting``, which is below 0 unless the ice is fresh.
    melting : float
        Melting point of the layer (degC).
    p : Physics
        Constants.

    Returns
    -------
    float
        J/m3, negative.
    """
    brine = 0.0 if melting == 0.0 else melting / temperature
    return -p.ice_density * (
        p.heat_ice * (melting - temperature) + p.fusion * (1.0 - brine) - p.heat_water * melting
    )


@jit
def ice_temperature(enthalpy: float, melting: float, p: Physics) -> float:
    """Temperature (degC) of ice of an enthalpy (J/m3), at most ``melting``.

    Inverse of the enthalpy (theory, eq. 4) in a form that loses no digits at either end.

    Parameters
    ----------
    enthalpy : float
        J/m3.
    melting : float
        Melting point of the layer (degC).
    p : Physics
        Constants.

    Returns
    -------
    float
        degC.
    """
    a = p.heat_ice
    b = (p.heat_water - p.heat_ice) * melting - enthalpy / p.ice_density - p.fusion
    c = p.fusion * melting
    return min(negative_root(a, b, c), melting)


@jit
def negative_root(a: float, b: float, c: float) -> float:
    """Lower root of a x**2 + b x + c with a > 0 and c <= 0, at most zero.

    Parameters
    ----------
    a : float
        Coefficients.
    b : float
        Coefficients.
    c : float
        Coefficients.

    Returns
    -------
    float
        The root.
    """
    root = math.sqrt(b * b - 4.0 * a * c)
    if b > 0.0:
        return -(b + root) / (2.0 * a)
    return 2.0 * c / (root - b) if root > b else 0.0


@jit
def snow_temperature(enthalpy: float, p: Physics) -> float:
    """Temperature (degC) of snow of an enthalpy (J/m3), at most zero.

    Parameters
    ----------
    enthalpy : float
        J/m3.
    p : Physics
        Constants.

    Returns
    -------
    float
        degC.
    """
    return min((p.fusion + enthalpy / p.snow_density) / p.heat_ice, 0.0)


@jit
def snow_enthalpy(temperature: float, p: Physics) -> float:
    """Enthalpy (J/m3) of snow at a temperature (degC).

    Parameters
    ----------
    temperature : float
        degC.
    p : Physics
        Constants.

    Returns
    -------
    float
        J/m3, negative.
    """
    return -p.snow_density * (p.fusion - p.heat_ice * temperature)


@jit
def ice_conductivity(temperature: float, salinity: float, p: Physics) -> float:
    """Conductivity (W/m/K) of ice.

    Pringle et al. (2007), "bubbly", or Maykut and Untersteiner (1971); theory, eq. 5.

    Parameters
    ----------
    temperature : float
        degC.
    salinity : float
        1e-3.
    p : Physics
        Constants.

    Returns
    -------
    float
        W/m/K, at least ``p.least_conductivity``.
    """
    brine = salinity / min(-TINY, temperature)
    if p.bubbly:
        k = (2.11 - 0.011 * temperature + 0.09 * brine) * p.ice_density / 917.0
    else:
        k = p.fresh_conductivity + p.brine_conductivity * brine
    return max(k, p.least_conductivity)
