# SPDX-License-Identifier: GPL-2.0-or-later
# mypy: disable-error-code="no-untyped-def"
"""Light in snow, ice and ponds with multiple scattering, in three bands.

Briegleb and Light (2007); numbers of equations are those of docs/theory/column_light.md. Bare ice,
snow and ponds that share a category are computed apart. Snow and ice have a thin layer at the
surface that scatters strongly; what it absorbs warms the surface, what is absorbed below warms the
layers.
"""

from __future__ import annotations

from typing import NamedTuple

from floeflow.column import records as r
from floeflow.column.optics import (
    BANDS,
    DRAINED,
    ICE_ASYMMETRY,
    INSIDE,
    OCEAN_ALBEDO,
    POND_INSIDE,
    POND_SURFACE,
    SURFACE,
    WATER_EXTINCTION,
    grain_place,
    ice_scattering,
    snow_grains,
    snow_optics,
)
from floeflow.column.physics import TINY, jit
from floeflow.column.ponds import pond_cover
from floeflow.column.scattering import (
    LEAST_LIGHT,
    LOWEST_SUN,
    add_up,
    copy_layer,
    pass_down,
    refract,
    refracted,
    scatter,
)

BARE, SNOW, POND = range(3)
SNOW_SKIN, ICE_SKIN = 0.04, 0.05  # most of what is the scattering surface (m)
DEEP_POND = 0.2  # m, from which on the ice below a pond has properties of its own


class Slab(NamedTuple):
    """What light meets in one kind of surface, the same for all bands.

    Parameters
    ----------
    kind : int
        Bare ice, snow or pond.
    first, layers : int
        Number of snow and of ice layers.
    ice, snow, pond : float
        Thickness of ice, of snow, depth of the pond (m).
    radius : float
        Of snow grains (um), with the sky counted in.
    row : int
        Of the table of snow.
    share : float
        Of the next row.
    """

    kind: int
    first: int
    layers: int
    ice: float
    snow: float
    pond: float
    radius: float
    row: int
    share: float


@jit
def absorb_scattered(c, n, ice, snow, first, w, rays, f, dt, p):
    """Light absorbed at the surface and passed to the ocean (W/m2); fills ``w.source``.

    Parameters
    ----------
    c : Column
        Surface temperature, ponds; snow on lids is brought up to date.
    n : int
        Category.
    ice, snow : float
        m.
    first : int
        Number of snow layers.
    w : Profile
        Its source is written.
    rays : Rays
        Work arrays.
    f : ndarray
        Forcing.
    dt : float
        s.
    p : Physics
        Constants.
    """
    w.source[:] = 0.0
    covered = 0.0
    if snow >= p.least_snow:
        covered = 1.0
        if p.snow_cover_depth > TINY:
            covered = min(snow / p.snow_cover_depth, 1.0)
    wet = pond = 0.0
    if p.ponds:
        wet, pond, covered, snow = pond_cover(c.level[n], snow, covered, f[r.SNOWFALL] * dt, p)
    if f[r.VISIBLE] + f[r.INFRARED] <= TINY:
        return 0.0, 0.0
    bare = 1.0 - covered - wet
    light = through = 0.0
    for kind in range(3):
        share = bare if kind == BARE else (covered if kind == SNOW else wet)
        if share > (TINY if kind == POND else 0.0):
            surface, below = shine(kind, share, ice, snow, pond, c.surface[n], first, w, rays, f, p)
            light += surface
            through += below
    return light, through


