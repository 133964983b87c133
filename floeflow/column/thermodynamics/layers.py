# SPDX-License-Identifier: GPL-2.0-or-later
"""Equal layers again after growth and melt, conserving energy; flooding of heavy snow."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from floeflow.column.physics import TINY, jit
from floeflow.column.thermodynamics.mush import brine_density, brine_enthalpy, brine_salinity

if TYPE_CHECKING:
    from floeflow.column.physics import Physics
    from floeflow.column.thermodynamics.profile import Profile


@jit
def even_out(w: Profile, begin: int, end: int, salty: bool) -> float:
    """Make layers begin to end - 1 equally thick; returns their total thickness (m).

    A new layer takes the energy, and where ``salty`` the salt, of what lies within its bounds
    (theory, eq. 19).

    Parameters
    ----------
    w : Profile
        Thickness, enthalpy and where ``salty`` salinity of the layers are set.
    begin : int
        First layer, and the one after the last.
    end : int
        First layer, and the one after the last.
    salty : bool
        Mush, whose salinity moves with it.

    Returns
    -------
    float
        m.
    """
    total = 0.0
    w.edges[begin] = 0.0
    for k in range(begin, end):
        total += w.thickness[k]
        w.edges[k + 1] = total
    share(w.enthalpy, w, begin, end, total)
    if salty:
        share(w.salt, w, begin, end, total)
    for k in range(begin, end):
        w.thickness[k] = total / (end - begin)
    return total


@jit
def share(values: np.ndarray, w: Profile, begin: int, end: int, total: float) -> None:
    """Average a quantity per volume over equal parts of the layers between ``w.edges``.

    Parameters
    ----------
    values : ndarray
        J/m3 or 1e-3, (z,); changed.
    w : Profile
        Its ``edges`` are the depths of the old layers (m); its ``solution`` is overwritten.
    begin : int
        First layer, and the one after the last.
    end : int
        First layer, and the one after the last.
    total : float
        Thickness of these layers (m).
    """
    if total <= 0.0:
        values[begin:end] = 0.0
        return
    for k in range(begin, end):
        # The solution of the temperatures is done with: its array carries the old values.
        w.solution[k] = values[k]
    thickness = total / (end - begin)
    old = begin
    for k in range(begin, end):
        low = (k - begin) * thickness
        high = total if k == end - 1 else low + thickness
        amount = 0.0
        while True:
            overlap = min(w.edges[old + 1], high) - max(w.edges[old], low)
            amount += max(overlap, 0.0) * w.solution[old]
            if w.edges[old + 1] >= high or old == end - 1:
                break
            old += 1
        values[k] = amount / thickness


@jit
def flood(w: Profile, first: int, ice: float, snow: float, p: Physics) -> float:
    """Turn snow below the water line into ice of the top layer; returns the ice gained (m).

    Archimedes' balance of Leppaeranta (1983); theory, eq. 18. The mass of the snow becomes ice,
    its salt is not counted.

    Parameters
    ----------
    w : Profile
        Thickness and enthalpy of snow and of the uppermost ice layer are changed.
    first : int
        Number of snow layers, which is the row of the uppermost ice layer.
    ice : float
        Thickness of the ice and depth of the snow (m).
    snow : float
        Thickness of the ice and depth of the snow (m).
    p : Physics
        Constants.

    Returns
    -------
    float
        m of ice.
    """
    deep = snow - ice * (p.water_density - p.ice_density) / p.snow_density
    if not (deep > TINY and snow > TINY):
        return 0.0
    drowned = min(deep * p.ice_density / p.water_density, snow)
    gain = drowned * p.snow_density / p.ice_density
    if gain <= TINY:
        return 0.0
    energy = 0.0
    for k in range(first - 1, -1, -1):
        taken = min(drowned, w.thickness[k])
        w.thickness[k] -= taken
        drowned = max(drowned - taken, 0.0)
        energy += taken * w.enthalpy[k]
    total = w.thickness[first] + gain
    w.enthalpy[first] = (w.thickness[first] * w.enthalpy[first] + energy) / total
    w.thickness[first] = total
    return gain


@jit
def flood_mush(
    w: Profile, first: int, bottom: float, sea_salinity: float, p: Physics
) -> tuple[float, ...]:
    """Fill snow below the water line with sea water; ice gained (m), energy (J/m2), salt (1e-3 m).

    Turner, Hunke and Bitz (2013); theory of the mushy column, eq. 15. The pores of the snow take
    sea water with its energy and salt, and the flooded snow becomes mush on top of the ice.

    Parameters
    ----------
    w : Profile
        Its layers; flooded snow becomes mush.
    first : int
        Number of snow layers, which is the row of the uppermost ice layer.
    bottom : float
        Temperature of the sea (degC).
    sea_salinity : float
        1e-3.
    p : Physics
        Constants.

    Returns
    -------
    tuple of float
        Ice gained (m), energy (J/m2) and salt (1e-3 m) taken from the sea.
    """
    snow = weight = ice = 0.0
    for k in range(first):
        snow += w.thickness[k]
    sea = brine_density(sea_salinity)
    if snow <= p.least_snow:
        return 0.0, 0.0, 0.0
    for k in range(first, w.thickness.size):
        brine = brine_density(brine_salinity(w.temperature[k]))
        dense = w.liquid[k] * brine + (1.0 - w.liquid[k]) * p.ice_density
        weight += min(dense, sea) * w.thickness[k]
        ice += w.thickness[k]
    sunk = weight + snow * p.snow_density - ice * sea
    if sunk <= 0.0:
        return 0.0, 0.0, 0.0
    pores = 1.0 - p.snow_density / p.ice_density
    flooded = pores * sea + (1.0 - pores) * p.ice_density
    gain = min(sunk / (sea - flooded + p.snow_density), snow)
    energy, left = 0.0, gain
    for k in range(first - 1, -1, -1):
        taken = min(left, w.thickness[k])
        w.thickness[k] -= taken
        left -= taken
        energy += taken * w.enthalpy[k]
    water = gain * pores * brine_enthalpy(bottom, p)
    layers = w.thickness.size - first
    lay_on(w.enthalpy, w, first, gain, (energy + water) / gain)
    lay_on(w.salt, w, first, gain, pores * sea_salinity)
    for k in range(first, w.thickness.size):
        w.thickness[k] = (ice + gain) / layers
    return gain, water, gain * pores * sea_salinity


@jit
def lay_on(values: np.ndarray, w: Profile, first: int, gain: float, new: float) -> None:
    """Put ice of thickness gain (m) and a value on top of equal ice layers; equal layers again.

    Parameters
    ----------
    values : ndarray
        J/m3 or 1e-3, (z,); those of ice are changed.
    w : Profile
        Its ice layers are equally thick, before the gain; its ``solution`` is overwritten.
    first : int
        Number of snow layers, which is the row of the uppermost ice layer.
    gain : float
        Thickness that is added (m).
    new : float
        Value of what is added.
    """
    z = w.thickness.size
    old = w.thickness[first]
    thick = old + gain / (z - first)
    for k in range(first, z):
        w.solution[k] = values[k]
    for k in range(first, z):
        low, high = (k - first) * thick, (k - first + 1) * thick
        amount = max(min(gain, high) - low, 0.0) * new
        for j in range(first, z):
            begin = gain + (j - first) * old
            amount += max(min(begin + old, high) - max(begin, low), 0.0) * w.solution[j]
        values[k] = amount / thick
