# SPDX-License-Identifier: GPL-2.0-or-later
"""Leads without a mixed layer: water that stays at its freezing point.

What the air and the deep give to open water melts the sides of the ice at once, what they take
makes new ice at once (Hibler 1979). The ocean is a reservoir: it gives what is missing and takes
what is left over.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from floeflow.column.physics import jit
from floeflow.column.records import category_energy
from floeflow.column.thermodynamics.boundary_layer import sea_balance

if TYPE_CHECKING:
    from floeflow.column.physics import Physics
    from floeflow.column.records import Column
    from floeflow.column.thermodynamics.boundary_layer import Air


@jit
def lead_balance(
    c: Column, freezing: float, light: float, air: Air, deep: float, dt: float, p: Physics
) -> tuple[float, ...]:
    """Heat balance of open water at its freezing point.

    Parameters
    ----------
    c : Column
        After growth and melt of its categories.
    freezing : float
        Freezing point (degC).
    light : float
        Short-wave radiation that open water absorbs (W/m2 of open water).
    air : Air
        Above it.
    deep : float
        Heat from below (W/m2).
    dt : float
        s.
    p : Physics
        Constants.

    Returns
    -------
    tuple of float
        Energy of which ice is to be made (J/m2), share of the ice that melts from its sides, heat
        from the air with the light (J/m2), latent part of it (J/m2).
    """
    total = stored = 0.0
    for n in range(c.area.size):
        total += c.area[n]
        stored -= category_energy(c, n)
    water = max(1.0 - total, 0.0)
    net, latent = sea_balance(freezing, light, air, p)
    heat = (net + deep) * water * dt
    freeze = -heat if p.frazil and heat < 0.0 else 0.0
    side = 0.0
    if heat > 0.0 and p.lateral_rate > 0.0 and stored > 0.0:
        side = min(heat / stored, 1.0)
    return freeze, side, net * water * dt, latent * water * dt