@jit
def shine(kind, share, ice, snow, pond, surface, first, w, rays, f, p):
    """Light absorbed at and passed by one kind of surface; adds to ``w.source``, all by share."""
    sky = 1.0 - 0.2 * f[r.DIFFUSE_INFRARED]
    radius = snow_grains(surface, p) * sky
    row, above = grain_place(radius)
    layers = w.source.size - first
    slab = Slab(kind, first, layers, ice, snow, pond, radius, row, above)
    rays.net[:] = 0.0
    near = 0.67 + 0.11 * f[r.DIFFUSE_INFRARED]
    for band in range(BANDS):
        if band == 0:
            sun, diffuse = f[r.VISIBLE], f[r.DIFFUSE_VISIBLE]
        else:
            sun, diffuse = f[r.INFRARED], f[r.DIFFUSE_INFRARED]
            sun *= near if band == 1 else 1.0 - near
        shine_band(slab, band, sun * (1.0 - diffuse), sun * diffuse, f[r.SUN_HEIGHT], rays, p)

    net = rays.net
    top = first + 1 if kind == BARE else 0
    below = 1 if kind == SNOW else first + 2
    if kind == SNOW:
        for k in range(first):
            w.source[k] += share * (net[k + 1] - net[k + 2])
    for k in range(first, w.source.size):
        # Under snow the surface layer of the ice counts to its first layer.
        start = k + 1 if kind == SNOW and k == first else k + 2
        w.source[k] += share * (net[start] - net[k + 3])
    return share * (net[top] - net[below]), share * net[first + layers + 2]


@jit
def shine_band(slab, band, direct, diffuse, height, rays, p):
    """Add the net fluxes of one band to ``rays.net``."""
    sun = max(height, LOWEST_SUN)
    inner = refracted(sun)
    start = slab.first + 1 if slab.kind == BARE else 0
    mirror = 0 if slab.kind == POND else slab.first + 2
    end = slab.first + slab.layers + 2
    rays.direct[start] = rays.total[start] = rays.diffuse[start] = 1.0
    rays.back_above[start] = 0.0
    depth = albedo = asymmetry = -1.0
    last = end
    for k in range(start, end):
        if rays.total[k] <= LEAST_LIGHT:
            last = k
            break
        before, albedo_before, asymmetry_before = depth, albedo, asymmetry
        depth, albedo, asymmetry = layer_optics(slab, band, k, p)
        same = depth == before and albedo == albedo_before and asymmetry == asymmetry_before
        if same and k - 1 != mirror and k != mirror:
            copy_layer(rays, k)
        else:
            scatter(rays, k, depth, albedo, asymmetry, sun if k < mirror else inner)
            if k == mirror:
                refract(rays, k, sun, inner)
        pass_down(rays, k)
    add_up(rays, start, last, OCEAN_ALBEDO[band] if last == end else 0.0, direct, diffuse)


@jit
def layer_optics(slab, band, k, p):
    """Optical depth, albedo and asymmetry of layer k from the top (eqs. 11 to 13).

    The snow's scattering surface, the rest of its first layer, its other layers (or as many of
    pond water); then those of the ice likewise.
    """
    first = slab.first
    if k <= first:
        if slab.kind == POND:
            return WATER_EXTINCTION[band] * slab.pond / (first + 1.0), 0.0, 0.0
        extinction, albedo, asymmetry = snow_optics(slab.radius, slab.row, slab.share, band, p)
        layer = slab.snow / first
        skin = min(SNOW_SKIN, 0.5 * layer)
        thick = skin if k == 0 else (layer - skin if k == 1 else layer)
        return extinction * thick, albedo, asymmetry
    layer = slab.ice / slab.layers
    skin = min(min(ICE_SKIN, slab.ice / 30.0), 0.5 * layer)
    place = k - first - 1
    thick = skin if place == 0 else (layer - skin if place == 1 else layer)
    drained = place == 1 and slab.layers > 1
    kind = SURFACE if place == 0 else (DRAINED if drained else INSIDE)
    scatters, absorbs = ice_scattering(kind, band, p)
    # The drained layer is as deep however many layers there are.
    factor = 0.25 * slab.layers if drained else 1.0
    if slab.kind == POND:
        under = POND_SURFACE if place == 0 else POND_INSIDE
        deep, absorbs = ice_scattering(under, band, p)
        wet = min(slab.pond / DEEP_POND, 1.0)
        bare_part = scatters * factor
        scatters = bare_part + (deep - bare_part) * wet
    else:
        scatters, absorbs = scatters * factor, absorbs * factor
        if place == slab.layers and band == 0:
            # The layer of algae absorbs the same however thick it is.
            absorbs += 0.5 * p.algae / thick
    extinction = scatters + absorbs
    return extinction * thick, scatters / extinction, ICE_ASYMMETRY
