# SPDX-License-Identifier: GPL-2.0-or-later
"""Melt ponds on level ice: water, area, lids of ice, and what of them the sun sees.

Hunke, Hebert and Lecomte (2013); numbers of equations are those of docs/theory/column_ponds.md. The
water of ponds is counted apart: the ice has given it to the sea when it melted, and what drains
takes no heat along but in mush.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from floeflow.column.physics import TINY, jit
from floeflow.column.records import (
    LEVEL_AREA,
    LID_SHARE,
    LID_SNOW,
    POND_AREA,
    POND_DEPTH,
    POND_DRAINED,
    POND_FROZEN,
    POND_GAIN,
    POND_LID,
    POND_LOST,
)
from floeflow.column.thermodynamics.enthalpy import ice_temperature

if TYPE_CHECKING:
    from floeflow.column.physics import Physics
    from floeflow.column.records import Column, Thickness
    from floeflow.column.thermodynamics.profile import Profile

FRESH = 1000.0  # density of pond water (kg/m3)
SHALLOWEST = 0.005  # m, of ponds that the sun sees
LEAST_SLUSH = 0.15  # share of the water in soaked snow from which on a pond shows
COLD_START = 2.0  # K below melting from which on ponds without lids shrink
CONTRACTION = 0.01
FLAW_DEPTH = 0.01  # m


class PondForcing(NamedTuple):
    """What fills ponds in a step, and what their lids see.

    Parameters
    ----------
    melted : float
        Mass of ice and snow that melted at the top (kg/m2).
    rain : float
        kg/m2.
    air : float
        Temperature of the air (degC).
    flux : float
        From the air into the surface (W/m2).
    """

    melted: float
    rain: float
    air: float
    flux: float


class Pond(NamedTuple):
    """A pond of one category.

    Parameters
    ----------
    area : float
        Share of the ice under the pond.
    depth : float
        Of the water (m).
    flat : float
        Share of the ice that is level.
    cover : float
        Area of the category.
    """

    area: float
    depth: float
    flat: float
    cover: float


@jit
def pond_cover(
    level: np.ndarray, snow: float, covered: float, fallen: float, p: Physics
) -> tuple[float, ...]:
    """What of the ponds the sun sees: share, depth (m), share of snow left, snow depth (m).

    Snow falls on lids and hides ponds, melting lids have used a share of the heat, and water
    soaks into snow before it shows (Hunke et al. 2013; eqs. 8 to 10). Brings ``level``'s snow on
    lids up to date. ``fallen`` is the snow of the step: its mass (kg/m2) is taken for a depth (m),
    as the reference does, so that snow hides a lid within hours.

    Parameters
    ----------
    level : ndarray
        What is in ``LEVEL`` of the category, (len(LEVEL),); its snow on lids is changed.
    snow : float
        Depth of the snow on the ice (m).
    covered : float
        Share of the ice that snow covers.
    fallen : float
        Snow of the step (kg/m2, read as m).
    p : Physics
        Constants.

    Returns
    -------
    tuple of float
        Share of the ice under ponds that the sun sees, their depth (m), share of the ice under
        snow, depth of the snow (m).
    """
    area = level[LEVEL_AREA] * level[POND_AREA]
    lid = area * level[POND_LID]
    gap = level[LID_SNOW]
    if lid > TINY and gap < TINY and fallen > p.least_snow:
        gap = snow - fallen
    on_lid = snow - gap
    if lid * on_lid < TINY:
        gap = 0.0
    level[LID_SNOW] = gap
    share, depth = (1.0 - level[LID_SHARE]) * area, level[POND_DEPTH]
    if gap > TINY and on_lid >= TINY and p.lid_snow_depth > TINY:
        share *= 1.0 - min(on_lid / p.lid_snow_depth, 1.0)
    if depth > TINY:
        water, mass = FRESH * depth, p.snow_density * snow
        if water < LEAST_SLUSH * (water + mass):
            share = depth = 0.0
        elif depth >= snow * (FRESH - p.snow_density) / FRESH:
            depth = (water + mass) / FRESH
        else:
            snow -= water / (FRESH - p.snow_density) * share
            share = depth = 0.0
    if depth < SHALLOWEST:
        share = 0.0
    return share, depth, min(covered, 1.0 - share), snow


@jit
def flush(c: Column, n: int, speed: float, dt: float, sums: np.ndarray, p: Physics) -> None:
    """Drain ponds into mush at a Darcy speed (m/s) and through its flaws (eqs. 6 and 7).

    Parameters
    ----------
    c : Column
        Categories; the depth of the ponds is reduced.
    n : int
        Category.
    speed : float
        Darcy speed (m/s) through the ice.
    dt : float
        Time step (s).
    sums : ndarray
        Budget terms, added to, (len(SUMS),).
    p : Physics
        Constants.
    """
    level = c.level[n]
    area = level[LEVEL_AREA] * level[POND_AREA]
    before = level[POND_DEPTH]
    if area > 0.0 and before > 0.0:
        depth = max(before - speed * dt / area, 0.0)
        depth = max(depth - dt / p.pond_drain_time * (depth + FLAW_DEPTH), 0.0)
        level[POND_DEPTH] = depth
        sums[POND_DRAINED] += c.area[n] * area * (before - depth)


@jit
def evolve(
    c: Column,
    n: int,
    w: Profile,
    thickness: Thickness,
    forcing: PondForcing,
    dt: float,
    sums: np.ndarray,
    p: Physics,
) -> None:
    """Advance the ponds of category n by a step (eqs. 1 and 3 to 5).

    Parameters
    ----------
    c : Column
        Its ponds are advanced; area of the category as at the step's start.
    n : int
        Category.
    w : Profile
        Enthalpies and salinities after the step, for the seepage of Bitz-Lipscomb ice.
    thickness : Thickness
        After growth and melt.
    forcing : PondForcing
        Of the step.
    dt : float
        s.
    sums : ndarray
        Budget terms, added to.
    p : Physics
        Constants.
    """
    ice, snow = thickness
    level, cover = c.level[n], c.area[n]
    level[LID_SHARE] = 0.0
    flat = level[LEVEL_AREA]
    area = flat * level[POND_AREA]
    depth, lid = level[POND_DEPTH], level[POND_LID]
    if cover * flat <= TINY * TINY:
        return
    if p.ponds_cover_level and flat > TINY:
        sums[POND_LOST] -= cover * (flat - area) * depth
        area = flat
    # What runs off a floe depends on the leads around it, not on how categories divide the ice.
    around = cover if p.ponds_cover_level else min(c.area.sum(), 1.0)
    water = depth * area
    if ice < p.least_thickness:
        sums[POND_LOST] += cover * water
        level[POND_AREA] = level[POND_DEPTH] = level[POND_LID] = 0.0
        return
    catch = p.least_catch + (p.most_catch - p.least_catch) * around
    gain = catch * (forcing.melted + forcing.rain) / FRESH
    sums[POND_GAIN] += cover * gain
    if p.pond_lids:
        grown, level[LID_SHARE] = lid_growth(
            lid, depth, gain, forcing.air, forcing.flux, snow - level[LID_SNOW], dt, p
        )
        lid = max(lid + grown, 0.0)
        frozen = grown * area * p.ice_density / FRESH
    else:
        lid = 0.0
        cold = max(-COLD_START - c.surface[n], 0.0)
        frozen = water * (1.0 - math.exp(-CONTRACTION * cold / COLD_START))
    sums[POND_FROZEN] += cover * frozen
    change = gain - frozen
    whole = water + change
    sums[POND_LOST] += cover * min(whole, 0.0)
    water = max(whole, 0.0)
    area, depth = shape(area if whole > 0.0 else 0.0, water, change, flat, cover, p)
    # No deeper than what keeps the ice afloat.
    most = ((p.water_density - p.ice_density) * ice - p.snow_density * snow) / FRESH
    depth = min(depth, most)
    if depth * area <= 0.0:
        area = depth = lid = 0.0
    if not p.mushy and p.pond_seepage > TINY and depth > 0.0:
        kept = depth * area
        first = c.snow_enthalpy.shape[1]
        area, depth = seep(w, first, thickness, Pond(area, depth, flat, cover), dt, p)
        sums[POND_DRAINED] += cover * (kept - depth * area)
        water -= kept - depth * area
    sums[POND_LOST] += cover * (water - depth * area)
    level[POND_AREA] = area / flat
    level[POND_DEPTH], level[POND_LID] = depth, lid


@jit
def lid_growth(
    lid: float,
    depth: float,
    gain: float,
    air: float,
    flux: float,
    on_lid: float,
    dt: float,
    p: Physics,
) -> tuple[float, ...]:
    """Ice that lids gain (m, negative: melts), and the share of the flux that melting takes.

    Stefan's law below the air while nothing melts (eq. 3); else the surface's flux melts the lid,
    and where no snow lies on it that heat does not reach the pond (eq. 4).

    Parameters
    ----------
    lid : float
        Thickness of the lid (m).
    depth : float
        Of the water in the pond (m).
    gain : float
        Melt water and rain that the pond caught in the step (m of water per area of the ice).
    air : float
        Temperature of the air (degC).
    flux : float
        From the air into the surface (W/m2).
    on_lid : float
        Snow on the lid (m).
    dt : float
        Time step (s).
    p : Physics
        Constants.

    Returns
    -------
    tuple of float
        Ice gained (m), and share of the flux that melting took.
    """
    latent = p.ice_density * p.fusion
    if gain == 0.0:
        if air >= 0.0:
            return 0.0, 0.0
        square = -2.0 * air * p.fresh_conductivity * dt / latent
        grown = 0.5 * math.sqrt(square)
        if lid > grown:
            grown = 0.5 * square / lid
        return min(grown, depth * FRESH / p.ice_density), 0.0
    melts = min(max(flux * dt / latent, 0.0), lid)
    share = 0.0
    if on_lid < TINY:
        share = 1.0
        if flux > TINY:
            share = min(melts * latent / (dt * flux), 1.0)
    return -melts, share


@jit
def shape(
    area: float, water: float, change: float, flat: float, cover: float, p: Physics
) -> tuple[float, ...]:
    """Area and depth of a pond that holds water and changed by so much (eq. 5; m of the ice).

    Parameters
    ----------
    area : float
        Share of the ice under the pond before.
    water : float
        Volume of the pond's water per area of the ice (m).
    change : float
        By how much the step changed it (m).
    flat : float
        Share of the ice that is level.
    cover : float
        Area fraction of the category.
    p : Physics
        Constants.

    Returns
    -------
    tuple of float
        Share of the ice under the pond, and depth (m).
    """
    if not p.ponds_cover_level:
        return basin(water, flat, p)
    if area * cover > TINY:
        area = max(min(area + 0.5 * change / (p.pond_aspect * area), flat), 0.0)
        return (area, water / area) if area > TINY else (area, 0.0)
    if flat * cover > 10.0 * TINY:
        area = min(math.sqrt(water / p.pond_aspect), flat)
        return area, p.pond_aspect * area
    return 0.0, 0.0


@jit
def basin(water: float, flat: float, p: Physics) -> tuple[float, ...]:
    """Area and depth of a pond that is as deep as wide by its aspect, where there is room.

    Parameters
    ----------
    water : float
        Volume of the pond's water per area of the ice (m).
    flat : float
        Share of the ice that is level.
    p : Physics
        Constants.

    Returns
    -------
    tuple of float
        Share of the ice under the pond, and depth (m).
    """
    area = min(math.sqrt(water / p.pond_aspect), flat)
    return (area, water / area) if area > TINY else (0.0, 0.0)


@jit
def seep(
    w: Profile, first: int, thickness: Thickness, pond: Pond, dt: float, p: Physics
) -> tuple[float, ...]:
    """Area and depth of a pond after drainage through Bitz-Lipscomb ice (eq. 6 with eq. 11).

    Parameters
    ----------
    w : Profile
        Enthalpies and salinities.
    first : int
        Number of snow layers.
    thickness : Thickness
        Of ice and snow.
    pond : Pond
        Before.
    dt : float
        s.
    p : Physics
        Constants.

    Returns
    -------
    tuple of float
        Share of the ice, and m.
    """
    ice, snow = thickness
    area, depth, flat, cover = pond
    floats = (p.snow_density * snow + p.ice_density * ice) / p.water_density + depth
    head = p.gravity * p.water_density * max(depth + ice - floats, 0.0)
    least = 1.0
    for k in range(first, w.enthalpy.size):
        melting = -p.melting_slope * w.salt[k]
        temperature = ice_temperature(w.enthalpy[k], melting, p)
        liquid = w.salt[k] * (1e-3 - p.melting_slope / min(temperature, -TINY))
        least = min(least, liquid if liquid >= 0.05 else 0.0)
    seeps = 3e-8 * least**3 * head * dt / (p.viscosity * ice) * p.pond_seepage
    change = -min(seeps, depth) * area
    water = depth * area + change
    if not p.ponds_cover_level:
        return basin(water, flat, p)
    area = max(min(area + 0.5 * change / (p.pond_aspect * area * cover), flat), 0.0)
    return area, water / area if area * cover > TINY else 0.0
