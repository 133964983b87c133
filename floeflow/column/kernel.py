# SPDX-License-Identifier: GPL-2.0-or-later
"""One column through its processes, and all columns of a slice in parallel.

The only function that Python calls is `advance`, compiled once and cached. What Numba caches
depends on the file in which a function stands, not on the functions that it calls: a digest of the
whole folder is bound in, so that a change of any module compiles anew.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numba
import numpy as np

from floeflow.column import records as r
from floeflow.column.ocean.ocean import MixedLayer, freezing_temperature, heat_to_ice, limit, mix
from floeflow.column.physics import KELVIN, TINY, jit
from floeflow.column.ponds.ponds import PondForcing, evolve, flush
from floeflow.column.records import (
    Array,
    Scratch,
    Thickness,
    Water,
    category_energy,
    category_water,
    column_of,
    new_scratch,
    pond_water,
)
from floeflow.column.shortwave.absorption import shed_light
from floeflow.column.shortwave.delta_eddington import MEDIA, ice_media
from floeflow.column.shortwave.scattering import Rays, new_rays
from floeflow.column.thermodynamics.bl99 import solve_temperatures
from floeflow.column.thermodynamics.boundary_layer import Air, SurfaceForcing, transfer
from floeflow.column.thermodynamics.growth import change_thickness
from floeflow.column.thermodynamics.layers import flood_mush
from floeflow.column.thermodynamics.mushy import solve_mush
from floeflow.column.thermodynamics.profile import Profile, fill, new_profile
from floeflow.column.thickness.categories import remap
from floeflow.column.thickness.category_cleanup import clear, empty, melt_sides, open_area, rebin
from floeflow.column.thickness.leads import lead_balance
from floeflow.column.thickness.new_ice import freeze_leads

if TYPE_CHECKING:
    from floeflow.column.physics import Physics
    from floeflow.column.records import Column, Sea

HOUR = 3600.0  # s
SKY = 10.0  # K by which a clear sky may make a surface colder than the air
CHUNK = 64  # columns that a thread takes at a time; has no effect on results


class Work(NamedTuple):
    """What a thread works with, one column after the other.

    Parameters
    ----------
    bounds : ndarray
        Of the thickness categories (m), (ncat + 1,).
    layers : Profile
        Layers of the category at hand.
    categories : Scratch
        Work arrays of the thickness distribution.
    rays : Rays
        Work arrays of the light.
    """

    bounds: Array
    layers: Profile
    categories: Scratch
    rays: Rays


@jit
def grow_category(
    c: Column,
    n: int,
    work: Work,
    f: np.ndarray,
    water: Water,
    sums: np.ndarray,
    dt: float,
    p: Physics,
) -> tuple[float, ...]:
    """Advance one category vertically; energy and light (J/m2) that it lets into the sea.

    Order: light, turbulent coefficients, temperatures, flooding, thickness, ponds.

    Parameters
    ----------
    c : Column
        Its category is advanced.
    n : int
        Category, with ice.
    work : Work
        Work arrays.
    f : ndarray
        Forcing, (len(FORCING),).
    water : Water
        Under the ice.
    sums : ndarray
        Budget terms, added to, (len(SUMS),).
    dt : float
        s.
    p : Physics
        Constants.

    Returns
    -------
    spare, through : float
        Heat and light that go into the sea, J/m2 of the element's area; `spare` is negative where
        the sea gives heat.
    """
    w, air = work.layers, air_of(f)
    area = c.area[n]
    thickness = Thickness(c.ice[n] / area, c.snow[n] / area)
    first = c.snow_enthalpy.shape[1]
    fill(w, thickness.ice, thickness.snow, c.ice_enthalpy[n], c.snow_enthalpy[n], c.salinity[n], p)
    light, through = shed_light(c, n, thickness, w, work.rays, f, dt, p)
    sensible, latent = transfer(c.surface[n], air, False, p)
    above = SurfaceForcing(light, air, sensible, latent)
    flooded = carried = taken = brine = salt = 0.0
    if p.mushy:
        pond = (c.level[n, r.POND_DEPTH], c.level[n, r.LEVEL_AREA] * c.level[n, r.POND_AREA])
        found, advected, salt, sinks = solve_mush(w, first, c.surface[n], water, above, pond, dt, p)
        if p.ponds:
            flush(c, n, sinks, dt, sums, p)
        if p.flooding:
            flooded, taken, brine = flood_mush(w, first, water.freezing, water.salinity, p)
        salt += brine
        carried = advected * dt - taken
    else:
        found = solve_temperatures(w, first, c.surface[n], water.freezing, above, dt, p)
    change = change_thickness(w, first, found, water, f[r.SNOWFALL], dt, p)

    inside = 0.0
    for k in range(w.source.size):
        inside += w.source[k]
    sums[r.LIGHT_ABSORBED] += area * dt * (light + inside)
    vapour = p.ice_density * change.sublimation_ice + p.snow_density * change.sublimation_snow
    warmed = dt * (found.net - found.latent + inside) - p.vapour * vapour
    sums[r.AIR_TO_ICE] += area * warmed
    sums[r.SNOWFALL_ENERGY] -= area * p.snow_density * p.fusion * change.snowfall
    sums[r.VAPOUR_ICE] += area * vapour
    sums[r.SNOWFALL_SUM] += area * change.snowfall
    sums[r.GROWTH] += area * change.growth
    sums[r.SNOW_ICE] += area * (change.snow_ice + flooded)
    drowned = change.snow_ice * p.ice_density / p.snow_density + flooded
    sums[r.FLOODED_SNOW] += area * drowned
    sums[r.MELT_TOP] += area * change.melt_top
    sums[r.MELT_BOTTOM] += area * change.melt_bottom
    sums[r.SUBLIMATION_ICE] += area * change.sublimation_ice
    sums[r.SUBLIMATION_SNOW] += area * change.sublimation_snow
    sums[r.MELT_SNOW] += area * (change.melt_snow + change.drowned)
    sums[r.SALT_TO_ICE] += area * (salt + change.salt)
    sums[r.SWEEPS] += abs(found.sweeps)
    sums[r.SOLVES] += 1.0
    sums[r.RESCUED] += 1.0 if found.sweeps < 0 else 0.0
    # What is not a number is no 0 and not below a bound.
    sums[r.UNCONVERGED] += 0.0 if found.left == 0.0 else 1.0
    sums[r.FAILED] += 0.0 if found.left <= p.largest_left else 1.0

    if change.ice <= 0.0:
        sums[r.POND_LOST] += category_water(c, n)
        empty(c, n, water.freezing)
    else:
        c.ice[n], c.snow[n] = area * change.ice, area * change.snow
        c.surface[n] = found.temperature
        for k in range(first):
            c.snow_enthalpy[n, k] = w.enthalpy[k]
        for k in range(first, w.enthalpy.size):
            c.ice_enthalpy[n, k - first] = w.enthalpy[k]
            c.salinity[n, k - first] = w.salt[k]
    if p.ponds and change.ice > 0.0:
        c.surface[n] = found.temperature
        melted = p.ice_density * change.melt_top + p.snow_density * change.melt_snow
        if p.mushy:
            melted += p.snow_density * change.drowned
        warm = f[r.POTENTIAL_TEMPERATURE] - KELVIN
        forcing = PondForcing(melted, f[r.RAIN] * dt, warm, found.net)
        evolve(c, n, w, Thickness(change.ice, change.snow), forcing, dt, sums, p)
    # What the sea gets: what found nothing to melt, less what it gave.
    return area * (change.spare + carried - water.heat * dt), area * through * dt


@jit
def air_of(f: np.ndarray) -> Air:
    """Air in the forcing of a step.

    Parameters
    ----------
    f : ndarray
        Forcing of one element in one step, in the order of `records`.

    Returns
    -------
    Air
        Potential temperature (K), humidity (kg/kg), density (kg/m3), wind (m/s), longwave (W/m2).
    """
    return Air(f[r.POTENTIAL_TEMPERATURE], f[r.HUMIDITY], f[r.DENSITY], f[r.WIND], f[r.LONGWAVE])


@jit
def step_column(
    c: Column,
    sea: float,
    pending: float,
    work: Work,
    f: np.ndarray,
    sums: np.ndarray,
    dt: float,
    p: Physics,
) -> tuple[float, ...]:
    """One step of one column; temperature of the mixed layer and energy to be frozen (J/m2).

    Parameters
    ----------
    c : Column
        Advanced.
    sea : float
        Temperature of the mixed layer (degC).
    pending : float
        Energy that the sea lacks and that ice will be made of (J/m2).
    work : Work
        Bounds of the categories, and work arrays.
    f : ndarray
        Forcing, (len(FORCING),).
    sums : ndarray
        Budget terms, added to, (len(SUMS),).
    dt : float
        s.
    p : Physics
        Constants.

    Returns
    -------
    sea, pending : float
        Temperature of the mixed layer after the step (degC), and the energy (J/m2, not negative)
        that it lacks, of which ice will be made.
    """
    s, bounds, air = work.categories, work.bounds, air_of(f)
    freezing = freezing_temperature(f[r.SEA_SALINITY], p)
    store = p.heat_water * p.water_density * f[r.MIXED_DEPTH] / dt
    potential = pending / dt
    if pending <= 0.0:
        potential = max((freezing - sea) * store, -p.largest_potential)
    if p.mixed:
        bottom, side = heat_to_ice(sea, freezing, potential, f[r.OCEAN_FRICTION], dt, p)
    else:
        bottom, side = f[r.DEEP_HEAT], 0.0
    stored = total = 0.0
    for n in range(c.area.size):
        s.before[n] = c.ice[n] / c.area[n] if c.area[n] > TINY else 0.0
        stored += category_energy(c, n)
    if side > 0.0:
        bottom, side = limit(bottom, side, stored, potential, dt)

    under = Water(freezing, f[r.SEA_SALINITY], bottom)
    heat = light = 0.0
    for n in range(c.area.size):
        if c.area[n] > TINY:
            rest, through = grow_category(c, n, work, f, under, sums, dt, p)
            heat += rest
            light += through
    water = pond_water(c)
    if c.area.size > 1:
        remap(c, s.before, bounds, s, p)
    lit = (1.0 - p.albedo_ocean) * (f[r.VISIBLE] + f[r.INFRARED])
    from_air = latent = 0.0
    if not p.mixed:
        pending, side, from_air, latent = lead_balance(c, freezing, lit, air, f[r.DEEP_HEAT], dt, p)
    freeze_leads(c, s, max(pending, 0.0), under, work.layers, bounds, sums, p)
    heat -= melt_sides(c, side, sums)
    if c.area.size == 1:
        open_area(c, s.before[0], bounds[0])
    rebin(c, s, bounds)
    heat -= clear(c, freezing, sums)
    sums[r.POND_LOST] += water - pond_water(c)
    sums[r.OCEAN_TO_ICE] -= heat
    sums[r.LIGHT_TO_SEA] += light

    if not p.mixed:
        # The ocean closes the balance of a sea whose heat does not change.
        sums[r.AIR_TO_SEA] += from_air
        sums[r.DEEP_TO_SEA] -= heat + pending + from_air + light
        sums[r.VAPOUR_SEA] -= latent / p.vapour
        return freezing, 0.0
    for n in range(c.area.size):
        total += c.area[n]
    leads = max(1.0 - total, 0.0)
    layer = MixedLayer(sea, freezing, f[r.MIXED_DEPTH], f[r.DEEP_HEAT])
    sea, potential, net, latent, deep = mix(layer, leads, lit, air, (heat + light) / dt, dt, p)
    sums[r.AIR_TO_SEA] += dt * (net + lit * leads)
    sums[r.DEEP_TO_SEA] += dt * deep
    sums[r.VAPOUR_SEA] -= dt * latent / p.vapour
    if not p.frazil and potential > 0.0:
        # No ice may be made of it: the heat comes from below.
        sums[r.DEEP_TO_SEA] += potential * dt
        potential = 0.0
    return sea, max(potential, 0.0) * dt


@jit
def parts_of_step(c: Column, f: np.ndarray, dt: float, p: Physics) -> int:
    """Parts, an hour at most, into which a column cuts a step in which thin ice would outgrow.

    Growth takes the flux through the ice of the step's start. By Stefan's law ice of thickness h
    grows by less than a quarter of it where h**2 is above 4 k (T_freezing - T_air) dt / L; of mush
    a part only must freeze, so that it grows as much faster.

    Parameters
    ----------
    c : Column
        Categories of the element.
    f : ndarray
        Forcing of the step, (len(FORCING),).
    dt : float
        Time step (s).
    p : Physics
        Constants.

    Returns
    -------
    int
        Number of equal parts, 1 where the step may be taken whole.
    """
    if dt <= HOUR:
        return 1
    latent = p.ice_density * p.fusion * ((1.0 - p.bottom_liquid) if p.mushy else 1.0)
    colder = freezing_temperature(f[r.SEA_SALINITY], p) - (f[r.POTENTIAL_TEMPERATURE] - KELVIN)
    reach = 4.0 * p.mush_ice_conductivity * max(colder + SKY, 0.0) * dt / latent
    thinnest, water = 1e3, 1.0
    for n in range(c.area.size):
        if c.area[n] > TINY:
            thinnest = min(thinnest, c.ice[n] / c.area[n])
            water -= c.area[n]
    if water > TINY:
        thinnest = 0.0
    return math.ceil(dt / HOUR) if thinnest * thinnest < reach else 1


@jit
def step_some(
    part: tuple[int, ...],
    columns: Column,
    sea: Sea,
    work: Work,
    forcing: np.ndarray,
    sums: np.ndarray,
    dt: float,
    constants: np.ndarray,
) -> None:
    """Take some elements through all steps, one element after the other.

    Parameters
    ----------
    part : tuple of int
        The first of them, and the first after them.
    columns : Column
        Of all n elements, (n, ...); advanced.
    sea : Sea
        Of all elements, (n,); advanced.
    work : Work
        Bounds of the categories, and work arrays.
    forcing : ndarray
        (steps, n, len(FORCING)).
    sums : ndarray
        Budget terms, added to, (n, len(SUMS)).
    dt : float
        Of each step (s).
    constants : ndarray
        Record of `Physics`, (1,).
    """
    p = constants[0]
    for e in range(part[0], part[1]):
        c = column_of(columns, e)
        for step in range(forcing.shape[0]):
            f = forcing[step, e]
            parts = parts_of_step(c, f, dt, p)
            for _ in range(parts):
                sea.temperature[e], sea.pending_freeze[e] = step_column(
                    c, sea.temperature[e], sea.pending_freeze[e], work, f, sums[e], dt / parts, p
                )


def _build(digest: str) -> Callable[..., Any]:
    @numba.njit(cache=True, parallel=True, error_model="numpy")
    def advance(
        columns: Column,
        sea: Sea,
        forcing: np.ndarray,
        profile: np.ndarray,
        bounds: np.ndarray,
        sums: np.ndarray,
        dt: float,
        constants: np.ndarray,
    ) -> None:
        """Advance columns by all steps of the forcing.

        Parameters
        ----------
        columns : Column
            Of n elements, (n, ncat) and (n, ncat, layers); advanced.
        sea : Sea
            (n,); advanced.
        forcing : ndarray
            (steps, n, len(FORCING)).
        profile : ndarray
            Fixed salinity of the ice's layers (1e-3), (layers,).
        bounds : ndarray
            Of the categories (m), (ncat + 1,).
        sums : ndarray
            Budget terms, added to, (n, len(SUMS)).
        dt : float
            Of each step (s).
        constants : ndarray
            Record of `Physics`, (1,).
        """
        digest  # noqa: B018  (part of the key under which Numba caches)
        count, categories, snow_layers = columns.snow_enthalpy.shape
        for part in numba.prange((count + CHUNK - 1) // CHUNK):
            layers = new_profile(profile, snow_layers, constants)
            scratch = new_scratch(categories, profile.size, snow_layers)
            rays = new_rays(profile.size + snow_layers, MEDIA)
            ice_media(rays.media, profile.size, constants[0])
            work = Work(bounds, layers, scratch, rays)
            span = part * CHUNK, min((part + 1) * CHUNK, count)
            step_some(span, columns, sea, work, forcing, sums, dt, constants)

    return advance


def sources_digest() -> str:
    """Digest of the package's compiled modules: those that speak of ``jit``."""
    parts = [path.read_bytes() for path in sorted(Path(__file__).parent.rglob("*.py"))]
    return hashlib.sha256(b"".join(part for part in parts if b"jit" in part)).hexdigest()


advance = _build(sources_digest())
