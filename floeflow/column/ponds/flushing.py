# SPDX-License-Identifier: GPL-2.0-or-later
"""Flushing: how fast the water of ponds sinks through mush.

Turner, Hunke and Bitz (2013); numbers of equations are those of docs/theory/column_ponds.md.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from floeflow.column.physics import TINY, jit
from floeflow.column.thermodynamics.drainage import NO_FLOW, permeability
from floeflow.column.thermodynamics.mush import brine_density, brine_salinity

if TYPE_CHECKING:
    from floeflow.column.physics import Physics
    from floeflow.column.thermodynamics.profile import Profile

FRESH = 1000.0  # density of pond water (kg/m3)
LARGEST_SHARE = 0.005  # of the brine of a layer that is washed out at most in `flush_time`
USUAL_LAYERS = 7  # for which that share was chosen


@jit
def flushing(
    w: Profile,
    first: int,
    ice: float,
    snow: float,
    depth: float,
    area: float,
    dt: float,
    p: Physics,
) -> float:
    """Downward Darcy speed of brine and pond water (m/s), not negative (eq. 6).

    Parameters
    ----------
    w : Profile
        Temperatures and liquid fractions at the step's start.
    first : int
        Number of snow layers.
    ice, snow : float
        Thickness (m).
    depth : float
        Of ponds (m).
    area : float
        Share of the ice under ponds.
    dt : float
        s.
    p : Physics
        Constants.

    Returns
    -------
    float
        m/s; 0 without ponds, and bounded by a share of the brine that a layer holds.
    """
    if depth * area <= 0.0:
        return 0.0
    resistance, mass, least = 0.0, 0.0, 1.0
    for k in range(first, w.thickness.size):
        liquid = w.liquid[k]
        least = min(least, liquid)
        brine = brine_density(brine_salinity(w.temperature[k]))
        mass += (liquid * brine + (1.0 - liquid) * p.ice_density) * w.thickness[k]
        resistance += 1.0 / (permeability(liquid) + NO_FLOW)
    layers = w.thickness.size - first
    floats = (mass + depth * area * FRESH + snow * p.snow_density) / p.water_density
    head = max(ice + depth - floats, 0.0)
    speed = layers / resistance * p.water_density * p.gravity * head / (ice * p.viscosity)
    speed = min(speed, depth * area / dt)
    if speed <= TINY:
        return 0.0
    time, parts = dt, layers
    if p.flush_time > 0.0:
        time, parts = p.flush_time, USUAL_LAYERS
    return min(speed, LARGEST_SHARE * least * ice / parts / time)
