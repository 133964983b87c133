# SPDX-License-Identifier: GPL-2.0-or-later
"""Light in the manner of CCSM3: albedo in two bands, absorption in bare ice by Beer's law.

Briegleb et al. (2004). Direct and diffuse light are treated alike.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from floeflow.column.physics import TINY, jit

if TYPE_CHECKING:
    from floeflow.column.physics import Physics


@jit
def albedos(thickness: float, snow: float, temperature: float, p: Physics) -> tuple[float, ...]:
    """Albedo of bare ice and of snow: ice visible, ice infrared, snow visible, snow infrared.

    Briegleb et al. (2004); theory, eq. 11.

    Parameters
    ----------
    thickness : float
        Thickness of the ice, and depth of the snow (m).
    snow : float
        Thickness of the ice, and depth of the snow (m).
    temperature : float
        Of the surface (degC).
    p : Physics
        Constants.

    Returns
    -------
    tuple of float
        Four albedos; those of snow are the ocean's where there is no snow.
    """
    thick = min(math.atan(4.0 * thickness) / math.atan(4.0 * p.albedo_thickness), 1.0)
    warm = 1.0 - min(max(-temperature / p.albedo_ramp, 0.0), 1.0)
    water = p.albedo_ocean * (1.0 - thick) - p.albedo_ice_warming * warm
    ice_visible = max(p.albedo_ice_visible * thick + water, p.albedo_ocean)
    ice_infrared = max(p.albedo_ice_infrared * thick + water, p.albedo_ocean)
    if snow <= TINY:
        return ice_visible, ice_infrared, p.albedo_ocean, p.albedo_ocean
    snow_visible = p.albedo_snow_visible - p.albedo_snow_visible_warming * warm
    snow_infrared = p.albedo_snow_infrared - p.albedo_snow_infrared_warming * warm
    return ice_visible, ice_infrared, snow_visible, snow_infrared


@jit
def absorb(
    thickness: float,
    snow: float,
    temperature: float,
    visible: float,
    infrared: float,
    source: np.ndarray,
    first: int,
    p: Physics,
) -> tuple[float, ...]:
    """Light absorbed at the surface and passed to the ocean (W/m2); fills ``source``.

    Snow and the near infrared let nothing through; of the visible light that bare ice absorbs a
    share enters it and fades by Beer's law (Briegleb et al. 2004; theory, eq. 12).

    Parameters
    ----------
    thickness, snow : float
        m.
    temperature : float
        Of the surface at the step's start (degC).
    visible, infrared : float
        Downward (W/m2).
    source : ndarray
        Absorbed in layers (W/m2), written; snow layers first.
    first : int
        Number of snow layers.
    p : Physics
        Constants.

    Returns
    -------
    surface, through : float
        Absorbed at the surface, and passed to the ocean, W/m2 of ice.
    """
    source[:] = 0.0
    if visible + infrared <= 0.0:
        return 0.0, 0.0
    ice_visible, ice_infrared, snow_visible, snow_infrared = albedos(
        thickness, snow, temperature, p
    )
    covered = snow / (snow + p.snow_patchiness) if snow > TINY else 0.0
    bare = 1.0 - covered
    into_ice = visible * (1.0 - ice_visible) * bare
    absorbed = into_ice + visible * (1.0 - snow_visible) * covered
    absorbed += infrared * ((1.0 - ice_infrared) * bare + (1.0 - snow_infrared) * covered)
    enters = into_ice * p.penetrating
    layers = source.size - first
    fade = math.exp(-p.extinction * thickness / layers)
    here = enters
    for k in range(first, source.size):
        source[k] = here * (1.0 - fade)
        here *= fade
    return absorbed - enters, here
