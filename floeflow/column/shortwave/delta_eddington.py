# SPDX-License-Identifier: GPL-2.0-or-later
"""Light in snow, ice and ponds with multiple scattering, in three bands.

Briegleb and Light (2007); numbers of equations are those of docs/theory/column_light.md. Bare ice,
snow and ponds that share a category are computed apart. Snow and ice have a thin layer at the
surface that scatters strongly; what it absorbs warms the surface, what is absorbed below warms the
layers.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from floeflow.column import records as r
from floeflow.column.physics import TINY, jit
from floeflow.column.ponds.ponds import pond_cover
from floeflow.column.shortwave.optics import (
    BANDS,
    DRAINED,
    ICE_ASYMMETRY,
    INSIDE,
    OCEAN_ALBEDO,
    POND_INSIDE,
    POND_SURFACE,
    WATER_EXTINCTION,
    grain_place,
    ice_scattering,
    snow_grains,
    snow_optics,
)
from floeflow.column.shortwave.scattering import (
    LEAST_LIGHT,
    LOWEST_SUN,
    add_up,
    copy_layer,
    mix_medium,
    pass_down,
    refract,
    refracted,
    scatter,
)

if TYPE_CHECKING:
    from floeflow.column.physics import Physics
    from floeflow.column.records import Column, Thickness
    from floeflow.column.shortwave.scattering import Rays
    from floeflow.column.thermodynamics.profile import Profile

BARE, SNOW, POND = range(3)
SNOW_SKIN, ICE_SKIN = 0.04, 0.05  # most of what is the scattering surface (m)
DEEP_POND = 0.2  # m, from which on the ice below a pond has properties of its own
DRAINED_SHARE = 0.25  # of the ice's thickness, from the top, that is drained


# Rows of media: bare ice (skin, drained, inside, drained in part) in each band, then what a band is
# mixed anew for.
IN_PART = 3
ICE_MEDIA = 4 * BANDS
WATER = ICE_MEDIA  # or snow
BOTTOM = WATER + 1  # the lowest ice layer with its algae
PONDED = BOTTOM + 1  # ice under ponds: skin, drained, inside, drained in part
MEDIA = PONDED + 4


class Surface(NamedTuple):
    """One kind of surface of a category, and what light finds under it.

    Parameters
    ----------
    kind : int
        ``BARE``, ``SNOW`` or ``POND``.
    share : float
        Of the ice.
    ice, snow, pond : float
        Thickness of ice and snow, depth of the pond (m).
    temperature : float
        Of ice or snow (degC).
    """

    kind: int
    share: float
    ice: float
    snow: float
    pond: float
    temperature: float


@jit
def ice_media(media: np.ndarray, layers: int, p: Physics) -> None:
    """Set the media of bare ice, which no category changes.

    Parameters
    ----------
    media : ndarray
        Media of `Rays`, set, (number, MEDIUM).
    layers : int
        Number of ice layers.
    p : Physics
        Constants.
    """
    for place in range(4):
        for band in range(BANDS):
            scatters, absorbs = bare_ice(place, layers, band, p)
            mix_ice(media, place * BANDS + band, scatters, absorbs)


@jit
def bare_ice(place: int, layers: int, band: int, p: Physics) -> tuple[float, ...]:
    """Scattering and absorption (1/m) of skin, drained ice, ice inside, and of what is both.

    Parameters
    ----------
    place : int
        Sort of ice: SURFACE, DRAINED, INSIDE or IN_PART, which is drained in part.
    layers : int
        Number of ice layers.
    band : int
        Spectral band: 0 visible, then infrared.
    p : Physics
        Constants.

    Returns
    -------
    tuple of float
        Scattering and absorption coefficients (1/m).
    """
    if place < IN_PART:
        return ice_scattering(place, band, p)
    share = (DRAINED_SHARE * layers) % 1.0
    drained, absorbs = ice_scattering(DRAINED, band, p)
    inside, absorbs_inside = ice_scattering(INSIDE, band, p)
    scatters = share * drained + (1.0 - share) * inside
    return scatters, share * absorbs + (1.0 - share) * absorbs_inside


@jit
def mix_ice(media: np.ndarray, m: int, scatters: float, absorbs: float) -> None:
    """Set a medium of ice by its scattering and absorption (1/m).

    Parameters
    ----------
    media : ndarray
        Media of `Rays`, set, (number, MEDIUM).
    m : int
        Row of the medium.
    scatters : float
        Coefficients (1/m).
    absorbs : float
        Coefficients (1/m).
    """
    extinction = scatters + absorbs
    mix_medium(media, m, extinction, scatters / extinction, ICE_ASYMMETRY)


@jit
def absorb_scattered(
    c: Column,
    n: int,
    thickness: Thickness,
    w: Profile,
    rays: Rays,
    f: np.ndarray,
    dt: float,
    p: Physics,
) -> tuple[float, ...]:
    """Light absorbed at the surface and passed to the ocean (W/m2); fills ``w.source``.

    Parameters
    ----------
    c : Column
        Surface temperature, ponds; snow on lids is brought up to date.
    n : int
        Category.
    thickness : Thickness
        Of ice and snow.
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

    Returns
    -------
    surface, through : float
        Absorbed at the surface, and passed to the ocean, W/m2 of ice: means over its bare, snowy
        and ponded parts.
    """
    w.source[:] = 0.0
    first = c.snow_enthalpy.shape[1]
    ice, snow = thickness
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
            surface = Surface(kind, share, ice, snow, pond, c.surface[n])
            absorbed, below = shine(surface, first, w, rays, f, p)
            light += absorbed
            through += below
    return light, through


@jit
def shine(
    surface: Surface, first: int, w: Profile, rays: Rays, f: np.ndarray, p: Physics
) -> tuple[float, ...]:
    """Light absorbed at and passed by one kind of surface; adds to ``w.source``, all by share.

    Parameters
    ----------
    surface : Surface
        The kind of surface.
    first : int
        Number of snow layers.
    w : Profile
        Its source is added to (W/m2).
    rays : Rays
        Work arrays.
    f : ndarray
        Forcing, (len(FORCING),).
    p : Physics
        Constants.

    Returns
    -------
    tuple of float
        Absorbed at the surface, and passed to the sea (W/m2 of the category).
    """
    kind, share = surface.kind, surface.share
    layers = w.source.size - first
    grain = (0.0, 0, 0.0)
    if kind == SNOW:
        radius = snow_grains(surface.temperature, p) * (1.0 - 0.2 * f[r.DIFFUSE_INFRARED])
        row, above = grain_place(radius)
        grain = (radius, row, above)
    rays.net[:] = 0.0
    near = 0.67 + 0.11 * f[r.DIFFUSE_INFRARED]
    sun = max(f[r.SUN_HEIGHT], LOWEST_SUN)
    inner = refracted(sun)
    for band in range(BANDS):
        if band == 0:
            light, diffuse = f[r.VISIBLE], f[r.DIFFUSE_VISIBLE]
        else:
            light, diffuse = f[r.INFRARED], f[r.DIFFUSE_INFRARED]
            light *= near if band == 1 else 1.0 - near
        if kind == SNOW:
            extinction, albedo, asymmetry = snow_optics(grain[0], grain[1], grain[2], band, p)
            mix_medium(rays.media, WATER, extinction, albedo, asymmetry)
        elif kind == POND:
            mix_medium(rays.media, WATER, WATER_EXTINCTION[band], 0.0, 0.0)
            mix_ponded(rays.media, surface.pond, layers, band, p)
        last = shine_band(surface, band, first, layers, sun, inner, rays, p)
        ground = OCEAN_ALBEDO[band] if last == first + layers + 2 else 0.0
        start = first + 1 if kind == BARE else 0
        add_up(rays, start, last, ground, light * (1.0 - diffuse), light * diffuse)

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
def mix_ponded(media: np.ndarray, pond: float, layers: int, band: int, p: Physics) -> None:
    """Set the media of ice under a pond (m): that of bare ice where it is shallow (eq. 13).

    Parameters
    ----------
    media : ndarray
        Media of `Rays`; rows from PONDED on are set, (number, MEDIUM).
    pond : float
        Depth of the pond (m).
    layers : int
        Number of ice layers.
    band : int
        Spectral band: 0 visible, then infrared.
    p : Physics
        Constants.
    """
    wet = min(pond / DEEP_POND, 1.0)
    for place in range(4):
        deep, absorbs = ice_scattering(POND_SURFACE if place == 0 else POND_INSIDE, band, p)
        bare, _ = bare_ice(place, layers, band, p)
        if place == DRAINED and not p.drained_by_depth:
            bare *= DRAINED_SHARE * layers
        mix_ice(media, PONDED + place, bare + (deep - bare) * wet, absorbs)


@jit
def drained_share(place: int, layers: int, p: Physics) -> float:
    """Share of a layer, counted from 1 below the skin, that is drained.

    Parameters
    ----------
    place : int
        Number of the layer, from 1 below the skin.
    layers : int
        Number of ice layers.
    p : Physics
        Constants.

    Returns
    -------
    float
        Between 0 and 1.
    """
    if not p.drained_by_depth:
        return 1.0 if place == 1 else 0.0
    return min(max(DRAINED_SHARE * layers - (place - 1), 0.0), 1.0)


@jit
def sort_of(place: int, layers: int, p: Physics) -> int:
    """Sort of ice of the skin (0) and of the layers below it.

    Parameters
    ----------
    place : int
        Number of the layer; 0 is the skin.
    layers : int
        Number of ice layers.
    p : Physics
        Constants.

    Returns
    -------
    int
        SURFACE, DRAINED, INSIDE or IN_PART.
    """
    if place == 0:
        return 0
    share = drained_share(place, layers, p)
    if share >= 1.0:
        return DRAINED
    return IN_PART if share > 0.0 else INSIDE


@jit
def shine_band(
    surface: Surface,
    band: int,
    first: int,
    layers: int,
    sun: float,
    inner: float,
    rays: Rays,
    p: Physics,
) -> int:
    """Light of one band through the layers; the interface from which on nothing was looked at.

    From the top: the scattering surface of the snow, the rest of its first layer, its other layers
    (or as many of pond water); then those of the ice likewise (eqs. 11 and 12).

    Parameters
    ----------
    surface : Surface
        The kind of surface.
    band : int
        Of the light.
    first, layers : int
        Number of snow layers and of ice layers.
    sun, inner : float
        Cosine of the beam's direction in the air, and in water or ice.
    rays : Rays
        Work arrays; what layers and interfaces reflect and transmit is written.
    p : Physics
        Constants.

    Returns
    -------
    int
        Index from the top, 0 or more; properties of layers below it are not written.
    """
    kind, ice, snow, pond = surface.kind, surface.ice, surface.snow, surface.pond
    start = first + 1 if kind == BARE else 0
    mirror = 0 if kind == POND else first + 2
    end = first + layers + 2
    rays.direct[start] = rays.total[start] = rays.diffuse[start] = 1.0
    rays.back_above[start] = 0.0
    snow_layer, ice_layer = snow / max(first, 1), ice / layers
    snow_skin = min(SNOW_SKIN, 0.5 * snow_layer)
    ice_skin = min(min(ICE_SKIN, ice / 30.0), 0.5 * ice_layer)
    water = pond / (first + 1.0)
    medium, thick = -1, -1.0
    for k in range(start, end):
        if rays.total[k] <= LEAST_LIGHT:
            return k
        medium_before, thick_before = medium, thick
        if k <= first:
            medium = WATER
            thick = snow_skin if k == 0 else snow_layer - (snow_skin if k == 1 else 0.0)
            if kind == POND:
                thick = water
        else:
            place = k - first - 1
            thick = ice_skin if place == 0 else ice_layer - (ice_skin if place == 1 else 0.0)
            sort = sort_of(place, layers, p)
            if kind == POND:
                medium = PONDED + sort
            elif place == layers and sort != IN_PART:
                medium = INSIDE * BANDS + band
                if band == 0:
                    # Algae absorb the same however thick the layer is.
                    scatters, absorbs = ice_scattering(INSIDE, band, p)
                    mix_ice(rays.media, BOTTOM, scatters, absorbs + 0.5 * p.algae / thick)
                    medium = BOTTOM
            else:
                medium = sort * BANDS + band
                if sort == DRAINED and not p.drained_by_depth:
                    thick *= DRAINED_SHARE * layers
        if medium == medium_before and thick == thick_before and k - 1 != mirror and k != mirror:
            copy_layer(rays, k)
        else:
            scatter(rays, k, medium, thick, sun if k < mirror else inner)
            if k == mirror:
                refract(rays, k, sun, inner)
        pass_down(rays, k)
    return end
