# SPDX-License-Identifier: GPL-2.0-or-later
"""Temperatures of snow and ice by Bitz and Lipscomb (1999): implicit, with the surface balance.

The heat capacity of a layer is the one that makes the change of enthalpy exact once the iteration
stands still (theory, eqs. 1, 2 and 13). What the iteration leaves over, less than a milliwatt, is
counted at the bottom, so that a step conserves energy to round-off (theory, eq. 14).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from floeflow.column.physics import TINY, jit
from floeflow.column.thermodynamics.boundary_layer import surface_balance
from floeflow.column.thermodynamics.enthalpy import ice_enthalpy, snow_enthalpy
from floeflow.column.thermodynamics.newton_fallback import newton
from floeflow.column.thermodynamics.profile import conductances
from floeflow.column.thermodynamics.tridiagonal import fill_layer, fill_surface, solve

if TYPE_CHECKING:
    from floeflow.column.physics import Physics
    from floeflow.column.thermodynamics.boundary_layer import SurfaceForcing
    from floeflow.column.thermodynamics.profile import Profile


class Balance(NamedTuple):
    """Outcome of a temperature solve.

    Parameters
    ----------
    temperature : float
        Of the surface (degC).
    net, latent : float
        Flux into the surface, and the latent heat in it (W/m2).
    top, bottom : float
        Flux from the surface into the layers and from the layers to the bottom, downward (W/m2).
    sweeps : int
        Iterations; negative where the second method took over.
    left : float
        0 where the solve came to its tolerance, else the last change (K), or not a number.
    """

    temperature: float
    net: float
    latent: float
    top: float
    bottom: float
    sweeps: int
    left: float


@jit
def solve_temperatures(
    w: Profile,
    first: int,
    surface: float,
    bottom: float,
    forcing: SurfaceForcing,
    dt: float,
    p: Physics,
) -> Balance:
    """Temperatures and enthalpies of the layers after dt, and the fluxes at both ends.

    Parameters
    ----------
    w : Profile
        Its temperature and enthalpy are advanced.
    first : int
        Number of snow layers.
    surface, bottom : float
        Temperature of the surface at the start, and of the bottom (degC).
    forcing : SurfaceForcing
        Of the surface.
    dt : float
        s.
    p : Physics
        Constants.

    Returns
    -------
    Balance
    """
    # Snow that is too thin keeps what heat it has and lets the ice see the air.
    top = 0 if first > 0 and w.thickness[0] * first > p.least_snow else first
    conductances(w, top, first, p)
    found = iterate(w, top, first, surface, bottom, forcing, dt, p)
    if found.sweeps < 0:
        conductances(w, top, first, p)
        temperature, sweeps, left = newton(w, top, first, surface, bottom, forcing, dt, p)
        net, _, latent, _ = surface_balance(temperature, forcing, p)
        into = net
        if temperature >= 0.0:
            into = min(net, -w.conductance[top] * w.temperature[top])
        found = Balance(temperature, net, latent, into, 0.0, -sweeps, left)
    return closed(w, top, found, dt)


@jit
def closed(w: Profile, top: int, found: Balance, dt: float) -> Balance:
    """Let the bottom flux close the energy of the layers (theory, eq. 14).

    Parameters
    ----------
    w : Profile
        Layers after the solution.
    top : int
        Uppermost layer that counts.
    found : Balance
        Whose flux at the bottom is not set yet.
    dt : float
        Time step (s).

    Returns
    -------
    Balance
        With the flux out of the bottom (W/m2).
    """
    rest = found.top
    for k in range(top, w.thickness.size):
        gain = w.thickness[k] * (w.enthalpy[k] - w.first_enthalpy[k]) / dt
        rest += w.source[k] - gain
    # Heat that is not a number must not pass for a solution.
    left = found.left + 0.0 * rest
    return Balance(found.temperature, found.net, found.latent, found.top, rest, found.sweeps, left)


@jit
def iterate(
    w: Profile,
    top: int,
    first: int,
    surface: float,
    bottom: float,
    forcing: SurfaceForcing,
    dt: float,
    p: Physics,
) -> Balance:
    """Repeat linear solves until surface and fluxes stand still; sweeps < 0 where they do not.

    Parameters
    ----------
    w : Profile
        Its temperature and enthalpy are advanced; its conductances may be reduced.
    top : int
        Uppermost layer that counts.
    first : int
        Number of snow layers, which is the row of the uppermost ice layer.
    surface : float
        Temperature of the surface at the start, and of the bottom (degC).
    bottom : float
        Temperature of the surface at the start, and of the bottom (degC).
    forcing : SurfaceForcing
        Of the surface.
    dt : float
        Time step (s).
    p : Physics
        Constants.

    Returns
    -------
    Balance
        Its ``sweeps`` is -1 where ``p.iterations`` solves were not enough.
    """
    last_change = 0.0
    start = surface
    for sweep in range(1, p.iterations + 1):
        net, slope, latent, latent_slope = surface_balance(surface, forcing, p)
        if surface >= 0.0 and net < w.conductance[top] * (surface - w.temperature[top]):
            surface = -TINY
        cold = surface < 0.0
        start = surface
        if cold:
            fill_surface(w, top, surface, net, slope)
        for layer in range(top, w.thickness.size):
            heat = capacity(w, layer, first, p)
            fill_layer(w, top, layer, heat, w.first_temperature[layer], bottom, dt)
        solve(w, 0 if cold else 1, w.thickness.size - top + 1)
        surface = w.solution[0] if cold else 0.0

        steady = True
        average = 0.0
        change = surface - start
        if surface > TINY:
            # Past the melting point: the next solve starts from there.
            surface, change, average, steady = 0.0, -start, 0.5, False
        elif (
            start <= -TINY
            and abs(change) > TINY
            and change * last_change < 0.0
            and abs(change) > 0.5 * abs(last_change)
        ):
            # It swings: go half the way.
            change, average, steady = 0.5 * change, 0.5, False
            surface = start + change
        excess = update(w, top, first, average, p)

        steady = steady and abs(change) <= p.surface_tolerance
        net += change * slope
        latent += change * latent_slope
        into = w.conductance[top] * (surface - w.temperature[top])
        if surface >= 0.0 and net < into:
            steady = False
        if surface < 0.0:
            into = net
        found = Balance(surface, net, latent, into, 0.0, sweep, 0.0)
        through = w.conductance[w.thickness.size] * (w.temperature[-1] - bottom) + excess / dt
        error = abs(closed(w, top, found, dt).bottom - through)
        if error > p.flux_tolerance:
            steady = False
            throttle(w, first, error, abs(into - through))
        if steady:
            return found
        last_change = change
    return Balance(surface, 0.0, 0.0, 0.0, 0.0, -1, 0.0)


@jit
def capacity(w: Profile, layer: int, first: int, p: Physics) -> float:
    """Heat capacity (J/m3/K) between the first and the present temperature (theory, eq. 2).

    Parameters
    ----------
    w : Profile
        Layers of the category.
    layer : int
        Row of the layer.
    first : int
        Number of snow layers, which is the row of the uppermost ice layer.
    p : Physics
        Constants.

    Returns
    -------
    float
        Temperatures in degC; snow and fresh ice have a constant one.
    """
    if layer < first:
        return p.snow_density * p.heat_ice
    melting = w.melting[layer]
    if melting == 0.0:
        return p.ice_density * p.heat_ice
    brine = p.fusion * melting / (w.temperature[layer] * w.first_temperature[layer])
    return p.ice_density * (p.heat_ice - brine)


@jit
def update(w: Profile, top: int, first: int, average: float, p: Physics) -> float:
    """Take the solution into the profile, none above melting; returns what was cut (J/m2).

    Parameters
    ----------
    w : Profile
        Its temperature and enthalpy are set; ``edges`` tells what was cut of each layer (J/m3).
    top : int
        Uppermost layer that counts.
    first : int
        Number of snow layers, which is the row of the uppermost ice layer.
    average : float
        Share of the last temperatures in the new ones, 0 or 0.5.
    p : Physics
        Constants.

    Returns
    -------
    float
        Energy above the melting points (J/m2).
    """
    excess = 0.0
    for layer in range(top, w.thickness.size):
        temperature = w.solution[layer - top + 1]
        w.edges[layer] = 0.0
        if layer < first:
            temperature = min(temperature, 0.0)
        elif temperature > w.melting[layer] - TINY:
            melting = w.melting[layer]
            steep = p.heat_ice
            if melting < 0.0:
                steep -= p.fusion * melting / temperature**2
            w.edges[layer] = p.ice_density * (temperature - melting) * steep
            excess += w.thickness[layer] * w.edges[layer]
            temperature = melting
        temperature += average * (w.temperature[layer] - temperature)
        w.temperature[layer] = temperature
        if layer < first:
            w.enthalpy[layer] = snow_enthalpy(temperature, p)
        else:
            w.enthalpy[layer] = ice_enthalpy(temperature, w.melting[layer], p)
    return excess


@jit
def throttle(w: Profile, first: int, error: float, scale: float) -> None:
    """Let layers that would pass their melting point conduct less.

    Heat that a layer cannot take stays above it, instead of passing through to the bottom.

    Parameters
    ----------
    w : Profile
        Layers after `update`; their conductances are reduced.
    first : int
        Number of snow layers, which is the row of the uppermost ice layer.
    error : float
        Difference of the flux at the bottom from that which closes the energy (W/m2).
    scale : float
        Flux through the surface less that through the bottom (W/m2).
    """
    share = max(0.5 * (1.0 - error / scale), 0.1) if scale > 0.0 else 0.1
    for layer in range(first, w.thickness.size):
        if w.edges[layer] > 0.0:
            w.conductance[layer + 1] *= share
            w.conductance[layer] = w.conductance[layer + 1]
