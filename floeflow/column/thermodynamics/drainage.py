# SPDX-License-Identifier: GPL-2.0-or-later
"""Gravity drainage: how fast brine leaves the ice, in channels and slowly.

Turner, Hunke and Bitz (2013); Rees Jones and Worster (2013) for the flow in channels; permeability
of Golden et al. (2007).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from floeflow.column.physics import TINY, jit
from floeflow.column.thermodynamics.mush import brine_density, brine_salinity

if TYPE_CHECKING:
    from floeflow.column.physics import Physics
    from floeflow.column.thermodynamics.profile import Profile

LARGEST_SHARE = 0.2  # of a layer that may be exchanged in a step
LEAST_SALINITY = 0.1  # 1e-3, below which a step must not come
SAFETY = 10.0
NO_FLOW = 1e-30


@jit
def permeability(liquid: float) -> float:
    """Permeability (m2) of mush (eq. 6).

    Parameters
    ----------
    liquid : float
        Liquid fraction of the mush (1).

    Returns
    -------
    float
        m2; 0 below a liquid fraction of 0.05, where pores are not connected.
    """
    return 3e-8 * max(liquid - 0.05, 0.0) ** 3


@jit
def drain(
    w: Profile,
    first: int,
    ice: float,
    surface: float,
    bottom: float,
    sea_salinity: float,
    dt: float,
    p: Physics,
) -> None:
    """Set the upward exchange ``w.flow`` (m/s) and the slow drainage ``w.drain`` (1e-3/s).

    Theory of the mushy column, eqs. 7 to 9. From the bottom up: what the density of brine drives
    through the mush below a layer and back down a channel, where the Rayleigh number passes its
    critical value. Both are cut so that a step takes no more than a tenth of the salt above the
    least salinity.

    Parameters
    ----------
    w : Profile
        Temperatures, salinities and liquid fractions at the step's start; flow and drain written.
    first : int
        Number of snow layers.
    ice : float
        Thickness of the ice (m).
    surface, bottom : float
        degC.
    sea_salinity : float
        1e-3.
    dt : float
        s.
    p : Physics
        Constants.
    """
    z = w.thickness.size
    layers = z - first
    layer = ice / layers
    least, resistance, weight = 1e30, 0.0, 0.0
    sea = brine_density(sea_salinity)
    channel = math.pi * p.channel_radius**4 / (8.0 * p.viscosity)
    below = sea_salinity
    for k in range(z - 1, first - 1, -1):
        salinity = brine_salinity(w.temperature[k])
        above = salinity
        if k > first:
            above = brine_salinity(w.temperature[k - 1])
        dense = brine_density(salinity)
        open_space = permeability(w.liquid[k])
        least = min(least, open_space)
        resistance += 1.0 / max(open_space, NO_FLOW)
        weight += dense
        count = z - k
        height = count * layer
        to_bottom = ice - (k - first + 0.5) * layer
        rayleigh = max(dense - sea, 0.0) * to_bottom * least
        rayleigh *= p.gravity / (p.viscosity * p.diffusivity)
        width = (2.0 * p.channel_aspect * height) ** 2
        mush = width * count / (p.viscosity * resistance)
        pull = p.gravity * weight / count
        pipe = p.gravity * 0.5 * (dense + brine_density(above))
        flow = mush / width * ((channel * pipe + mush * pull) / (mush + channel) - pull)
        flow = max(flow, NO_FLOW) * max(rayleigh - p.critical_rayleigh, 0.0) / (rayleigh + TINY)
        flow = min(flow, LARGEST_SHARE * layer / dt)
        slow = p.slow_drainage * max(w.salt[k] - p.slow_liquid * salinity, 0.0)
        slow *= max(bottom - surface, 0.0) / (ice + 0.001)
        slow = max(slow, -0.5 * w.salt[k] / dt)
        expected = (flow * (below - salinity) / layer + slow) * dt * SAFETY
        share = 1.0
        if abs(expected) >= TINY:
            share = (LEAST_SALINITY - w.salt[k]) / expected
            share = 1.0 if share < 0.0 or share > 1.0 else share
        w.flow[k], w.drain[k] = flow * share, slow * share
        below = salinity
