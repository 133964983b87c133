# SPDX-License-Identifier: GPL-2.0-or-later
# mypy: disable-error-code="no-untyped-def"
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
from typing import Any

import numba

from floeflow.column import records as r
from floeflow.column.ocean.ocean import MixedLayer, freezing_temperature, heat_to_ice, limit, mix
from floeflow.column.physics import KELVIN, TINY, jit
from floeflow.column.ponds.ponds import PondForcing, evolve, flush
from floeflow.column.records import (
    Column,
    Thickness,
    Water,
    category_energy,
    category_water,
    new_scratch,
    pond_water,
)
from floeflow.column.shortwave.absorption import shed_light
from floeflow.column.shortwave.delta_eddington import MEDIA, ice_media
from floeflow.column.shortwave.scattering import new_rays
from floeflow.column.thermodynamics.bl99 import solve_temperatures
from floeflow.column.thermodynamics.boundary_layer import Air, SurfaceForcing, transfer
from floeflow.column.thermodynamics.growth import change_thickness
from floeflow.column.thermodynamics.layers import flood_mush
from floeflow.column.thermodynamics.mushy import solve_mush
from floeflow.column.thermodynamics.profile import fill, new_profile
from floeflow.column.thickness.categories import remap
from floeflow.column.thickness.category_cleanup import clear, empty, melt_sides, open_area, rebin
from floeflow.column.thickness.leads import lead_balance
from floeflow.column.thickness.new_ice import freeze_leads

HOUR = 3600.0  # s
SKY = 10.0  # K by which a clear sky may make a surface colder than the air


@jit
def grow_category(c, n, w, rays, air, f, water, sums, dt, p):
    """Advance one category vertically; energy and light (J/m2) that it lets into the sea.

    Order: light, turbulent coefficients, temperatures, flooding, thickness, ponds.
    """
    area = c.area[n]
    thickness = Thickness(c.ice[n] / area, c.snow[n] / area)
    first = c.snow_enthalpy.shape[1]
    fill(w, thickness.ice, thickness.snow, c.ice_enthalpy[n], c.snow_enthalpy[n], c.salinity[n], p)
    light, through = shed_light(c, n, thickness, w, rays, f, dt, p)
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
def step_column(c, sea, pending, w, s, rays, f, bounds, sums, dt, p):
    """One step of one column; temperature of the mixed layer and energy to be frozen (J/m2).

    Parameters
    ----------
    c : Column
        Advanced.
    sea : float
        Temperature of the mixed layer (degC).
    pending : float
        Energy that the sea lacks and that ice will be made of (J/m2).
    w, s, rays : Profile, Scratch, Rays
        Work arrays.
    f : ndarray
        Forcing, (len(FORCING),).
    bounds : ndarray
        Of categories (m).
    sums : ndarray
        Budget terms, added to.
    dt : float
        s.
    p : Physics
        Constants.
    """
    air = Air(f[r.POTENTIAL_TEMPERATURE], f[r.HUMIDITY], f[r.DENSITY], f[r.WIND], f[r.LONGWAVE])
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
            rest, through = grow_category(c, n, w, rays, air, f, under, sums, dt, p)
            heat += rest
            light += through
    water = pond_water(c)
    if c.area.size > 1:
        remap(c, s.before, bounds, s, p)
    lit = (1.0 - p.albedo_ocean) * (f[r.VISIBLE] + f[r.INFRARED])
    from_air = latent = 0.0
    if not p.mixed:
        pending, side, from_air, latent = lead_balance(c, freezing, lit, air, f[r.DEEP_HEAT], dt, p)
    freeze_leads(c, s, max(pending, 0.0), under, w, bounds, sums, p)
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
        # No ice may be made of it: the deep pays.
        sums[r.DEEP_TO_SEA] += potential * dt
        potential = 0.0
    return sea, max(potential, 0.0) * dt


@jit
def parts_of_step(c, f, dt, p):
    """Parts, an hour at most, into which a column cuts a step in which thin ice would outgrow.

    Growth takes the flux through the ice of the step's start. By Stefan's law ice of thickness h
    grows by less than a quarter of it where h**2 is above 4 k (T_freezing - T_air) dt / L; of mush
    a part only must freeze, so that it grows as much faster.
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
    begin, end, area, ice, snow, surface, ice_enthalpy, snow_enthalpy, salinity, sea,
    level, pending, w, s, rays, forcing, bounds, sums, dt, constants,
):  # fmt: skip
    """Take elements begin to end - 1 through all steps, one element after the other."""
    p = constants[0]
    for e in range(begin, end):
        c = Column(
            area[e], ice[e], snow[e], surface[e], ice_enthalpy[e], snow_enthalpy[e], salinity[e],
            level[e],
        )  # fmt: skip
        for step in range(forcing.shape[0]):
            f = forcing[step, e]
            parts = parts_of_step(c, f, dt, p)
            for _ in range(parts):
                sea[e], pending[e] = step_column(
                    c, sea[e], pending[e], w, s, rays, f, bounds, sums[e], dt / parts, p
                )


def _build(digest: str) -> Callable[..., Any]:
    @numba.njit(cache=True, parallel=True, error_model="numpy")
    def advance(
        area, ice, snow, surface, ice_enthalpy, snow_enthalpy, salinity, sea, pending, level,
        forcing, profile, bounds, sums, dt, constants, chunk,
    ):  # fmt: skip
        digest  # noqa: B018  (part of the key under which Numba caches)
        count = area.shape[0]
        for part in numba.prange((count + chunk - 1) // chunk):
            w = new_profile(profile, snow_enthalpy.shape[2], constants)
            s = new_scratch(area.shape[1], ice_enthalpy.shape[2], snow_enthalpy.shape[2])
            rays = new_rays(profile.size + snow_enthalpy.shape[2], MEDIA)
            ice_media(rays.media, profile.size, constants[0])
            last = min((part + 1) * chunk, count)
            step_some(
                part * chunk, last, area, ice, snow, surface, ice_enthalpy, snow_enthalpy,
                salinity, sea, level, pending, w, s, rays, forcing, bounds, sums, dt, constants,
            )  # fmt: skip

    return advance


def sources_digest() -> str:
    """Digest of the package's compiled modules: those that speak of ``jit``."""
    parts = [path.read_bytes() for path in sorted(Path(__file__).parent.rglob("*.py"))]
    return hashlib.sha256(b"".join(part for part in parts if b"jit" in part)).hexdigest()


advance = _build(sources_digest())
