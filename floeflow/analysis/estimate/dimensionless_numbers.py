# SPDX-License-Identifier: GPL-2.0-or-later
"""The dimensionless number of each effect: near or above 1 it matters, far below it does not.

Those that are a product or ratio of the scene's conditions stand in the entries of the registry
(`floeflow.scene.effects`). Each of the others is a function here, under the effect's name. The
first line of its docstring is what the documents and the tables say.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from floeflow.analysis.estimate.conditions import Conditions
from floeflow.core.constants import ICE_DENSITY, LATENT_FUSION, SNOW_DENSITY, ZERO_CELSIUS
from floeflow.scene.effects import EFFECTS, ratio
from floeflow.scene.physics import ColumnPhysics

Number = Callable[[Conditions], float]

_KEYS = ColumnPhysics()
ICE_CONDUCTIVITY, SNOW_CONDUCTIVITY = _KEYS.ice_conductivity, _KEYS.snow_conductivity
FREEZING = ZERO_CELSIUS - 1.8
ICE_HEAT = ICE_DENSITY * LATENT_FUSION
# Floes are far smaller than elements: their edges are what melts laterally (Steele 1992).
FLOE_DIAMETER, FLOE_SHAPE = _KEYS.floe_diameter, 0.66
WATER_HEAT = 4.1e6  # J/m3/K
# Stanton number of heat from the sea to the ice, least friction velocity (Maykut & McPhee 1995).
SEA_TRANSFER, LEAST_FRICTION = _KEYS.ocean_transfer, 5.0e-4
OPEN_ABSORPTION, ICE_ABSORPTION = 0.94, 0.35

NUMBERS: dict[str, Number] = {}


def number_of(name: str) -> Callable[[Number], Number]:
    """Register the number of an effect.

    Parameters
    ----------
    name : str
        Of the effect.

    Returns
    -------
    callable
        Decorator that registers a function and returns it.
    """

    def register(function: Number) -> Number:
        NUMBERS[name] = function
        return function

    return register


def meaning(name: str) -> str:
    """What an effect's number is, in one line; empty where it has none.

    Parameters
    ----------
    name : str
        Of the effect.
    """
    own, function = EFFECTS[name].number, NUMBERS.get(name)
    if own is not None:
        return own.meaning
    return (function.__doc__ or "").splitlines()[0].rstrip(".") if function else ""


def number_value(name: str, c: Conditions) -> float:
    """The dimensionless number of an effect under the conditions of a scene.

    Parameters
    ----------
    name : str
        Of the effect.
    c : Conditions
        Conditions of the scene.

    Returns
    -------
    float
        1; nan where the effect has none.
    """
    own = EFFECTS[name].number
    if own is not None:
        return own.value(c)
    return NUMBERS[name](c) if name in NUMBERS else math.nan


@number_of("turning_angle")
def turning_angle(c: Conditions) -> float:
    """2 sin(φ/2): how far the turned drag points from the plain one.

    Parameters
    ----------
    c : Conditions
        Conditions of the scene.
    """
    return 2.0 * math.sin(0.5 * abs(c.turning_angle))


@number_of("friction")
def friction(c: Conditions) -> float:
    """μ κ: friction times compaction, 0 for floes apart and 1 for a jammed pack.

    Parameters
    ----------
    c : Conditions
        Conditions of the scene.
    """
    return c.friction * c.compaction


@number_of("bonds")
def bonds(c: Conditions) -> float:
    """σ_t h / (τ_a L): tensile strength of the pack over the wind's pull across it.

    Parameters
    ----------
    c : Conditions
        Conditions of the scene.
    """
    if c.concentration < c.bond_concentration:
        return 0.0
    return ratio(c.strength * c.tensile_share * c.thickness, c.wind_stress * c.fetch)


@number_of("coast")
def coast(c: Conditions) -> float:
    """Share of the ice within an element of land.

    Parameters
    ----------
    c : Conditions
        Conditions of the scene.
    """
    return c.coast_share


@number_of("walls")
def walls(c: Conditions) -> float:
    """U T / L: drift over the width of the ice, which is what reaches a wall.

    Parameters
    ----------
    c : Conditions
        Conditions of the scene.
    """
    return ratio(c.slip * c.seconds, c.fetch)


@number_of("ridging")
def ridging(c: Conditions) -> float:
    """ε κ (1 - σ_c h / (τ_a L)): share of the area that a jammed pack closes, if the wind can.

    Parameters
    ----------
    c : Conditions
        Conditions of the scene.
    """
    return c.closing * c.yielding


@number_of("redistribution")
def redistribution(c: Conditions) -> float:
    """ε κ (1 - σ_c h / (τ_a L)): share of the area that ridges, told thick from thin.

    Parameters
    ----------
    c : Conditions
        Conditions of the scene.
    """
    return c.closing * c.yielding


@number_of("refreeze")
def refreeze(c: Conditions) -> float:
    """T / t_r in freezing air: the run over the time in which touching elements freeze together.

    Parameters
    ----------
    c : Conditions
        Conditions of the scene.
    """
    if c.air_temperature >= c.refreeze_temperature or bonds(c) == 0.0:
        return 0.0
    return c.seconds / c.refreeze_time * min(1.0, 1.0 / max(bonds(c), 1e-9))


@number_of("thermodynamics")
def thermodynamics(c: Conditions) -> float:
    """|F| T / (ρ_i L h): heat through the ice over the heat that melts it.

    Parameters
    ----------
    c : Conditions
        Conditions of the scene.
    """
    from floeflow.analysis.estimate.ice import run_ice

    grown = run_ice(c, frozenset({"thermodynamics"})).volume - c.thickness * c.concentration
    return ratio(abs(grown), c.thickness * c.concentration)


@number_of("snow")
def snow(c: Conditions) -> float:
    """k_i h_s / (k_s h): insulation by snow over that by ice.

    Parameters
    ----------
    c : Conditions
        Conditions of the scene.
    """
    fallen = c.snow + c.snowfall * c.seconds / SNOW_DENSITY
    return ratio(ICE_CONDUCTIVITY * fallen, SNOW_CONDUCTIVITY * c.thickness)


@number_of("shortwave")
def shortwave(c: Conditions) -> float:
    """(1 - α) F_s T / (ρ_i L h): absorbed sunlight over the heat that melts the ice.

    Parameters
    ----------
    c : Conditions
        Conditions of the scene.
    """
    return ratio(ICE_ABSORPTION * c.shortwave_down * c.seconds, ICE_HEAT * c.thickness)


@number_of("ponds")
def ponds(c: Conditions) -> float:
    """h_p (α_i - α_p) F_s T / (ρ_i L h): what melt water at the surface adds to melting.

    Parameters
    ----------
    c : Conditions
        Conditions of the scene.
    """
    melted = 0.0 if c.air_temperature < ZERO_CELSIUS - 1.0 else shortwave(c) * c.thickness
    covered = min(0.3, melted)
    return ratio(covered * 0.4 * c.shortwave_down * c.seconds, ICE_HEAT * c.thickness)


def sea_uptake(c: Conditions) -> float:
    """Heat that sea and leads take up from below and from the sun, W/m2 of sea.

    Parameters
    ----------
    c : Conditions
        Conditions of the scene.
    """
    return c.ocean_heat_flux + (1.0 - c.concentration) * OPEN_ABSORPTION * c.shortwave_down


def sea_delay(c: Conditions) -> float:
    """Time in which a mixed layer hands its heat to the ice (s): H / (c_h u*).

    Parameters
    ----------
    c : Conditions
        Conditions of the scene.
    """
    friction = max(math.sqrt(c.ocean_drag) * c.slip, LEAST_FRICTION)
    return c.mixed_layer_depth / (SEA_TRANSFER * friction)


def edge_rate(warmth: float) -> float:
    """Share of the ice that melts from its sides in a second, in water this much above freezing.

    Parameters
    ----------
    warmth : float
        Of the water above its freezing point (K).

    Returns
    -------
    float
        1/s.
    """
    return math.pi * 1.6e-6 * warmth**1.36 / (FLOE_SHAPE * FLOE_DIAMETER)


@number_of("lateral_melt")
def lateral_melt(c: Conditions) -> float:
    """π w T / (α D): melt of the floes' edges over their diameter, where the water is warm.

    Parameters
    ----------
    c : Conditions
        Conditions of the scene.
    """
    from floeflow.analysis.estimate.ice import open_water_loss

    lost = max(0.0, open_water_loss(c)) * (1.0 - c.concentration)
    left = max(0.0, sea_uptake(c) - lost)
    delay = sea_delay(c)
    held = left * delay * -math.expm1(-c.seconds / delay)
    return edge_rate(held / (WATER_HEAT * c.mixed_layer_depth)) * c.seconds


@number_of("frazil")
def frazil(c: Conditions) -> float:
    """(1 - A) |Q| T / (ρ_i L A h): new ice in open water over the ice there is.

    Parameters
    ----------
    c : Conditions
        Conditions of the scene.
    """
    from floeflow.analysis.estimate.ice import open_water_loss

    lost = max(0.0, open_water_loss(c)) * (1.0 - c.concentration) * c.seconds
    return ratio(lost, ICE_HEAT * c.thickness * max(c.concentration, 1e-6))


@number_of("mixed_layer")
def mixed_layer(c: Conditions) -> float:
    """(F_w + (1 - A)(1 - α_w) F_s) T / (ρ_i L |ΔV|): heat into the sea over that of the change.

    Parameters
    ----------
    c : Conditions
        Conditions of the scene.
    """
    from floeflow.analysis.estimate.ice import run_ice

    start = c.concentration * c.thickness
    parts = frozenset({"thermodynamics", "snow", "shortwave", "frazil", "lateral_melt"})
    change = abs(run_ice(c, parts).volume - start)
    return ratio(sea_uptake(c) * c.seconds, ICE_HEAT * max(change, 0.01 * start))


@number_of("sea_relaxation")
def sea_relaxation(c: Conditions) -> float:
    """1 - exp(-T / τ): share of its way to the given temperature that the sea is drawn.

    Parameters
    ----------
    c : Conditions
        Conditions of the scene.
    """
    return -math.expm1(-c.seconds / c.relaxation_time)
