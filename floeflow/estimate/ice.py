# SPDX-License-Identifier: GPL-2.0-or-later
"""Thickness and area of the ice under the scene's mean weather, any effect on or off.

A zero-layer slab (Semtner 1976) with snow, open water beside it and a well mixed ocean below. What
it leaves out (salt, stored heat, categories) changes growth by tens of per cent, not its size.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from floeflow.constants import AIR_DENSITY, SNOW_DENSITY, ZERO_CELSIUS
from floeflow.estimate.conditions import Conditions
from floeflow.estimate.numbers import (
    FREEZING,
    ICE_CONDUCTIVITY,
    ICE_HEAT,
    SNOW_CONDUCTIVITY,
    lateral_melt,
)

STEFAN_BOLTZMANN, EMISSIVITY = 5.67e-8, 0.97
AIR_HEAT, LATENT_VAPOUR, TRANSFER = 1004.0, 2.835e6, 1.75e-3
ALBEDO_SNOW, ALBEDO_ICE, ALBEDO_POND, ALBEDO_WATER = 0.8, 0.55, 0.25, 0.06
NEW_ICE = 0.1  # thickness at which it gathers, m
STEPS = 200


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
    """Heat into a surface of this temperature (K), W/m2: radiation and bulk turbulent fluxes."""
    sun = (1.0 - albedo) * c.shortwave_down
    glow = EMISSIVITY * (c.longwave_down - STEFAN_BOLTZMANN * temperature**4)
    stir = AIR_DENSITY * TRANSFER * c.wind
    sensible = AIR_HEAT * stir * (c.air_temperature - temperature)
    vapour = 11637800.0 * math.exp(-5897.8 / temperature) / AIR_DENSITY
    return sun + glow + sensible + LATENT_VAPOUR * stir * (c.specific_humidity - vapour)


def open_water_loss(c: Conditions) -> float:
    """Heat that open water at its freezing point gives to the air, W/m2."""
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
    """Ice at the end of the run.

    Parameters
    ----------
    c : Conditions
        Of the scene.
    effects : frozenset of str
        Effects that act: thermodynamics and what refines it, ridging.
    """
    if "shortwave" not in effects:
        c = replace(c, shortwave_down=0.0)
    area, volume = c.concentration, c.concentration * c.thickness
    snow, warmth, pond = c.snow, 0.0, 0.0
    dt = c.seconds / STEPS
    edge = lateral_melt(c) / STEPS if "lateral_melt" in effects else 0.0
    shut = c.closing * c.compaction / STEPS if "ridging" in effects else 0.0
    for _ in range(STEPS):
        if area > 0:
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
        below = c.ocean_heat_flux + warmth
        growth = dt * (conductance * (FREEZING - skin) - below) / ICE_HEAT
        volume = max(0.0, volume + area * (growth - melt))
        loss = open_water_loss(c) * (1.0 - area)
        if loss > 0 and "frazil" in effects:
            made = dt * loss / ICE_HEAT
            volume, area = volume + made, min(1.0, area + made / NEW_ICE)
        elif loss < 0 and "mixed_layer" in effects:
            # What leads take up melts ice from below within days.
            warmth = -loss
        volume *= 1.0 - edge
        # Melting opens water where the ice is thin: half of it (Hibler 1979).
        area *= 1.0 - min(1.0, edge + 0.5 * max(0.0, melt - growth) / max(thick, 1e-3))
    return Ice(area, volume)
