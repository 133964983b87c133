# SPDX-License-Identifier: GPL-2.0-or-later
"""Light of one band through layers that scatter: delta-Eddington layers, added up.

Briegleb and Light (2007), Briegleb (1992); numbers of equations are those of
docs/theory/column_light.md. A layer reflects and transmits the sun's beam and diffuse light;
diffuse light is the beam's solution averaged over eight directions, because the two-stream formula
for it may come out negative. Refraction where light enters water or clear ice is a layer of its own
kind on top of that layer.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from floeflow.column.physics import jit, jit_making

Array = NDArray[np.float64]

# Gauss points over the cosine of the direction, and their weights times it, to a sum of 1.
COSINES = np.array(
    [0.9894009, 0.9445750, 0.8656312, 0.7554044, 0.6178762, 0.4580168, 0.2816036, 0.0950125]
)
_WEIGHTS = np.array(
    [0.0271525, 0.0622535, 0.0951585, 0.1246290, 0.1495960, 0.1691565, 0.1826034, 0.1894506]
)
WEIGHTS = COSINES * _WEIGHTS / (COSINES * _WEIGHTS).sum()
PATHS = 1.0 / COSINES
DIRECTIONS = 8
DARKEST = 10.0  # optical path beyond which nothing is counted
LEAST_LIGHT = 1e-3  # share of the light below which deeper layers are not looked at
NOTHING = 1e-11
REFRACTION = 1.310  # of ice, and water too
DIFFUSE_FROM_ABOVE, DIFFUSE_FROM_BELOW = 0.063, 0.455  # what refraction reflects of diffuse light
LOWEST_SUN = 0.01  # cosine
NEAREST = 1e-9  # of the pole of eq. 3


# A medium as a row of numbers: what `mix_medium` makes of extinction, albedo and asymmetry.
EXTINCTION, RATE, U, ODD, EVEN, SLOPE, POLE = range(7)
PLUS, MINUS = 8, 8 + DIRECTIONS  # where coefficients of the directions begin
MEDIUM = 8 + 2 * DIRECTIONS  # numbers


class Rays(NamedTuple):
    """Work arrays of one column of light.

    Parameters
    ----------
    beam_back, beam_on : ndarray
        Of each layer: reflected and transmitted of the beam, the latter with what it scatters.
    beam : ndarray
        Transmitted unscattered.
    back, back_below, on, on_below : ndarray
        Reflected and transmitted of diffuse light from above and from below.
    direct, total, diffuse : ndarray
        At each interface: of the beam, unscattered and in all; of diffuse light from the top.
    back_above : ndarray
        Of diffuse light from below, reflected by all above.
    net : ndarray
        Downward less upward flux at interfaces, summed over bands (W/m2).
    media : ndarray
        Scattering media, (number, MEDIUM).
    """

    beam_back: Array
    beam_on: Array
    beam: Array
    back: Array
    back_below: Array
    on: Array
    on_below: Array
    direct: Array
    total: Array
    diffuse: Array
    back_above: Array
    net: Array
    media: Array


@jit_making
def new_rays(layers: int, media: int) -> Rays:
    """Return work arrays for snow and ice of so many layers, with two more that scatter.

    Parameters
    ----------
    layers : int
        Of snow and ice together.
    media : int
        Number of scattering media.

    Returns
    -------
    Rays
        Zeros.
    """
    m = layers + 3
    return Rays(
        np.zeros(m), np.zeros(m), np.zeros(m), np.zeros(m), np.zeros(m), np.zeros(m),
        np.zeros(m), np.zeros(m), np.zeros(m), np.zeros(m), np.zeros(m), np.zeros(m),
        np.zeros((media, MEDIUM)),
    )  # fmt: skip


@jit
def fading(path: float) -> float:
    """exp(-path) for a path of 0 to 10, in a form that is computed for several at once.

    The fifth power of two of a polynomial on [-0.32, 0]: relative error below 1e-14.

    Parameters
    ----------
    path : float
        Optical path, 0 to 10 (1).

    Returns
    -------
    float
        1.
    """
    x = 0.15625 - path * 0.03125
    xx = x * x
    # Pairs of terms, and pairs of those: short chains of sums that wait for each other.
    low = (1.0 + x) + (0.5 + x * (1.0 / 6.0)) * xx
    high = (1.0 / 24.0 + x * (1.0 / 120.0)) + (1.0 / 720.0 + x * (1.0 / 5040.0)) * xx
    rest = (1.0 / 40320.0 + x * (1.0 / 362880.0)) + xx * (1.0 / 3628800.0)
    four = xx * xx
    y = (low + (high + rest * four) * four) * 0.8553453273074225  # exp(-0.15625)
    y *= y
    y *= y
    y *= y
    y *= y
    return y * y


@jit
def mix_medium(
    media: np.ndarray, m: int, extinction: float, albedo: float, asymmetry: float
) -> None:
    """Set medium m to what scatters so: all of the layer's solution that its depth does not enter.

    Scaled for forward scattering (eq. 1); rates and amplitudes of the two streams (eqs. 2 and 3).

    Parameters
    ----------
    media : ndarray
        Written at m.
    m : int
        Row.
    extinction : float
        1/m.
    albedo, asymmetry : float
        Share that scatters, mean cosine of the scattering angle.
    """
    forward = asymmetry * asymmetry
    squeeze = 1.0 - albedo * forward
    albedo = (1.0 - forward) * albedo / squeeze
    asymmetry = asymmetry / (1.0 + asymmetry)
    absorbed = 1.0 - albedo
    spread = 1.0 - albedo * asymmetry
    rate = math.sqrt(3.0 * absorbed * spread)
    odd = 0.75 * albedo * (1.0 + asymmetry * absorbed)
    even = 0.5 * albedo
    slope = 1.5 * albedo * asymmetry * absorbed
    pole = rate * rate
    row = media[m]
    row[EXTINCTION], row[RATE], row[U] = extinction * squeeze, rate, 1.5 * spread / rate
    row[ODD], row[EVEN], row[SLOPE], row[POLE] = odd, even, slope, pole
    for i in range(DIRECTIONS):
        x = COSINES[i]
        inverse = WEIGHTS[i] / (1.0 - pole * x * x)
        one, two = odd * x * inverse, (even + slope * x * x) * inverse
        row[PLUS + i] = one + two
        row[MINUS + i] = one - two


@jit
def scatter(r: Rays, k: int, m: int, thick: float, sun: float) -> None:
    """Set what layer k of medium m and a thickness (m) reflects and transmits (eqs. 4 and 5).

    ``sun`` is the cosine of the beam's direction in the layer.

    Parameters
    ----------
    r : Rays
        Work arrays; those of the layer are set.
    k : int
        Layer, from the top.
    m : int
        Row of the medium.
    thick : float
        Thickness of the layer (m).
    sun : float
        Cosine of the beam's angle from the vertical in the layer.
    """
    row = r.media[m]
    depth, u = thick * row[EXTINCTION], row[U]
    fades = fading(min(row[RATE] * depth, DARKEST))
    # Both over the same denominator, multiplied by what fades.
    square, more, less = fades * fades, (u + 1.0) * (u + 1.0), (u - 1.0) * (u - 1.0)
    scale = 1.0 / (more - less * square)
    back = (u * u - 1.0) * (1.0 - square) * scale
    on = 4.0 * u * fades * scale

    fade = fading(min(depth / sun, DARKEST))
    gap = 1.0 - row[POLE] * sun * sun
    if abs(gap) < NEAREST:
        gap = NEAREST
    gap = 1.0 / gap
    a, b = row[ODD] * sun * gap, (row[EVEN] + row[SLOPE] * sun * sun) * gap
    r.beam[k] = fade
    r.beam_back[k] = (a + b) * back + (a - b) * (on * fade - 1.0)
    r.beam_on[k] = (a + b) * on + ((a - b) * back - (a + b) + 1.0) * fade
    backs = ons = 0.0
    for i in range(DIRECTIONS):
        t = fading(min(depth * PATHS[i], DARKEST))
        plus, minus = row[PLUS + i], row[MINUS + i]
        backs += plus * back + minus * (on * t - 1.0)
        ons += plus * on + (minus * back - plus + WEIGHTS[i]) * t
    r.back[k] = r.back_below[k] = backs
    r.on[k] = r.on_below[k] = ons


@jit
def copy_layer(r: Rays, k: int) -> None:
    """Layer k is like the one above it.

    Parameters
    ----------
    r : Rays
        Work arrays; those of the layer are set.
    k : int
        Layer, from the top.
    """
    r.beam[k], r.beam_back[k], r.beam_on[k] = r.beam[k - 1], r.beam_back[k - 1], r.beam_on[k - 1]
    r.back[k] = r.back_below[k] = r.back[k - 1]
    r.on[k] = r.on_below[k] = r.on[k - 1]


@jit
def refracted(sun: float) -> float:
    """Cosine of the beam's direction in ice or water (Snell).

    Parameters
    ----------
    sun : float
        Cosine of the beam's zenith angle in air.

    Returns
    -------
    float
        1.
    """
    return math.sqrt(1.0 - (1.0 - sun * sun) / (REFRACTION * REFRACTION))


@jit
def refract(r: Rays, k: int, sun: float, inner: float) -> None:
    """Put a refracting surface on top of layer k (eqs. 6 and 7).

    Parameters
    ----------
    r : Rays
        Work arrays; those of the layer are set.
    k : int
        Layer, from the top.
    sun : float
        Cosine of the beam's angle from the vertical above and below the surface.
    inner : float
        Cosine of the beam's angle from the vertical above and below the surface.
    """
    across, along = sun + REFRACTION * inner, REFRACTION * sun + inner
    r1, r2 = (sun - REFRACTION * inner) / across, (REFRACTION * sun - inner) / along
    t1, t2 = 2.0 * sun / across, 2.0 * sun / along
    reflects = 0.5 * (r1 * r1 + r2 * r2)
    passes = 0.5 * (t1 * t1 + t2 * t2) * REFRACTION * inner / sun
    again = 1.0 / (1.0 - DIFFUSE_FROM_BELOW * r.back[k])
    below = 1.0 - DIFFUSE_FROM_BELOW
    beam_back, back, on = r.beam_back[k], r.back[k], r.on[k]
    r.beam_on[k] = passes * (r.beam_on[k] + beam_back * DIFFUSE_FROM_BELOW * again * on)
    r.beam_back[k] = reflects + passes * beam_back * again * below
    r.back[k] = DIFFUSE_FROM_ABOVE + (1.0 - DIFFUSE_FROM_ABOVE) * back * again * below
    r.back_below[k] += r.on_below[k] * DIFFUSE_FROM_BELOW * again * on
    r.on[k] = on * again * (1.0 - DIFFUSE_FROM_ABOVE)
    r.on_below[k] *= again * below
    r.beam[k] *= passes


@jit
def pass_down(r: Rays, k: int) -> None:
    """Transmission from the top to the interface below layer k (eq. 8).

    Parameters
    ----------
    r : Rays
        Work arrays; those of the interface below the layer are set.
    k : int
        Layer, from the top.
    """
    again = 1.0 / (1.0 - r.back_above[k] * r.back[k])
    scattered = r.total[k] - r.direct[k]
    reflected = r.direct[k] * r.beam_back[k]
    r.direct[k + 1] = r.direct[k] * r.beam[k]
    r.total[k + 1] = (
        r.direct[k] * r.beam_on[k] + (scattered + reflected * r.back_above[k]) * again * r.on[k]
    )
    r.back_above[k + 1] = r.back_below[k] + r.on_below[k] * r.back_above[k] * again * r.on[k]
    r.diffuse[k + 1] = r.diffuse[k] * again * r.on[k]


@jit
def add_up(r: Rays, first: int, last: int, bottom: float, direct: float, diffuse: float) -> None:
    """Add the net fluxes of a band at interfaces first to last (eqs. 9 and 10).

    Parameters
    ----------
    r : Rays
        After `pass_down` from ``first`` to layer ``last - 1``; ``r.net`` is added to.
    first, last : int
        Interface at the top, and at the bottom of what was looked at.
    bottom : float
        Albedo of what lies below.
    direct, diffuse : float
        Light of the band from above (W/m2).
    """
    beam_up = diffuse_up = bottom
    for k in range(last, first - 1, -1):
        if k < last:
            again = 1.0 / (1.0 - r.back_below[k] * diffuse_up)
            scattered = (r.beam_on[k] - r.beam[k]) * diffuse_up
            beam_up = r.beam_back[k] + (r.beam[k] * beam_up + scattered) * again * r.on_below[k]
            diffuse_up = r.back[k] + r.on[k] * diffuse_up * again * r.on_below[k]
        again = 1.0 / (1.0 - r.back_above[k] * diffuse_up)
        beam = r.direct[k] + (r.total[k] - r.direct[k]) * (1.0 - diffuse_up) * again
        beam -= r.direct[k] * beam_up * (1.0 - r.back_above[k]) * again
        other = r.diffuse[k] * (1.0 - diffuse_up) * again
        r.net[k] += direct * beam if beam >= NOTHING else 0.0
        r.net[k] += diffuse * other if other >= NOTHING else 0.0
