# SPDX-License-Identifier: GPL-2.0-or-later
"""Temperatures and salt of mushy layers by Turner, Hunke and Bitz (2013).

The liquid fraction is held in a step, so the layers are linear and only the surface is not: its
balance is concave and Newton's method cannot miss it. Numbers of equations are those of
docs/theory/column_mushy.md.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from floeflow.column.physics import jit
from floeflow.column.ponds.flushing import flushing
from floeflow.column.thermodynamics.bl99 import Balance
from floeflow.column.thermodynamics.boundary_layer import surface_balance
from floeflow.column.thermodynamics.drainage import drain
from floeflow.column.thermodynamics.enthalpy import snow_enthalpy
from floeflow.column.thermodynamics.mush import (
    brine_enthalpy,
    brine_salinity,
    liquid_fraction,
    liquidus,
    mush_enthalpy,
)
from floeflow.column.thermodynamics.profile import conductances

if TYPE_CHECKING:
    from floeflow.column.physics import Physics
    from floeflow.column.records import Water
    from floeflow.column.thermodynamics.boundary_layer import SurfaceForcing
    from floeflow.column.thermodynamics.profile import Profile

LEAST_SALINITY = 0.01  # 1e-3


@jit
def solve_mush(
    w: Profile,
    first: int,
    surface: float,
    water: Water,
    forcing: SurfaceForcing,
    pond: tuple[float, ...],
    dt: float,
    p: Physics,
) -> tuple[Balance, float, float, float]:
    """Temperatures, enthalpies and salinities after dt; fluxes, and heat that brine carries off.

    Arguments and first result as `bl99.solve_temperatures`, but ``water``: the `Water` under the
    ice, and ``pond``: depth (m) and share of the ice. The second is heat that goes to the sea
    (W/m2), the third the salt that the ice gained (1e-3 m), negative; the last the speed of
    flushing (m/s).

    Parameters
    ----------
    w : Profile
        Its temperature, enthalpy and salinity are advanced.
    first : int
        Number of snow layers, which is the row of the uppermost ice layer.
    surface : float
        Temperature of the surface at the start (degC).
    water : Water
        Under the ice.
    forcing : SurfaceForcing
        Of the surface.
    pond : tuple of float
        Depth of the pond (m), and its share of the ice.
    dt : float
        Time step (s).
    p : Physics
        Constants.

    Returns
    -------
    tuple of Balance, float, float and float
        Fluxes and temperature of the surface; heat that brine carries to the sea (W/m2); salt
        gained (1e-3 m, negative: lost); speed of flushing (m/s).
    """
    bottom = water.freezing
    z = w.thickness.size
    top = 0 if first > 0 and w.thickness[0] * first > p.least_snow else first
    ice = 0.0
    for k in range(first, z):
        w.liquid[k] = liquid_fraction(w.temperature[k], w.salt[k])
        ice += w.thickness[k]
    snow = w.thickness[0] * first if top < first else 0.0
    sinks = 0.0
    if p.ponds and p.flushing:
        sinks = flushing(w, first, ice, snow, pond[0], pond[1], dt, p)
    drain(w, first, ice, surface, bottom, water.salinity, dt, p)
    conductances(w, top, first, p)

    # Bare mush melts from the temperature on at which its salinity is that of brine.
    melting = 0.0 if top < first else liquidus(w.salt[first])
    cold = surface < melting
    start = surface if cold else melting
    for k in range(top, z):
        fill_mush(w, top, k, first, bottom, sinks, dt, p)
    eliminate(w, z - top + 1)
    found = settle_surface(w, top, cold, start, forcing, p)
    sweeps = found.sweeps
    warm = found.temperature > melting if cold else found.net >= found.top
    if warm == cold:
        found = settle_surface(w, top, not warm, melting, forcing, p)
        sweeps += found.sweeps
    w.solution[0] = found.temperature
    for row in range(1, z - top + 1):
        w.solution[row] = w.right[row] + w.lower[row] * w.solution[row - 1]
    advected = 0.0
    rest = found.top
    warm_sea = brine_enthalpy(bottom, p)
    for k in range(top, z):
        w.temperature[k] = w.solution[k - top + 1]
        if k < first:
            w.enthalpy[k] = snow_enthalpy(w.temperature[k], p)
        else:
            w.enthalpy[k] = mush_enthalpy(w.temperature[k], w.liquid[k], p)
        rest += w.source[k] - w.thickness[k] * (w.enthalpy[k] - w.first_enthalpy[k]) / dt
    for k in range(first, z):
        below = brine_enthalpy(w.temperature[k + 1], p) if k < z - 1 else warm_sea
        advected -= w.flow[k] * (below - brine_enthalpy(w.temperature[k], p))
    # Pond water comes in at 0 degC, whose enthalpy is zero.
    advected += sinks * brine_enthalpy(w.temperature[z - 1], p)
    salt = desalinate(w, first, water.salinity, sinks, dt)
    found = Balance(
        min(found.temperature, 0.0), found.net, found.latent, found.top, rest - advected, sweeps,
        found.left,
    )  # fmt: skip
    return found, advected, salt, sinks


@jit
def eliminate(w: Profile, rows: int) -> None:
    """Eliminate the layers from the bottom up.

    Each is left as a linear function of the one above it, the first of the surface: its constant in
    ``w.right``, its factor in ``w.lower``. The surface then is one equation for one unknown.

    Parameters
    ----------
    w : Profile
        Its tridiagonal system; ``right`` and ``lower`` are overwritten.
    rows : int
        Number of rows, that of the surface included.
    """
    right = factor = 0.0
    for row in range(rows - 1, 0, -1):
        pivot = 1.0 / (w.diagonal[row] + w.upper[row] * factor)
        right = (w.right[row] - w.upper[row] * right) * pivot
        factor = -w.lower[row] * pivot
        w.right[row], w.lower[row] = right, factor


@jit
def settle_surface(
    w: Profile, top: int, cold: bool, surface: float, forcing: SurfaceForcing, p: Physics
) -> Balance:
    """Solve for a surface that is cold, or for one that is kept at its temperature.

    A cold surface may come out above melting.

    Parameters
    ----------
    w : Profile
        After `eliminate`.
    top : int
        Uppermost layer that counts.
    cold : bool
        The temperature of the surface is sought, else it is kept.
    surface : float
        First guess, or the temperature that is kept (degC).
    forcing : SurfaceForcing
        Of the surface.
    p : Physics
        Constants.

    Returns
    -------
    Balance
        Without the flux at the bottom.
    """
    change, sweeps = 1.0, 0
    net = latent = 0.0
    conducts = w.conductance[top]
    while change > p.surface_tolerance and sweeps < p.mush_iterations:
        sweeps += 1
        net, slope, latent, latent_slope = surface_balance(surface, forcing, p)
        change = 0.0
        if cold:
            new = (slope * surface - net - conducts * w.right[1]) / (
                slope - conducts * (1.0 - w.lower[1])
            )
            step, surface = new - surface, new
            change = abs(step)
            net, latent = net + slope * step, latent + latent_slope * step
    into = net if cold else conducts * (surface - w.right[1] - w.lower[1] * surface)
    left = 0.0 if change <= p.surface_tolerance else change
    return Balance(surface, net, latent, into, 0.0, sweeps, left + 0.0 * w.right[1])


@jit
def fill_mush(
    w: Profile, top: int, k: int, first: int, bottom: float, sinks: float, dt: float, p: Physics
) -> None:
    """Row of a layer: storage, conduction, exchange of brine upward and flushing (eqs. 10, 11).

    Parameters
    ----------
    w : Profile
        The row of its tridiagonal system is set.
    top : int
        Uppermost layer that counts.
    k : int
        Layer.
    first : int
        Number of snow layers, which is the row of the uppermost ice layer.
    bottom : float
        Temperature of the water (degC).
    sinks : float
        Speed of flushing, downward (m/s).
    dt : float
        Time step (s).
    p : Physics
        Constants.
    """
    row, z = k - top + 1, w.thickness.size
    per_time = w.thickness[k] / dt
    exchange = flushed = 0.0
    if k < first:
        capacity = p.snow_density * p.heat_ice
        bound = p.snow_density * p.fusion
    else:
        ice = 1.0 - w.liquid[k]
        capacity = w.liquid[k] * p.heat_water * p.water_density + ice * p.ice_density * p.heat_ice
        bound = ice * p.ice_density * p.fusion
        exchange = w.flow[k] * p.heat_water * p.water_density
        flushed = sinks * p.heat_water * p.water_density
    w.lower[row] = -w.conductance[k] - (flushed if k > first else 0.0)
    w.upper[row] = -w.conductance[k + 1] - exchange
    w.diagonal[row] = capacity * per_time + w.conductance[k] + w.conductance[k + 1] + exchange
    w.diagonal[row] += flushed
    w.right[row] = per_time * (w.first_enthalpy[k] + bound) + w.source[k]
    if k == z - 1:
        w.right[row] += (w.conductance[z] + exchange) * bottom


@jit
def desalinate(w: Profile, first: int, sea_salinity: float, sinks: float, dt: float) -> float:
    """Exchange salt with brine below, drain slowly, flush (eq. 12); salt gained (1e-3 m).

    Parameters
    ----------
    w : Profile
        The salinity of its ice is changed.
    first : int
        Number of snow layers, which is the row of the uppermost ice layer.
    sea_salinity : float
        1e-3.
    sinks : float
        Speed of flushing, downward (m/s).
    dt : float
        Time step (s).

    Returns
    -------
    float
        Negative: lost to the sea.
    """
    z = w.thickness.size
    gained = above = 0.0
    for k in range(first, z):
        below = brine_salinity(w.temperature[k + 1]) if k < z - 1 else sea_salinity
        brine = brine_salinity(w.temperature[k])
        rate = w.flow[k] * (below - brine) / w.thickness[k] + w.drain[k]
        rate += sinks * (above - brine) / w.thickness[k]
        above = brine
        change = max(rate * dt, min(LEAST_SALINITY - w.salt[k], 0.0))
        w.salt[k] += change
        gained += w.thickness[k] * change
    return gained
