# SPDX-License-Identifier: GPL-2.0-or-later
"""Light in a category by the scheme asked for, and what no layer can take."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from floeflow.column import records as r
from floeflow.column.physics import TINY, jit
from floeflow.column.shortwave.ccsm3 import absorb
from floeflow.column.shortwave.delta_eddington import absorb_scattered
from floeflow.column.thermodynamics.mush import liquidus

if TYPE_CHECKING:
    from floeflow.column.physics import Physics
    from floeflow.column.records import Column, Thickness
    from floeflow.column.shortwave.scattering import Rays
    from floeflow.column.thermodynamics.profile import Profile

NEAR_MELTING = 0.02  # K below melting from which on a layer takes no light
LARGEST_SHARE = 0.9  # of the heat that brings a layer to melting


@jit
def shed_light(
    c: Column,
    n: int,
    thickness: Thickness,
    w: Profile,
    rays: Rays,
    f: np.ndarray,
    dt: float,
    p: Physics,
) -> tuple[float, ...]:
    """Light absorbed at the surface and passed to the ocean (W/m2); fills ``w.source``.

    Arguments as `delta_eddington.absorb_scattered`, after `profile.fill`.

    Parameters
    ----------
    c : Column
        Categories of the element.
    n : int
        Category.
    thickness : Thickness
        Of ice and snow (m).
    w : Profile
        Filled by `profile.fill`; its ``source`` is set.
    rays : Rays
        Work arrays of the light.
    f : ndarray
        Forcing of the step, (len(FORCING),).
    dt : float
        Time step (s).
    p : Physics
        Constants.

    Returns
    -------
    tuple of float
        W/m2 of the ice's area.
    """
    first = c.snow_enthalpy.shape[1]
    if p.delta_eddington:
        light, through = absorb_scattered(c, n, thickness, w, rays, f, dt, p)
    else:
        ice, snow = thickness
        light, through = absorb(
            ice, snow, c.surface[n], f[r.VISIBLE], f[r.INFRARED], w.source, first, p
        )
    if first > 0 and thickness.snow <= p.least_snow:
        # Snow that does not conduct does not warm.
        for k in range(first):
            light += w.source[k]
            w.source[k] = 0.0
    if p.redistribute_light:
        light += lift(w, first, dt, p)
    return light, through


@jit
def lift(w: Profile, first: int, dt: float, p: Physics) -> float:
    """Take light from layers that it would melt; what the surface gets instead (W/m2).

    Hunke et al. (2015), section on thermodynamics; docs/theory/column_light.md, eq. 14.

    Parameters
    ----------
    w : Profile
        Layers; light is taken from ``source``.
    first : int
        Number of snow layers, which is the row of the uppermost ice layer.
    dt : float
        Time step (s).
    p : Physics
        Constants.

    Returns
    -------
    float
        W/m2.
    """
    lifted = 0.0
    for k in range(0 if not p.mushy else first, w.source.size):
        temperature, most = w.temperature[k], 0.0
        if k < first:
            below, heat = -temperature, p.snow_density * p.heat_ice
        else:
            melting = liquidus(w.salt[k]) if p.mushy else w.melting[k]
            below = melting - temperature
            heat = p.ice_density * p.heat_ice
            if temperature < 0.0:
                heat -= p.ice_density * p.fusion * melting / temperature**2
        if below >= NEAR_MELTING:
            most = LARGEST_SHARE * below * heat * w.thickness[k] / dt
        stays = min(w.source[k], most)
        stays = stays if stays >= TINY else 0.0
        lifted += w.source[k] - stays
        w.source[k] = stays
    return lifted
