# SPDX-License-Identifier: GPL-2.0-or-later
"""Lateral melt, and what keeps the categories sound: area, bounds, no traces of ice."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from floeflow.column.physics import TINY, jit
from floeflow.column.records import (
    CLEARED_ICE,
    MELT_LATERAL,
    MELT_SNOW,
    SALT_TO_ICE,
    category_energy,
    category_salt,
    level_amounts,
    level_shares,
)

if TYPE_CHECKING:
    from floeflow.column.records import Column, Scratch


@jit
def melt_sides(c: Column, side: float, sums: np.ndarray) -> float:
    """Melt a share of every category; energy taken from the sea (J/m2).

    Thickness stays (Steele 1992; theory, eq. 21).

    Parameters
    ----------
    c : Column
        Advanced.
    side : float
        Share of the ice that melts, 0 to 1.
    sums : ndarray
        Budget terms, added to, (len(SUMS),).

    Returns
    -------
    float
        Not negative.
    """
    energy = 0.0
    if side <= 0.0:
        return energy
    for n in range(c.area.size):
        energy -= side * category_energy(c, n)
        sums[MELT_LATERAL] += side * c.ice[n]
        sums[SALT_TO_ICE] -= side * category_salt(c, n)
        sums[MELT_SNOW] += side * c.snow[n]
        c.area[n] *= 1.0 - side
        c.ice[n] *= 1.0 - side
        c.snow[n] *= 1.0 - side
    return energy


@jit
def open_area(c: Column, before: float, least: float) -> None:
    """Let the only category lose area as it melts (Hunke et al. 2015; theory, eq. 24).

    Half of the volume lost thins the ice and half opens water; ice thinner than ``least`` (m) gives
    up area until it is as thick.

    Parameters
    ----------
    c : Column
        Advanced.
    before : float
        Thickness at the start of the step (m).
    least : float
        Least thickness of the ice (m).
    """
    if c.area[0] <= 0.0:
        return
    if c.ice[0] <= least * c.area[0]:
        c.area[0] = c.ice[0] / least
    if c.area[0] > 0.0 and c.ice[0] < before * c.area[0]:
        c.area[0] = 2.0 * c.ice[0] / (c.ice[0] / c.area[0] + before)


@jit
def rebin(c: Column, s: Scratch, bounds: np.ndarray) -> None:
    """Move categories whose ice has left their bounds to the neighbour, whole.

    Parameters
    ----------
    c : Column
        Advanced.
    s : Scratch
        Work arrays.
    bounds : ndarray
        Of the categories (m), (ncat + 1,).
    """
    last = c.area.size
    if c.area[0] > TINY and bounds[0] > 0.0 and c.ice[0] <= bounds[0] * c.area[0]:
        c.area[0] = c.ice[0] / bounds[0]
    for n in range(last - 1):
        if c.area[n] > TINY and c.ice[n] > bounds[n + 1] * c.area[n]:
            merge(c, s, n, n + 1)
    for n in range(last - 1, 0, -1):
        if c.area[n] > TINY and c.ice[n] <= bounds[n] * c.area[n]:
            merge(c, s, n, n - 1)


@jit
def merge(c: Column, s: Scratch, n: int, into: int) -> None:
    """Put all of category n into another.

    Parameters
    ----------
    c : Column
        Advanced.
    s : Scratch
        Work arrays.
    n : int
        Category.
    into : int
        Category that takes it.
    """
    area, ice, snow = c.area[n] + c.area[into], c.ice[n] + c.ice[into], c.snow[n] + c.snow[into]
    c.surface[into] = (c.surface[n] * c.area[n] + c.surface[into] * c.area[into]) / area
    for k in range(c.ice_enthalpy.shape[1]):
        energy = c.ice_enthalpy[n, k] * c.ice[n] + c.ice_enthalpy[into, k] * c.ice[into]
        c.ice_enthalpy[into, k] = energy / ice
        salt = c.salinity[n, k] * c.ice[n] + c.salinity[into, k] * c.ice[into]
        c.salinity[into, k] = salt / ice
    level_amounts(c, n, s.level[n])
    level_amounts(c, into, s.level[into])
    for k in range(s.level.shape[1]):
        s.level[into, k] += s.level[n, k]
    if snow > 0.0:
        for k in range(c.snow_enthalpy.shape[1]):
            energy = c.snow_enthalpy[n, k] * c.snow[n] + c.snow_enthalpy[into, k] * c.snow[into]
            c.snow_enthalpy[into, k] = energy / snow
    c.area[into], c.ice[into], c.snow[into] = area, ice, snow
    level_shares(c, into, s.level[into])
    empty(c, n, c.surface[into])


@jit
def empty(c: Column, n: int, temperature: float) -> None:
    """Leave a category without ice.

    Parameters
    ----------
    c : Column
        Advanced.
    n : int
        Category.
    temperature : float
        Of the surface from now on (degC).
    """
    c.area[n] = c.ice[n] = c.snow[n] = 0.0
    c.surface[n] = temperature
    c.ice_enthalpy[n, :] = 0.0
    c.salinity[n, :] = 0.0
    c.snow_enthalpy[n, :] = 0.0
    c.level[n, :] = 0.0


@jit
def clear(c: Column, freezing: float, sums: np.ndarray) -> float:
    """Melt traces of ice in the sea, keep the area at most 1; energy taken from the sea (J/m2).

    What area is above 1 by round-off is given up by all, volumes stay.

    Parameters
    ----------
    c : Column
        Advanced.
    freezing : float
        Freezing point of the sea (degC).
    sums : ndarray
        Budget terms, added to, (len(SUMS),).

    Returns
    -------
    float
        Not negative.
    """
    total = energy = 0.0
    for n in range(c.area.size):
        total += c.area[n]
    for n in range(c.area.size):
        if c.area[n] > TINY and c.ice[n] > 0.0 and total > TINY:
            if total > 1.0:
                c.area[n] /= total
            continue
        if c.ice[n] != 0.0 or c.snow[n] != 0.0:
            energy -= category_energy(c, n)
            sums[CLEARED_ICE] += c.ice[n]
            sums[SALT_TO_ICE] -= category_salt(c, n)
            sums[MELT_SNOW] += c.snow[n]
        empty(c, n, freezing)
    return energy
