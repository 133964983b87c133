# SPDX-License-Identifier: GPL-2.0-or-later
"""Thickness and area of the ice under the scene's mean weather, any effect on or off.

A zero-layer slab (Semtner 1976) with snow, open water beside it and a well mixed ocean below. What
it leaves out (salt, stored heat, categories) changes growth by tens of per cent, not its size.
"""

from __future__ import annotations

import math
from dataclasses import astuple, dataclass, replace
from functools import lru_cache

from floeflow.analysis.estimate.conditions import Conditions
from floeflow.analysis.estimate.dimensionless_numbers import (
    FREEZING,
    ICE_CONDUCTIVITY,
    ICE_HEAT,
    SNOW_CONDUCTIVITY,
    WATER_HEAT,
    edge_rate,
    sea_delay,
)
from floeflow.core.constants import (
    AIR_DENSITY,
    HEAT_AIR,
    LATENT_FUSION,
    LATENT_VAPOUR,
    SNOW_DENSITY,
    STEFAN_BOLTZMANN,
    VAPOUR_ICE,
    VAPOUR_ICE_EXPONENT,
    ZERO_CELSIUS,
)
from floeflow.scene.physics import ColumnPhysics

_KEYS = ColumnPhysics()
EMISSIVITY, TRANSFER = _KEYS.emissivity, _KEYS.bulk_transfer
LATENT_SUBLIMATION = LATENT_FUSION + LATENT_VAPOUR  # J/kg
ALBEDO_SNOW, ALBEDO_ICE, ALBEDO_POND, ALBEDO_WATER = 0.8, 0.55, 0.25, 0.06
STEPS = 200
# Effects that a run asks for: runs that differ in others alone are one.
ACTING = frozenset(
    ("thermodynamics", "shortwave", "snow", "ponds", "frazil", "lateral_melt", "mixed_layer")
    + ("ridging",)
)


@dataclass(frozen=True)
class Ice:
    """Ice at the end of the run.

    Parameters
    ----------
    area : float
        Share of the sea under ice.
    volume : float
        Ice volume per area of sea, m.
    """

    area: float
    volume: float


def surface_flux(c: Conditions, temperature: float, albedo: float) -> float:
    """Heat into a surface of this temperature (K), W/m2: radiation and bulk turbulent fluxes.

    Parameters
    ----------
    c : Conditions
        Conditions of the scene.
    temperature : float
        Of the surface (K).
    albedo : float
        Of the surface.

    Returns
    -------
    float
        W/m2, positive downward.
    """
    sun = (1.0 - albedo) * c.shortwave_down
    glow = EMISSIVITY * (c.longwave_down - STEFAN_BOLTZMANN * temperature**4)
    stir = AIR_DENSITY * TRANSFER * c.wind
    sensible = HEAT_AIR * stir * (c.air_temperature - temperature)
    vapour = VAPOUR_ICE * math.exp(-VAPOUR_ICE_EXPONENT / temperature) / AIR_DENSITY
    return sun + glow + sensible + LATENT_SUBLIMATION * stir * (c.specific_humidity - vapour)


def open_water_loss(c: Conditions) -> float:
    """Heat that open water at its freezing point gives to the air, W/m2.

    Parameters
    ----------
    c : Conditions
        Conditions of the scene.
    """
    return -surface_flux(c, FREEZING, ALBEDO_WATER)


def _surface(c: Conditions, conductance: float, albedo: float) -> tuple[float, float]:
    """Temperature of the surface (K, melting at most) and heat left over for melting, W/m2."""
    low, high = 180.0, ZERO_CELSIUS

    def excess(at: float) -> float:
        return surface_flux(c, at, albedo) + conductance * (FREEZING - at)

    if excess(high) >= 0.0:
        return high, excess(high)
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if excess(middle) > 0 else (low, middle)
    return 0.5 * (low + high), 0.0


