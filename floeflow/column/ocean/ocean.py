# SPDX-License-Identifier: GPL-2.0-or-later
"""The slab mixed layer under an element: heat to ice, freezing potential, temperature.

Hunke et al. (2015), sections on the ocean and on ice-ocean fluxes; Maykut and McPhee (1995) for the
bottom, Maykut and Perovich (1987) and Steele (1992) for the sides.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from floeflow.column.physics import TINY, jit
from floeflow.column.thermodynamics.boundary_layer import sea_balance
from floeflow.column.thermodynamics.mush import liquidus

if TYPE_CHECKING:
    from floeflow.column.physics import Physics
    from floeflow.column.thermodynamics.boundary_layer import Air


class MixedLayer(NamedTuple):
    """The mixed layer under an element at the start of a step.

    Parameters
    ----------
    temperature, freezing : float
        Temperature and freezing point (degC).
    depth : float
        m.
    deep : float
        Heat from below (W/m2).
    """

    temperature: float
    freezing: float
    depth: float
    deep: float


@jit
def freezing_temperature(salinity: float, p: Physics) -> float:
    """Freezing point of sea water (degC): the liquidus of brine for mush, else a straight line.

    Parameters
    ----------
    salinity : float
        Of the water (1e-3).
    p : Physics
        Constants.

    Returns
    -------
    float
        degC.
    """
    if p.mushy:
        return liquidus(salinity)
    return -p.melting_slope * salinity


@jit
def heat_to_ice(
    sea: float, freezing: float, potential: float, friction: float, dt: float, p: Physics
) -> tuple[float, ...]:
    """Heat into the ice's bottom (W/m2) and the share of the ice that melts from its sides.

    Theory, eqs. 20 and 21; neither is limited yet by the heat that there is.

    Parameters
    ----------
    sea, freezing : float
        Temperature of the mixed layer and its freezing point (degC).
    potential : float
        Freezing (positive) or melting potential of the mixed layer (W/m2).
    friction : float
        Friction velocity under the ice (m/s).
    dt : float
        s.
    p : Physics
        Constants.

    Returns
    -------
    bottom, side : float
        Heat flux into the bottom, W/m2 of ice, not negative, and the share of the ice's area (0..1)
        that the step melts from its sides; both 0 where the sea is about to freeze.
    """
    if potential >= 0.0:
        return 0.0, 0.0
    warmer = max(sea - freezing, 0.0)
    speed = max(friction, p.least_friction_velocity)
    bottom = p.heat_water * p.water_density * p.ocean_transfer * warmer * speed
    rate = p.lateral_rate * warmer**p.lateral_power
    side = rate * dt * math.pi / (p.floe_shape * p.floe_diameter)
    return min(bottom, -potential), min(side, 1.0)


@jit
def limit(
    bottom: float, side: float, stored: float, potential: float, dt: float
) -> tuple[float, ...]:
    """Cut both so that they take no more than the melting potential (theory, eq. 22).

    ``stored`` is the energy of all ice and snow (J/m2, negative).

    Parameters
    ----------
    bottom : float
        Heat into the ice's bottom (W/m2).
    side : float
        Share of the ice that melts from its sides in the step.
    stored : float
        Energy of all ice and snow (J/m2, negative).
    potential : float
        Freezing (positive) or melting potential of the mixed layer (W/m2).
    dt : float
        Time step (s).

    Returns
    -------
    tuple of float
        Heat into the bottom (W/m2) and share that melts from the sides.
    """
    wanted = bottom - side * stored / dt
    if side <= 0.0 or wanted <= -potential:
        return bottom, side
    share = max(-potential / (wanted + TINY), 0.0)
    return bottom * share, side * share


@jit
def mix(
    layer: MixedLayer, open_water: float, light: float, air: Air, heat: float, dt: float, p: Physics
) -> tuple[float, ...]:
    """Advance the mixed layer; its temperature, the potential (W/m2) and terms of its budget.

    Theory, eqs. 25 and 26. Below freezing the layer is put back to its freezing point and the heat
    that this takes is the potential from which the next step makes ice; what exceeds the largest
    potential stays in the water as supercooling.

    Parameters
    ----------
    layer : MixedLayer
        At the start.
    open_water : float
        Share of the area.
    light : float
        Short-wave radiation that open water absorbs (W/m2 of open water).
    air : Air
        Above it.
    heat : float
        From the ice, and light through it (W/m2 of the area).
    dt : float
        s.
    p : Physics
        Constants.

    Returns
    -------
    tuple of float
        Temperature after (degC), potential, flux from the air (W/m2 of the area, without the light
        absorbed), latent heat (likewise), heat from below that was taken (W/m2).
    """
    sea, freezing, depth, deep = layer
    store = p.heat_water * p.water_density * depth / dt
    net, latent = sea_balance(sea, light, air, p)
    sea += (net * open_water + heat) / store
    if deep < 0.0:
        # Warm water is mixed down; where there is none left, none is, and no ice is made of it.
        deep = max(deep, min(freezing - sea, 0.0) * store)
    sea += deep / store
    potential = (freezing - sea) * store
    potential = min(max(potential, -p.largest_potential), p.largest_potential)
    if potential > 0.0:
        rest = (freezing - sea) * store - potential
        sea = freezing - rest / store
    return sea, potential, (net - light) * open_water, latent * open_water, deep
