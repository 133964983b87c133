# SPDX-License-Identifier: GPL-2.0-or-later
"""Frazil: ice that the freezing potential of the sea makes in open water."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from floeflow.column.physics import TINY, jit
from floeflow.column.records import (
    LEVEL_AREA,
    LEVEL_VOLUME,
    NEW_ICE,
    NEW_ICE_ENERGY,
    SALT_TO_ICE,
    level_amounts,
    level_shares,
)
from floeflow.column.thermodynamics.mush import liquid_fraction, liquidus, mush_enthalpy

if TYPE_CHECKING:
    from floeflow.column.physics import Physics
    from floeflow.column.records import Column, Scratch, Water
    from floeflow.column.thermodynamics.profile import Profile


@jit
def frazil(sea_salinity: float, p: Physics) -> tuple[float, ...]:
    """Enthalpy (J/m3) and salinity (1e-3) of new ice in open water.

    Fresh ice at its melting point, whose salinity is that of the fixed profile (here -1); mush of
    three quarters brine (Turner et al. 2013; theory of the mushy column, eq. 14).

    Parameters
    ----------
    sea_salinity : float
        1e-3.
    p : Physics
        Constants.

    Returns
    -------
    tuple of float
        Enthalpy and salinity.
    """
    if not p.mushy:
        return -p.ice_density * p.fusion, -1.0
    salinity = sea_salinity - p.frazil_freshening
    if sea_salinity <= 2.0 * p.frazil_freshening:
        salinity = sea_salinity**2 / (4.0 * p.frazil_freshening)
    temperature = min(liquidus(salinity / p.frazil_liquid), p.warmest_frazil)
    return mush_enthalpy(temperature, liquid_fraction(temperature, salinity), p), salinity


@jit
def freeze_leads(
    c: Column,
    s: Scratch,
    energy: float,
    water: Water,
    w: Profile,
    bounds: np.ndarray,
    sums: np.ndarray,
    p: Physics,
) -> None:
    """Make ice of the energy (J/m2) that the sea lacks (Hunke et al. 2015; theory, eq. 23).

    It gathers in open water, at least ``new_ice_thickness`` thick, in the thinnest category; what
    would fill that beyond nine tenths of its range, and all where there is no open water, thickens
    all categories alike.

    Parameters
    ----------
    c : Column
        Advanced.
    s : Scratch
        Work arrays.
    energy : float
        To be taken from the sea, not negative (J/m2).
    water : Water
        Freezing point and salinity of the sea.
    w : Profile
        For the fixed profile of salinity.
    bounds : ndarray
        Of categories (m), (ncat + 1,).
    sums : ndarray
        Budget terms, added to.
    p : Physics
        Constants.
    """
    if energy <= 0.0:
        return
    enthalpy, salinity = frazil(water.salinity, p)
    volume = -energy / enthalpy
    sums[NEW_ICE] += volume
    sums[SALT_TO_ICE] += volume * max(salinity, 0.0)
    sums[NEW_ICE_ENERGY] -= energy
    total = 0.0
    for n in range(c.area.size):
        total += c.area[n]
    leads = max(1.0 - total, 0.0)
    area = 0.0
    surplus = volume
    if leads > TINY:
        thickness = max(volume / leads, p.new_ice_thickness)
        area, surplus = min(volume / thickness, leads), 0.0
        if c.area.size > 1 and thickness > 0.9 * bounds[1] and total > TINY:
            area = leads
            surplus = max(volume - 0.9 * bounds[1] * leads, 0.0)
    if surplus > 0.0:
        for n in range(c.area.size):
            part = surplus * c.area[n] / total
            if c.ice[n] > TINY:
                flat = c.level[n, LEVEL_VOLUME] * c.ice[n] + c.level[n, LEVEL_AREA] * part
                c.level[n, LEVEL_VOLUME] = flat / (c.ice[n] + part)
            if p.mushy:
                add_below(c, s, n, part, enthalpy, salinity)
            else:
                thicken(c, n, part, enthalpy, salinity, w)
    if area > 0.0:
        c.surface[0] = (c.surface[0] * c.area[0] + water.freezing * area) / (c.area[0] + area)
        c.surface[0] = min(c.surface[0], 0.0)
        level_amounts(c, 0, s.level[0])
        s.level[0, LEVEL_AREA] += area
        s.level[0, LEVEL_VOLUME] += volume - surplus
        c.area[0] += area
        thicken(c, 0, volume - surplus, enthalpy, salinity, w)
        level_shares(c, 0, s.level[0])


@jit
def thicken(c: Column, n: int, volume: float, enthalpy: float, salinity: float, w: Profile) -> None:
    """Mix new ice into all layers of category n.

    Parameters
    ----------
    c : Column
        Advanced.
    n : int
        Category.
    volume : float
        Of the new ice per area of the element (m).
    enthalpy : float
        Of the new ice (J/m3).
    salinity : float
        Of the new ice (1e-3); negative: that of the fixed profile.
    w : Profile
        With the fixed profile of salinity.
    """
    total = c.ice[n] + volume
    if volume <= 0.0 or total <= 0.0:
        return
    layers = c.ice_enthalpy.shape[1]
    for k in range(layers):
        salt = salinity if salinity >= 0.0 else w.salt[k + w.salt.size - layers]
        c.ice_enthalpy[n, k] = (c.ice_enthalpy[n, k] * c.ice[n] + enthalpy * volume) / total
        c.salinity[n, k] = (c.salinity[n, k] * c.ice[n] + salt * volume) / total
    c.ice[n] = total


@jit
def add_below(
    c: Column, s: Scratch, n: int, volume: float, enthalpy: float, salinity: float
) -> None:
    """Put new ice under category n and make its layers equal again.

    Parameters
    ----------
    c : Column
        Advanced.
    s : Scratch
        Work arrays.
    n : int
        Category.
    volume : float
        Of the new ice per area of the element (m).
    enthalpy : float
        Of the new ice (J/m3; 1e-3).
    salinity : float
        Of the new ice (J/m3; 1e-3).
    """
    if volume <= 0.0 or c.ice[n] <= 0.0:
        return
    before, layers = c.ice[n], c.ice_enthalpy.shape[1]
    for k in range(layers):
        s.ice_energy[n, k], s.salt[n, k] = c.ice_enthalpy[n, k], c.salinity[n, k]
    c.ice[n] += volume
    part = c.ice[n] / layers
    for k in range(layers):
        low, high = k * part, (k + 1) * part
        new = max(high - max(low, before), 0.0)
        energy, salt = new * enthalpy, new * salinity
        for old in range(layers):
            over = min(high, (old + 1) * before / layers) - max(low, old * before / layers)
            energy += max(over, 0.0) * s.ice_energy[n, old]
            salt += max(over, 0.0) * s.salt[n, old]
        c.ice_enthalpy[n, k], c.salinity[n, k] = energy / part, salt / part
