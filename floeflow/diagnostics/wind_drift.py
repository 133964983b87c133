# SPDX-License-Identifier: GPL-2.0-or-later
"""Drift of the ice against the wind: complex linear regression, and free drift for comparison.

Velocities are complex numbers, u + i v. The regression u = a w + c (Thorndike & Colony 1982) gives
the wind factor abs(a), the turning angle arg(a) and a mean c that stands for the current; what it
explains is the square of the correlation. Sums are kept, so that windows can be pooled by month.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floeflow.core.constants import AIR_DENSITY, SEAWATER_DENSITY

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class WindSums:
    """Weighted sums over elements; they add up.

    Attributes
    ----------
    weight : float
        Sum of the weights.
    wind, drift : complex
        Sums of wind and drift (m/s times weight).
    cross : complex
        Sum of drift times the conjugate of wind.
    wind_square, drift_square : float
        Sums of the squared moduli.
    """

    weight: float = 0.0
    wind: complex = 0j
    drift: complex = 0j
    cross: complex = 0j
    wind_square: float = 0.0
    drift_square: float = 0.0

    def __add__(self, other: WindSums) -> WindSums:
        return WindSums(
            self.weight + other.weight,
            self.wind + other.wind,
            self.drift + other.drift,
            self.cross + other.cross,
            self.wind_square + other.wind_square,
            self.drift_square + other.drift_square,
        )


@dataclass(frozen=True)
class WindFit:
    """Regression of drift on wind.

    Attributes
    ----------
    factor : float
        Drift over wind; NaN where wind or drift do not vary.
    turning : float
        Angle from wind to drift (rad), counted to the left; on the northern hemisphere ice goes to
        the right, which is negative.
    current : complex
        Drift at no wind (m/s).
    explained : float
        Share of the drift's variance.
    """

    factor: float
    turning: float
    current: complex
    explained: float


def wind_sums(wind: Complex, drift: Complex, weight: Array) -> WindSums:
    """Sums of a regression over elements, each (element,).

    Parameters
    ----------
    wind : Complex
        u + i v (m/s), (element,).
    drift : Complex
        u + i v (m/s), (element,).
    weight : ndarray
        Of each element, (element,).

    Returns
    -------
    WindSums
        Weighted sums; m/s and m2/s2.
    """
    return WindSums(
        float(weight.sum()),
        complex((weight * wind).sum()),
        complex((weight * drift).sum()),
        complex((weight * drift * wind.conj()).sum()),
        float((weight * np.abs(wind) ** 2).sum()),
        float((weight * np.abs(drift) ** 2).sum()),
    )


def wind_fit(sums: WindSums) -> WindFit:
    """Regression from its sums.

    Parameters
    ----------
    sums : WindSums
        Over elements and times.

    Returns
    -------
    WindFit
        Factor (1), angle (rad), current (m/s, complex) and explained share (1); NaN without enough
        data.
    """
    nothing = WindFit(np.nan, np.nan, complex(np.nan, np.nan), np.nan)
    if sums.weight <= 0.0:
        return nothing
    wind, drift = sums.wind / sums.weight, sums.drift / sums.weight
    spread = sums.wind_square / sums.weight - abs(wind) ** 2
    moved = sums.drift_square / sums.weight - abs(drift) ** 2
    # Below round-off of the sums nothing varies.
    if spread <= 1e-12 * sums.wind_square / sums.weight or moved <= 0.0:
        return nothing
    cross = sums.cross / sums.weight - drift * wind.conjugate()
    slope = cross / spread
    explained = abs(cross) ** 2 / (spread * moved)
    return WindFit(abs(slope), float(np.angle(slope)), drift - slope * wind, float(explained))


@dataclass(frozen=True)
class FreeDrift:
    """What the balance of one floe needs.

    Attributes
    ----------
    air_drag, ocean_drag : float
        Drag coefficients; 0 air drag: no wind, 0 ocean drag: no balance.
    turning_angle : float
        Of the ocean's drag (rad), against the drift's own turning.
    coriolis : float
        Coriolis parameter (1/s), 0 where it does not act.
    mass : float
        Of the ice and snow per area (kg/m2).
    """

    air_drag: float
    ocean_drag: float
    turning_angle: float
    coriolis: float
    mass: float


def free_drift(wind: Array, drags: FreeDrift) -> Complex:
    """Steady drift of a floe without neighbours, relative to the water, for a wind along x.

    The balance of docs/theory/forces.md with d/dt = 0: A w² = (c s e^{iφ} + i m f) u,
    s the modulus of u.
    The speed is the root of an increasing function, found by bisection.

    Parameters
    ----------
    wind : ndarray
        Wind speeds (m/s), at least 0.
    drags : FreeDrift
        Coefficients.

    Returns
    -------
    ndarray
        u + i v (m/s), of the same shape; NaN without ocean drag.
    """
    push = AIR_DENSITY * drags.air_drag * np.asarray(wind, dtype=np.float64) ** 2
    water = SEAWATER_DENSITY * drags.ocean_drag
    if water <= 0.0:
        return np.full(push.shape, complex(np.nan, np.nan))
    sign = np.copysign(1.0, drags.coriolis)
    turn = np.exp(1j * sign * drags.turning_angle)
    low, high = np.zeros_like(push), np.sqrt(push / water) + 1e-12
    for _ in range(60):
        middle = 0.5 * (low + high)
        pull = middle * np.abs(water * middle * turn + 1j * drags.mass * drags.coriolis)
        low, high = np.where(pull < push, middle, low), np.where(pull < push, high, middle)
    speed = 0.5 * (low + high)
    resistance = water * speed * turn + 1j * drags.mass * drags.coriolis
    return np.asarray(
        np.divide(push, resistance, out=np.zeros(push.shape, complex), where=resistance != 0)
    )
