# SPDX-License-Identifier: GPL-2.0-or-later
"""Thermodynamics of a mush of ice and brine in equilibrium.

Turner, Hunke and Bitz (2013), with the liquidus of Assur (1958) in two pieces. Numbers of equations
are those of docs/theory/column_mushy.md.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from floeflow.column.physics import TINY, jit

if TYPE_CHECKING:
    from floeflow.column.physics import Physics

# Liquidus: brine salinity (1e-3) over temperature (degC), warm and cold piece, and their meeting.
WARM_SLOPE, WARM_OFFSET = -18.48, 0.0
COLD_SLOPE, COLD_OFFSET = -10.3085, 62.4
MEETING_TEMPERATURE, MEETING_SALINITY = -7.6362968855167352, 123.66702800276086


@jit
def brine_salinity(temperature: float) -> float:
    """Salinity (1e-3) of brine that is in equilibrium with ice (eq. 1).

    Parameters
    ----------
    temperature : float
        Of the ice (degC).

    Returns
    -------
    float
        1e-3; 0 above 0 degC.
    """
    if temperature > 0.0:
        return 0.0
    warm = temperature > MEETING_TEMPERATURE
    slope = WARM_SLOPE if warm else COLD_SLOPE
    over = slope * temperature + (WARM_OFFSET if warm else COLD_OFFSET)
    return 1000.0 * over / (1000.0 + over)


@jit
def liquidus(salinity: float) -> float:
    """Temperature (degC) at which brine of a salinity begins to freeze (eq. 1).

    Parameters
    ----------
    salinity : float
        Of the brine (1e-3).

    Returns
    -------
    float
        degC.
    """
    warm = salinity <= MEETING_SALINITY
    slope = WARM_SLOPE if warm else COLD_SLOPE
    offset = WARM_OFFSET if warm else COLD_OFFSET
    return (salinity / (1.0 - 0.001 * salinity) - offset) / slope


@jit
def liquid_fraction(temperature: float, salinity: float) -> float:
    """Volume share of brine (eq. 2).

    Parameters
    ----------
    temperature : float
        degC.
    salinity : float
        Bulk salinity of the mush (1e-3).

    Returns
    -------
    float
        0 to 1.
    """
    return salinity / max(max(brine_salinity(temperature), TINY), salinity)


@jit
def brine_density(salinity: float) -> float:
    """Density of brine (kg/m3) of a salinity (1e-3); Notz (2005); eq. 3.

    Parameters
    ----------
    salinity : float
        Of the brine (1e-3).

    Returns
    -------
    float
        kg/m3.
    """
    return 1000.3 + 0.78237 * salinity + 2.8008e-4 * salinity**2


@jit
def brine_enthalpy(temperature: float, p: Physics) -> float:
    """Enthalpy (J/m3) of brine or of the sea.

    Parameters
    ----------
    temperature : float
        degC.
    p : Physics
        Constants.

    Returns
    -------
    float
        J/m3, counted from water at 0 degC.
    """
    return p.heat_water * p.water_density * temperature


@jit
def mush_enthalpy(temperature: float, liquid: float, p: Physics) -> float:
    """Enthalpy (J/m3) of mush of a liquid fraction (eq. 4).

    Parameters
    ----------
    temperature : float
        degC.
    liquid : float
        Volume share of brine.
    p : Physics
        Constants.

    Returns
    -------
    float
        J/m3.
    """
    ice = p.heat_ice * temperature - p.fusion
    return liquid * brine_enthalpy(temperature, p) + (1.0 - liquid) * p.ice_density * ice


@jit
def melted_enthalpy(salinity: float, p: Physics) -> float:
    """Enthalpy (J/m3) at which the last ice of mush of a bulk salinity melts.

    Parameters
    ----------
    salinity : float
        Bulk salinity of the mush (1e-3).
    p : Physics
        Constants.

    Returns
    -------
    float
        J/m3.
    """
    return brine_enthalpy(liquidus(salinity), p)


@jit
def mush_temperature(enthalpy: float, salinity: float, p: Physics) -> float:
    """Temperature (degC) of mush of an enthalpy (J/m3) and bulk salinity (1e-3).

    Root of eq. 4 with the liquid fraction of eqs. 1 and 2 in the piece of the liquidus where it
    lies.

    Parameters
    ----------
    enthalpy : float
        J/m3.
    salinity : float
        Bulk salinity of the mush (1e-3).
    p : Physics
        Constants.

    Returns
    -------
    float
        degC.
    """
    if enthalpy > melted_enthalpy(salinity, p):
        return enthalpy / (p.heat_water * p.water_density)
    meeting = mush_enthalpy(MEETING_TEMPERATURE, salinity / MEETING_SALINITY, p)
    warm = enthalpy > meeting
    slope = WARM_SLOPE if warm else COLD_SLOPE
    offset = WARM_OFFSET if warm else COLD_OFFSET
    heat = p.ice_density * p.heat_ice
    latent = p.ice_density * p.fusion
    excess = p.water_density * p.heat_water - heat
    # liquid = salinity (1 + (slope T + offset)/1000) / (slope T + offset), times the denominator.
    shift = 1.0 + 0.001 * offset
    a = 0.001 * slope * salinity * excess + heat * slope
    b = salinity * (shift * excess + 0.001 * slope * latent)
    b += heat * offset - slope * (latent + enthalpy)
    c = salinity * shift * latent - offset * (latent + enthalpy)
    return (-b + math.sqrt(max(b * b - 4.0 * a * c, 0.0))) / (2.0 * a)


@jit
def mush_conductivity(temperature: float, salinity: float, p: Physics) -> float:
    """Conductivity (W/m/K) of mush (eq. 5).

    Parameters
    ----------
    temperature : float
        degC.
    salinity : float
        Bulk salinity of the mush (1e-3).
    p : Physics
        Constants.

    Returns
    -------
    float
        W/m/K.
    """
    liquid = liquid_fraction(temperature, salinity)
    contrast = p.mush_brine_conductivity - p.mush_ice_conductivity
    return p.mush_ice_conductivity + liquid * contrast
