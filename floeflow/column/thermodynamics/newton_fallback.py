# SPDX-License-Identifier: GPL-2.0-or-later
"""A method for temperatures that cannot fail: Newton's, on a convex monotone system.

The enthalpy of ice is a convex rising function of its temperature, and stays one when it is
continued steeply above the melting point; so is minus the net flux into the surface. Conduction
couples neighbours with the right signs. Newton's method on such a system comes down on its only
solution from above after one step, from wherever it starts (Ortega and Rheinboldt 1970),
steps growing quadratically smaller. Layers that end above their melting point are cut there;
the energy cut goes to the bottom, as in `bl99`. It serves where the iteration of `bl99` does not
converge, and is counted; so is where it does not come to its tolerance either.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from floeflow.column.physics import jit
from floeflow.column.thermodynamics.boundary_layer import surface_balance
from floeflow.column.thermodynamics.enthalpy import ice_enthalpy, snow_enthalpy
from floeflow.column.thermodynamics.tridiagonal import fill_layer, fill_surface, solve

if TYPE_CHECKING:
    from floeflow.column.physics import Physics
    from floeflow.column.thermodynamics.boundary_layer import SurfaceForcing
    from floeflow.column.thermodynamics.profile import Profile

TOLERANCE = 1e-9  # K
STEEP = 1000.0  # slope of enthalpy above the melting point, over the one below
BARRIER = 1e8  # W/m2/K: slope of the surface's losses above melting


@jit
def newton(
    w: Profile,
    top: int,
    first: int,
    surface: float,
    bottom: float,
    forcing: SurfaceForcing,
    dt: float,
    p: Physics,
) -> tuple[float, int, float]:
    """Temperatures and enthalpies after dt; surface temperature, steps, and what is left (K).

    Arguments as `bl99.solve_temperatures`; ``top`` is the uppermost layer that counts. What is left
    is 0 where the temperatures stand still, else their last change, or not a number.

    Parameters
    ----------
    w : Profile
        Its temperature and enthalpy are advanced.
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
    tuple of float, int and float
        Temperature of the surface (degC), number of steps, what is left (K).
    """
    z = w.thickness.size
    for layer in range(top, z):
        w.temperature[layer] = w.first_temperature[layer]
    steps = 0
    change = 1.0
    while change > TOLERANCE and steps < p.fallback_iterations:
        steps += 1
        melting = min(surface, 0.0)
        net, slope, _, _ = surface_balance(melting, forcing, p)
        if surface > 0.0:
            net -= BARRIER * surface
            slope = -BARRIER
        fill_surface(w, top, surface, net, slope)
        for layer in range(top, z):
            enthalpy, capacity = continued(w, layer, first, p)
            start = w.temperature[layer] + (w.first_enthalpy[layer] - enthalpy) / capacity
            fill_layer(w, top, layer, capacity, start, bottom, dt)
        solve(w, 0, z - top + 1)
        change = abs(w.solution[0] - surface)
        surface = w.solution[0]
        for layer in range(top, z):
            new = w.solution[layer - top + 1]
            change = max(change, abs(new - w.temperature[layer]))
            w.temperature[layer] = new
    left = 0.0 if change <= TOLERANCE else change
    for layer in range(top, z):
        # Comparisons pass over what is not a number; a sum does not.
        left += 0.0 * w.temperature[layer]
    left += 0.0 * surface
    for layer in range(top, z):
        w.temperature[layer] = min(w.temperature[layer], w.melting[layer])
        if layer < first:
            w.enthalpy[layer] = snow_enthalpy(w.temperature[layer], p)
        else:
            w.enthalpy[layer] = ice_enthalpy(w.temperature[layer], w.melting[layer], p)
    return min(surface, 0.0), steps, left


@jit
def continued(w: Profile, layer: int, first: int, p: Physics) -> tuple[float, ...]:
    """Enthalpy (J/m3) and its slope (J/m3/K), convex also above the melting point.

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
    tuple of float
        Enthalpy and slope.
    """
    temperature, melting = w.temperature[layer], w.melting[layer]
    below = min(temperature, melting)
    if layer < first:
        enthalpy, capacity = snow_enthalpy(below, p), p.snow_density * p.heat_ice
    else:
        enthalpy = ice_enthalpy(below, melting, p)
        capacity = p.ice_density * p.heat_ice
        if melting < 0.0:
            capacity -= p.ice_density * p.fusion * melting / below**2
    if temperature > melting:
        capacity *= STEEP
        enthalpy += capacity * (temperature - melting)
    return enthalpy, capacity
