# SPDX-License-Identifier: GPL-2.0-or-later
"""Turbulent and long-wave exchange of ice, snow and sea with the air, with stability.

Monin-Obukhov similarity in a fixed number of iterations: Kauffman and Large (2002), and Jordan et
al. (1999) for calm air.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from floeflow.column.physics import KELVIN, jit

if TYPE_CHECKING:
    from floeflow.column.physics import Physics


class Air(NamedTuple):
    """What a surface sees of the air in a step, beside the light that it absorbs.

    Parameters
    ----------
    potential_temperature : float
        K.
    humidity : float
        kg/kg.
    density : float
        kg/m3.
    wind : float
        m/s.
    longwave : float
        Downward (W/m2).
    """

    potential_temperature: float
    humidity: float
    density: float
    wind: float
    longwave: float


class SurfaceForcing(NamedTuple):
    """What drives the balance of a surface of ice or snow in a step.

    Parameters
    ----------
    light : float
        Short-wave radiation absorbed at the surface (W/m2).
    air : Air
        Above.
    sensible, latent : float
        Coefficients of sensible heat (W/m2/K) and of latent heat (W/m2 per kg/kg), of `transfer`.
    """

    light: float
    air: Air
    sensible: float
    latent: float


@jit
def transfer(temperature: float, air: Air, sea: bool, p: Physics) -> tuple[float, ...]:
    """Coefficients of sensible heat (W/m2/K) and of latent heat (W/m2 per kg/kg).

    Kauffman and Large (2002); theory, eq. 9: neutral coefficients of ice from its roughness,
    of the sea from Large and Pond (1982), then the shift to the stability of the air.

    Parameters
    ----------
    temperature : float
        Of the surface at the step's start (degC).
    air : Air
        Above it.
    sea : bool
        Open water, else ice or snow.
    p : Physics
        Constants.

    Returns
    -------
    sensible, latent : float
        W/m2 for each K, and W/m2 for each kg/kg, by which the air differs from the surface.
    """
    wind = max(p.least_wind, air.wind)
    if sea:
        neutral = math.sqrt(0.0027 / wind + 0.000142 + 0.0000764 * wind)
        saturated = p.vapour_sea * math.exp(-p.vapour_sea_exponent / (temperature + KELVIN))
        latent = p.vapour
    else:
        neutral = p.karman / math.log(p.reference_height / p.ice_roughness)
        saturated = p.vapour_ice * math.exp(-p.vapour_ice_exponent / (temperature + KELVIN))
        latent = p.vapour + p.fusion
    saturated /= air.density
    warmer = air.potential_temperature - (temperature + KELVIN)
    moister = air.humidity - saturated
    virtual = air.potential_temperature * (1.0 + p.virtual * air.humidity)
    height = math.log(p.forcing_height / p.reference_height)
    momentum, scalar = neutral, neutral
    buoyancy = p.karman * p.gravity * p.forcing_height
    for _ in range(p.stability_iterations):
        friction = momentum * wind
        per_heat = warmer / virtual + moister / (1.0 / p.virtual + air.humidity)
        ratio = buoyancy * scalar * per_heat / friction**2
        psi_momentum, psi_scalar = stability(min(max(ratio, -10.0), 10.0))
        momentum = neutral / (1.0 + neutral / p.karman * (height - psi_momentum))
        scalar = neutral / (1.0 + neutral / p.karman * (height - psi_scalar))
    moist_air = p.heat_air * (1.0 + (p.heat_vapour / p.heat_air - 1.0) * saturated)
    exchange = air.density * momentum * wind * scalar
    return exchange * moist_air + p.windless, exchange * latent


@jit
def stability(ratio: float) -> tuple[float, ...]:
    """Integrated stability functions of momentum and scalars at z/L.

    Stable: Holtslag and De Bruin (1988). Unstable: Paulson (1970). Theory, eq. 10.

    Parameters
    ----------
    ratio : float
        Height over Obukhov length, z/L (1).

    Returns
    -------
    tuple of float
        Of momentum and of scalars (1).
    """
    if ratio >= 0.0:
        psi = -(0.7 * ratio + 0.75 * (ratio - 14.3) * math.exp(-0.35 * ratio) + 10.7)
        return psi, psi
    square = math.sqrt(1.0 - 16.0 * ratio)
    x = math.sqrt(square)
    momentum = math.log((1.0 + x * (2.0 + x)) * (1.0 + square) / 8.0)
    momentum += 0.5 * math.pi - 2.0 * math.atan(x)
    return momentum, 2.0 * math.log((1.0 + square) / 2.0)


@jit
def surface_balance(temperature: float, forcing: SurfaceForcing, p: Physics) -> tuple[float, ...]:
    """Fluxes into ice or snow (W/m2), their slope (W/m2/K), latent heat and its slope.

    Light absorbed at the surface, long-wave, sensible, latent (theory, eq. 8), at a temperature
    (degC) under a `SurfaceForcing`.

    Parameters
    ----------
    temperature : float
        Of the surface (degC).
    forcing : SurfaceForcing
        Light, air and transfer coefficients.
    p : Physics
        Constants.

    Returns
    -------
    tuple of float
        Net flux (W/m2), its derivative (W/m2/K), latent heat (W/m2), its derivative (W/m2/K).
    """
    air, sensible, latent = forcing.air, forcing.sensible, forcing.latent
    kelvin = temperature + KELVIN
    humidity = p.vapour_ice * math.exp(-p.vapour_ice_exponent / kelvin) / air.density
    vapour = latent * (air.humidity - humidity)
    vapour_slope = -latent * humidity * p.vapour_ice_exponent / kelvin**2
    emitted = p.emissivity * p.stefan_boltzmann * kelvin**3
    net = forcing.light + p.emissivity * air.longwave - emitted * kelvin + vapour
    net += sensible * (air.potential_temperature - kelvin)
    return net, -4.0 * emitted - sensible + vapour_slope, vapour, vapour_slope


@jit
def sea_balance(temperature: float, light: float, air: Air, p: Physics) -> tuple[float, ...]:
    """Fluxes into open water and its latent heat (W/m2), black to long waves (theory, eq. 25).

    Parameters
    ----------
    temperature : float
        Of the water (degC).
    light : float
        Short-wave radiation that the water absorbs (W/m2).
    air : Air
        Above it.
    p : Physics
        Constants.

    Returns
    -------
    tuple of float
        Net flux and latent heat (W/m2 of open water).
    """
    kelvin = temperature + KELVIN
    sensible, latent = transfer(temperature, air, True, p)
    humidity = p.vapour_sea * math.exp(-p.vapour_sea_exponent / kelvin) / air.density
    vapour = latent * (air.humidity - humidity)
    net = light + air.longwave - p.stefan_boltzmann * kelvin**4 + vapour
    return net + sensible * (air.potential_temperature - kelvin), vapour