def run_ice(c: Conditions, effects: frozenset[str]) -> Ice:
    """Ice at the end of the run: the mean of two halves of the sea, with more and less ice.

    Parameters
    ----------
    c : Conditions
        Of the scene.
    effects : frozenset of str
        Effects of the run; those that act are thermodynamics, what refines it, and ridging.
    """
    return _run_ice(c, effects & ACTING)


@lru_cache(maxsize=256)
def _run_ice(c: Conditions, effects: frozenset[str]) -> Ice:
    if "shortwave" not in effects:
        c = replace(c, shortwave_down=0.0)
    dense = min(1.0, c.concentration + c.concentration_spread, 2.0 * c.concentration)
    halves = [_run_half(c, area, effects) for area in (dense, 2.0 * c.concentration - dense)]
    return Ice(*(0.5 * (one + two) for one, two in zip(*map(astuple, halves), strict=True)))


def _run_half(c: Conditions, area: float, effects: frozenset[str]) -> Ice:
    volume, snow, pond = area * c.thickness, c.snow, 0.0
    heat = 0.0  # of the mixed layer above its freezing point, J/m2
    dt = c.seconds / STEPS
    shut = c.closing * c.yielding / STEPS if "ridging" in effects else 0.0
    for _ in range(STEPS):
        area *= 1.0 - shut
        if "thermodynamics" not in effects or not area > 0:
            continue
        thick = volume / area
        snowy = "snow" in effects and snow > 0.01
        albedo = ALBEDO_SNOW if snowy else ALBEDO_ICE
        albedo += (ALBEDO_POND - albedo) * pond
        layer = (snow if "snow" in effects else 0.0) / SNOW_CONDUCTIVITY
        conductance = 1.0 / (thick / ICE_CONDUCTIVITY + layer + 1.0e-3)
        skin, left = _surface(c, conductance, albedo)
        melt = dt * left / ICE_HEAT
        if "snow" in effects:
            snow = max(0.0, snow + dt * c.snowfall / SNOW_DENSITY - 2.8 * melt)
            melt = melt if snow <= 0.01 else 0.0
        if "ponds" in effects and left > 0:
            pond = min(0.3, pond + 0.3 * melt)
        below, side, lack, heat = _sea(c, effects, area, volume, heat, dt)
        growth = dt * (conductance * (FREEZING - skin) - below) / ICE_HEAT
        volume = max(0.0, volume + area * (growth - melt)) * (1.0 - side)
        # Melting opens water where the ice is thin: half of it (Hibler 1979), if it has layers.
        thinned = 0.5 * max(0.0, melt - growth) / max(thick, 1e-3) if c.layered else 0.0
        area *= 1.0 - min(1.0, side + thinned)
        if "frazil" in effects:
            made = lack / ICE_HEAT
            volume, area = volume + made, min(1.0, area + made / c.new_ice_thickness)
        area = area if volume > 0 else 0.0
    return Ice(area, volume)


def _sea(
    c: Conditions, effects: frozenset[str], area: float, volume: float, heat: float, dt: float
) -> tuple[float, float, float, float]:
    """Heat to the ice's bottom (W/m2), share melted from the sides, heat lacking, heat kept (J/m2).

    Water at its freezing point freezes and melts at once what leads lose and take up. A mixed layer
    keeps what sea and leads take up, hands it to the ice in the time `sea_delay`, and freezes when
    it has none left.
    """
    edges = "lateral_melt" in effects
    leads = -open_water_loss(c) * (1.0 - area) * dt
    if "mixed_layer" not in effects:
        leads += c.ocean_heat_flux * (1.0 - area) * dt
        stored = ICE_HEAT * volume
        side = min(1.0, max(0.0, leads) / stored) if edges and stored > 0 else 0.0
        return c.ocean_heat_flux, side, max(0.0, -leads), 0.0
    below = heat * -math.expm1(-dt / sea_delay(c)) / dt
    side = min(1.0, edge_rate(heat / (WATER_HEAT * c.mixed_layer_depth)) * dt) if edges else 0.0
    heat += c.ocean_heat_flux * dt + leads - below * area * dt - side * ICE_HEAT * volume
    return below, side, max(0.0, -heat), max(0.0, heat)
