# SPDX-License-Identifier: GPL-2.0-or-later
"""The layers of one category while it is worked on: snow first, then ice, top to bottom.

A record of scratch arrays, filled from the state and written back, so that the compiled functions
allocate nothing in their loops.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floeflow.column.physics import jit, jit_making
from floeflow.column.thermodynamics.enthalpy import (
    ice_conductivity,
    ice_temperature,
    snow_enthalpy,
    snow_temperature,
)
from floeflow.column.thermodynamics.mush import mush_conductivity, mush_temperature

if TYPE_CHECKING:
    from floeflow.column.physics import Physics

Array = NDArray[np.float64]


class Profile(NamedTuple):
    """Arrays over layers (z,), interfaces (z + 1,) or matrix rows (z + 1,); row 0 is the surface.

    Parameters
    ----------
    salt, melting : ndarray
        Salinity (1e-3) and melting temperature (degC) of layers; zero in snow, (z,).
    thickness, enthalpy, temperature : ndarray
        m, J/m3, degC, (z,).
    first_enthalpy, first_temperature : ndarray
        At the step's start, (z,).
    source : ndarray
        Light absorbed in layers (W/m2), (z,).
    conductance : ndarray
        Of interfaces between layer middles (W/m2/K), surface first, bottom last, (z + 1,).
    lower, diagonal, upper, right, solution : ndarray
        The tridiagonal system, (z + 1,).
    edges : ndarray
        Scratch, (z + 1,).
    water : ndarray
        Enthalpy (J/m3) of what is left when the ice of a layer melts; zero but in mush, (z,).
    liquid, flow, drain : ndarray
        Of mush: share of brine, upward exchange (m/s), slow drainage (1e-3/s), (z,).
    """

    salt: Array
    melting: Array
    thickness: Array
    enthalpy: Array
    temperature: Array
    first_enthalpy: Array
    first_temperature: Array
    source: Array
    conductance: Array
    lower: Array
    diagonal: Array
    upper: Array
    right: Array
    solution: Array
    edges: Array
    water: Array
    liquid: Array
    flow: Array
    drain: Array


@jit_making
def new_profile(salinity: np.ndarray, snow_layers: int, constants: np.ndarray) -> Profile:
    """Scratch for ice of a salinity profile (1e-3, top first) under some snow layers.

    Parameters
    ----------
    salinity : ndarray
        Of the ice's layers, top first (1e-3), (layers,).
    snow_layers : int
        Number of snow layers.
    constants : ndarray
        Record of `Physics`, (1,).

    Returns
    -------
    Profile
        Salinities and melting points set, the rest zeros.
    """
    z = salinity.size + snow_layers
    salt = np.zeros(z)
    salt[snow_layers:] = salinity
    return Profile(
        salt,
        -constants[0].melting_slope * salt,
        np.zeros(z),
        np.zeros(z),
        np.zeros(z),
        np.zeros(z),
        np.zeros(z),
        np.zeros(z),
        np.zeros(z + 1),
        np.zeros(z + 1),
        np.zeros(z + 1),
        np.zeros(z + 1),
        np.zeros(z + 1),
        np.zeros(z + 1),
        np.zeros(z + 1),
        np.zeros(z),
        np.zeros(z),
        np.zeros(z),
        np.zeros(z),
    )


@jit
def fill(
    w: Profile,
    ice: float,
    snow: float,
    ice_enthalpies: np.ndarray,
    snow_enthalpies: np.ndarray,
    salinities: np.ndarray,
    p: Physics,
) -> None:
    """Take thicknesses (m), enthalpies (J/m3) and of mush salinities into the profile.

    Parameters
    ----------
    w : Profile
        Thickness, enthalpy and temperature are set; of mush salinity too.
    ice : float
        Thickness of the ice and depth of the snow (m).
    snow : float
        Thickness of the ice and depth of the snow (m).
    ice_enthalpies : ndarray
        J/m3, (layers,).
    snow_enthalpies : ndarray
        J/m3, (layers,).
    salinities : ndarray
        Of mush (1e-3), (layers,).
    p : Physics
        Constants.
    """
    first = snow_enthalpies.size
    for k in range(w.thickness.size):
        if k < first:
            w.thickness[k] = snow / first
            w.enthalpy[k] = snow_enthalpies[k] if snow > 0.0 else snow_enthalpy(0.0, p)
            w.temperature[k] = snow_temperature(w.enthalpy[k], p)
        else:
            w.thickness[k] = ice / ice_enthalpies.size
            w.enthalpy[k] = ice_enthalpies[k - first]
            if p.mushy:
                w.salt[k] = salinities[k - first]
                w.temperature[k] = mush_temperature(w.enthalpy[k], w.salt[k], p)
            else:
                w.temperature[k] = ice_temperature(w.enthalpy[k], w.melting[k], p)
        w.first_enthalpy[k] = w.enthalpy[k]
        w.first_temperature[k] = w.temperature[k]


@jit
def conductances(w: Profile, top: int, first: int, p: Physics) -> None:
    """Conductance of the interfaces from layer ``top`` down, at the step's first temperatures.

    Two half layers in series (Bitz and Lipscomb 1999; theory, eq. 7); half a layer at either end.
    Layers above ``top`` are snow too thin to count.

    Parameters
    ----------
    w : Profile
        Its ``conductance`` (W/m2/K) is set.
    top : int
        Uppermost layer that counts.
    first : int
        Number of snow layers, which is the row of the uppermost ice layer.
    p : Physics
        Constants.
    """
    z = w.thickness.size
    w.conductance[:top] = 0.0
    above = 0.0
    for k in range(top, z):
        if k < first:
            conductivity = p.snow_conductivity
        elif p.mushy:
            conductivity = mush_conductivity(w.first_temperature[k], w.salt[k], p)
        else:
            conductivity = ice_conductivity(w.first_temperature[k], w.salt[k], p)
        half = 0.5 * w.thickness[k] / conductivity
        w.conductance[k] = 1.0 / (above + half)
        above = half
    w.conductance[z] = 1.0 / above
