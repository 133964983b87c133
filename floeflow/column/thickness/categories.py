# SPDX-License-Identifier: GPL-2.0-or-later
"""Bounds of thickness categories, and the remapping that growth and melt ask for.

Linear remapping of Lipscomb (2001): growth shifts the bounds of the categories, ice is taken to be
spread linearly between the shifted bounds, and what lies beyond the fixed bounds changes category.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from floeflow.column.physics import TINY, jit
from floeflow.column.records import (
    LEVEL_AREA,
    LEVEL_VOLUME,
    POND_AREA,
    POND_DEPTH,
    POND_LID,
    level_amounts,
    level_shares,
)

if TYPE_CHECKING:
    from floeflow.column.physics import Physics
    from floeflow.column.records import Column, Scratch


def category_bounds(categories: int) -> NDArray[np.float64]:
    """Thickness bounds (m) of categories, (categories + 1,); Lipscomb (2001); theory, eq. 27.

    The last is so high that it bounds nothing. A single category starts at 0.1 m: thinner ice gives
    up area instead.

    Parameters
    ----------
    categories : int
        Their number.

    Returns
    -------
    ndarray
        m, ascending, (categories + 1,).
    """
    if categories == 1:
        return np.array([0.1, 999.9])
    width = 3.0 / categories
    bounds = np.zeros(categories + 1)
    for n in range(1, categories + 1):
        x = (n - 1) / categories
        bounds[n] = bounds[n - 1] + width + 15.0 * width * (1.0 + np.tanh(3.0 * (x - 1.0)))
    bounds[categories] = 999.9
    return bounds


@jit
def fit_line(area: float, thickness: float, low: float, high: float) -> tuple[float, ...]:
    """Line g0 + g1 (h - left) that holds area and mean thickness, and the range where it does.

    Lipscomb (2001); theory, eq. 29. Outside the middle third of its bounds the mean thickness
    allows a line over part of the range only.

    Parameters
    ----------
    area : float
        Area fraction of the category.
    thickness : float
        Mean thickness (m).
    low : float
        Bounds of the category (m).
    high : float
        Bounds of the category (m).

    Returns
    -------
    tuple of float
        g0 (1/m), g1 (1/m2), and the range of the line, left and right (m).
    """
    if area <= TINY or high - low <= TINY:
        return 0.0, 0.0, 0.0, 0.0
    left, right = low, high
    if thickness < (2.0 * low + high) / 3.0:
        right = 3.0 * thickness - 2.0 * low
    elif thickness > (low + 2.0 * high) / 3.0:
        left = 3.0 * thickness - 2.0 * high
    per_width = 1.0 / (right - left)
    scale = 6.0 * area * per_width
    place = (thickness - left) * per_width
    return scale * (2.0 / 3.0 - place), 2.0 * per_width * scale * (place - 0.5), left, right


@jit
def shifted_bounds(c: Column, before: np.ndarray, bounds: np.ndarray, moved: np.ndarray) -> bool:
    """Move the bounds with the ice beside them (theory, eq. 28); false where they would cross.

    Parameters
    ----------
    c : Column
        After growth and melt.
    before : ndarray
        Thickness before (m), zero where there was no ice, (ncat,).
    bounds, moved : ndarray
        Fixed bounds, and shifted ones, written (m), (ncat + 1,).

    Returns
    -------
    bool
        False where ice would leave a neighbouring category behind: `moved` is of no use then.
    """
    last = c.area.size
    moved[0] = bounds[0]
    good = True
    for n in range(1, last):
        thin, thick = growth_of(c, before, n - 1), growth_of(c, before, n)
        if before[n - 1] > TINY and before[n] > TINY:
            slope = (thick - thin) / (before[n] - before[n - 1])
            moved[n] = bounds[n] + thin + slope * (bounds[n] - before[n - 1])
            good = good and before[n] > before[n - 1]
        elif before[n - 1] > TINY:
            moved[n] = bounds[n] + thin
        elif before[n] > TINY:
            moved[n] = bounds[n] + thick
        else:
            moved[n] = bounds[n]
        if c.area[n - 1] > TINY and c.ice[n - 1] / c.area[n - 1] >= moved[n]:
            good = False
        if c.area[n] > TINY and c.ice[n] / c.area[n] <= moved[n]:
            good = False
        good = good and bounds[n - 1] <= moved[n] <= bounds[n + 1]
    moved[last] = bounds[last]
    if c.area[last - 1] > TINY:
        moved[last] = 3.0 * c.ice[last - 1] / c.area[last - 1] - 2.0 * moved[last - 1]
    moved[last] = max(moved[last], bounds[last - 1])
    return good


@jit
def growth_of(c: Column, before: np.ndarray, n: int) -> float:
    """Thickness gained by category n in the step (m).

    Parameters
    ----------
    c : Column
        Categories of the element.
    before : ndarray
        Thickness at the start of the step (m), (ncat,).
    n : int
        Category.

    Returns
    -------
    float
        Negative: melt.
    """
    return c.ice[n] / c.area[n] - before[n] if c.area[n] > TINY else 0.0


@jit
def lose_thin_area(c: Column, before: np.ndarray, bounds: np.ndarray, moved: np.ndarray) -> None:
    """Open the area whose ice is thinner than the melt of the thinnest category (eq. 31).

    The volume stays, on what area is left, which is not made thicker than it was before. With
    growth the lower bound moves instead.

    Parameters
    ----------
    c : Column
        The area of its thinnest category is reduced.
    before : ndarray
        Thickness at the start of the step (m), (ncat,).
    bounds : ndarray
        Of the categories (m), (ncat + 1,).
    moved : ndarray
        Bounds that moved with the ice (m), (ncat + 1,); the lowest is set.
    """
    if c.area[0] <= TINY:
        return
    change = growth_of(c, before, 0)
    if change >= 0.0:
        moved[0] = min(change, bounds[1])
        return
    g0, g1, left, right = fit_line(c.area[0], before[0], moved[0], bounds[1])
    reach = min(min(-change, bounds[1]), right) - left
    if reach > 0.0:
        lost = g1 * 0.5 * reach * reach + g0 * reach
        thickness = c.ice[0] / c.area[0]
        c.area[0] -= min(lost, c.area[0] * (1.0 - thickness / before[0]))


@jit
def transfers(
    c: Column, bounds: np.ndarray, moved: np.ndarray, area: np.ndarray, volume: np.ndarray
) -> None:
    """Area and volume that cross each bound upward (negative: downward); theory, eq. 30.

    Parameters
    ----------
    c : Column
        After growth and melt.
    bounds : ndarray
        Of the categories (m), (ncat + 1,).
    moved : ndarray
        Bounds that moved with the ice (m), (ncat + 1,).
    area : ndarray
        Set: area fraction and volume (m) across the lower bound of each category, (ncat,).
    volume : ndarray
        Set: area fraction and volume (m) across the lower bound of each category, (ncat,).
    """
    for n in range(1, c.area.size):
        area[n] = volume[n] = 0.0
        up = moved[n] > bounds[n]
        donor = n - 1 if up else n
        thickness = c.ice[donor] / c.area[donor] if c.area[donor] > TINY else 0.0
        g0, g1, left, right = fit_line(c.area[donor], thickness, moved[donor], moved[donor + 1])
        begin = max(bounds[n], left) - left if up else 0.0
        end = min(moved[n], right) - left if up else min(bounds[n], right) - left
        if end <= begin:
            continue
        second = 0.5 * (end * end - begin * begin)
        third = (end**3 - begin**3) / 3.0
        da = g1 * second + g0 * (end - begin)
        dv = g1 * third + g0 * second + da * left
        if da < c.area[donor] * TINY or dv < c.ice[donor] * TINY:
            continue
        if da > c.area[donor] * (1.0 - TINY) or dv > c.ice[donor] * (1.0 - TINY):
            da, dv = c.area[donor], c.ice[donor]
        area[n] = da if up else -da
        volume[n] = dv if up else -dv


@jit
def remap(c: Column, before: np.ndarray, bounds: np.ndarray, s: Scratch, p: Physics) -> bool:
    """Move ice between categories after growth and melt; false where only rebinning can.

    Lipscomb (2001), for two or more categories.

    Parameters
    ----------
    c : Column
        After growth and melt; advanced.
    before : ndarray
        Thickness before (m), (ncat,).
    bounds : ndarray
        Fixed bounds (m), (ncat + 1,).
    s : Scratch
        Work arrays.
    p : Physics
        Constants.

    Returns
    -------
    bool
        False where shifted bounds cross: the column is as it was then.
    """
    if not shifted_bounds(c, before, bounds, s.moved):
        return False
    lose_thin_area(c, before, bounds, s.moved)
    transfers(c, bounds, s.moved, s.area, s.volume)
    shift(c, s)
    if c.area[0] > TINY and c.ice[0] < c.area[0] * p.least_thickness:
        c.area[0] = c.ice[0] / p.least_thickness
    return True


@jit
def shift(c: Column, s: Scratch) -> None:
    """Carry out the transfers of ``s.area`` and ``s.volume`` across the bounds.

    Each takes the donor's snow and surface with the area, its energy with the volume, all as they
    were before any transfer (Lipscomb 2001).

    Parameters
    ----------
    c : Column
        Advanced.
    s : Scratch
        Transfers and work arrays.
    """
    last = c.area.size
    for n in range(last):
        s.touched[n] = 0.0
        s.first_area[n], s.first_snow[n] = c.area[n], c.snow[n]
        s.warmth[n] = c.area[n] * c.surface[n]
        level_amounts(c, n, s.level[n])
        for k in range(c.ice_enthalpy.shape[1]):
            s.ice_energy[n, k] = c.ice_enthalpy[n, k] * c.ice[n]
            s.salt[n, k] = c.salinity[n, k] * c.ice[n]
        for k in range(c.snow_enthalpy.shape[1]):
            s.snow_energy[n, k] = c.snow_enthalpy[n, k] * c.snow[n]
    for n in range(1, last):
        if s.area[n] != 0.0:
            up = s.area[n] > 0.0
            donor, taker = (n - 1, n) if up else (n, n - 1)
            hand_over(c, s, donor, taker, abs(s.area[n]), abs(s.volume[n]))
    for n in range(last):
        if s.touched[n] == 0.0 or c.area[n] <= 0.0 or c.ice[n] <= 0.0:
            continue
        c.surface[n] = s.warmth[n] / c.area[n]
        level_shares(c, n, s.level[n])
        for k in range(c.ice_enthalpy.shape[1]):
            c.ice_enthalpy[n, k] = s.ice_energy[n, k] / c.ice[n]
            c.salinity[n, k] = s.salt[n, k] / c.ice[n]
        for k in range(c.snow_enthalpy.shape[1]):
            if c.snow[n] > 0.0:
                c.snow_enthalpy[n, k] = s.snow_energy[n, k] / c.snow[n]


@jit
def hand_over(c: Column, s: Scratch, donor: int, taker: int, area: float, volume: float) -> None:
    """Move area and volume with all that they carry, in extensive quantities.

    Parameters
    ----------
    c : Column
        Advanced.
    s : Scratch
        Amounts of each category before the transfers; advanced.
    donor : int
        Category that gives, and the one that takes.
    taker : int
        Category that gives, and the one that takes.
    area : float
        Area fraction, and ice volume per area of the element (m).
    volume : float
        Area fraction, and ice volume per area of the element (m).
    """
    snow = s.first_snow[donor] * (area / s.first_area[donor])
    flat = area * c.level[donor, LEVEL_AREA]
    pond = flat * c.level[donor, POND_AREA]
    move(s.level, donor, taker, LEVEL_AREA, flat)
    move(s.level, donor, taker, LEVEL_VOLUME, volume * c.level[donor, LEVEL_VOLUME])
    move(s.level, donor, taker, POND_AREA, pond)
    move(s.level, donor, taker, POND_DEPTH, pond * c.level[donor, POND_DEPTH])
    move(s.level, donor, taker, POND_LID, pond * c.level[donor, POND_LID])
    c.area[donor] -= area
    c.ice[donor] -= volume
    c.snow[donor] -= snow
    c.area[taker] += area
    c.ice[taker] += volume
    c.snow[taker] += snow
    s.warmth[donor] -= c.surface[donor] * area
    s.warmth[taker] += c.surface[donor] * area
    for k in range(c.ice_enthalpy.shape[1]):
        energy = c.ice_enthalpy[donor, k] * volume
        s.ice_energy[donor, k] -= energy
        s.ice_energy[taker, k] += energy
        salt = c.salinity[donor, k] * volume
        s.salt[donor, k] -= salt
        s.salt[taker, k] += salt
    for k in range(c.snow_enthalpy.shape[1]):
        energy = c.snow_enthalpy[donor, k] * snow
        s.snow_energy[donor, k] -= energy
        s.snow_energy[taker, k] += energy
    s.touched[donor] = s.touched[taker] = 1.0


@jit
def move(amounts: np.ndarray, donor: int, taker: int, kind: int, amount: float) -> None:
    """Move an amount of one kind, no more than there is, from donor to taker.

    Parameters
    ----------
    amounts : ndarray
        (ncat, kinds); changed.
    donor : int
        Category that gives, and the one that takes.
    taker : int
        Category that gives, and the one that takes.
    kind : int
        Column of the kind.
    amount : float
        In the unit of the kind.
    """
    amount = min(amount, amounts[donor, kind])
    amounts[donor, kind] -= amount
    amounts[taker, kind] += amount
