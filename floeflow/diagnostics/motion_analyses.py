# SPDX-License-Identifier: GPL-2.0-or-later
"""Analyses of motion that go through a run once, boundary by boundary, and keep sums alone.

Drift against wind, deformation, velocity autocorrelation and the dispersion of pairs. Nothing is
followed across a remap, so lags end there.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from floeflow.diagnostics.deformation import (
    ORDERS,
    Strain,
    box_sizes,
    box_strain,
    moment_sums,
    triangle_strain,
    triangles,
)
from floeflow.diagnostics.followed import Frame, Step, step_between
from floeflow.diagnostics.linear_features import Features, linear_features
from floeflow.diagnostics.wind_drift import WindSums, wind_sums

Array = NDArray[np.float64]
Index = NDArray[np.int64]

# RGPS follows ice over about three days.
INTERVAL = 3 * 86400.0
LAGS = 20
# Elements with at least this share of ice are pack, others loose ice.
PACK = 0.8
KINDS = ("pack", "loose")
WIND_BINS = np.arange(0.0, 31.0, 1.0)
DRIFT_BINS = np.arange(-0.3, 0.9, 0.02)
RATE_BINS = np.logspace(-10.0, -3.0, 57)
# Rates of which there are distributions, at the scale of triangles and of coarse boxes.
RATES = ("divergence", "convergence", "shear")
COARSE = 4.0


class Wind(Protocol):
    """Mean wind of windows at places."""

    # Of so many windows one is looked up.
    every: int

    def at(self, window: int, x: Array, y: Array) -> NDArray[np.complex128]:
        """Mean wind over a window at places (m/s).

        Parameters
        ----------
        window : int
            Number of the window.
        x : ndarray
            Places (m), (n,).
        y : ndarray
            Places (m), (n,).

        Returns
        -------
        ndarray
            u + i v, (n,).
        """


@dataclass
class Motion:
    """Sums over a run.

    Attributes
    ----------
    window : float
        Length of the windows (s).
    windows : int
        Their number.
    remapped : set of int
        Windows at whose end ice was remapped.
    wind : Wind or None
        None without wind.
    spacing : float
        Of the elements (m); set by the first frame.
    sizes : ndarray
        Sides of the boxes (m); set by the first frame.
    winds : list
        For each window that was followed its number and sums by kind of ice.
    drift_counts : ndarray
        Ice area (m2) by wind speed and by drift along the wind, (wind, drift).
    intervals : list
        Ends of the intervals of deformation (s); beside it counts, scales, moments and total
        deformation of the triangles.
    features : list of Features
        Linear features of the intervals.
    rates : ndarray
        Pieces by rate, (scale: triangles and boxes, kind of rate, bin).
    """

    window: float
    windows: int
    remapped: set[int]
    wind: Wind | None
    spacing: float = np.nan
    sizes: Array = field(default_factory=lambda: np.zeros(0))
    winds: list[tuple[int, dict[str, WindSums]]] = field(default_factory=list)
    drift_counts: Array = field(
        default_factory=lambda: np.zeros((WIND_BINS.size - 1, DRIFT_BINS.size - 1))
    )
    intervals: list[float] = field(default_factory=list)
    counts: list[Array] = field(default_factory=list)
    scales: list[Array] = field(default_factory=list)
    moments: list[Array] = field(default_factory=list)
    means: list[tuple[float, float, float]] = field(default_factory=list)
    features: list[Features] = field(default_factory=list)
    rates: Array = field(default_factory=lambda: np.zeros((2, len(RATES), RATE_BINS.size - 1)))
    pairs: Array = field(default_factory=lambda: np.zeros((LAGS + 1, 2)))
    lagged: NDArray[np.complex128] = field(default_factory=lambda: np.zeros((LAGS + 1, 6), complex))
    _frame: Frame | None = None
    _velocities: deque[tuple[Index, NDArray[np.complex128]]] = field(
        default_factory=lambda: deque(maxlen=LAGS + 1)
    )
    _start: Frame | None = None
    _base: Frame | None = None
    _edges: Index = field(default_factory=lambda: np.zeros((0, 2), dtype=np.int64))

    @property
    def interval(self) -> int:
        """Windows of an interval of deformation: the whole run where that is short."""
        return min(max(1, round(INTERVAL / self.window)), self.windows)

    def take(self, frame: Frame) -> None:
        """Go on by one boundary.

        Parameters
        ----------
        frame : Frame
            Of the next boundary.
        """
        before = self._frame
        if before is None:
            self.spacing = frame.spacing
            self.sizes = _sizes(frame)
        self._frame = frame
        if before is None or frame.window in self.remapped or frame.window != before.window + 1:
            self._velocities.clear()
            self._start = frame
            self._set_base(frame)
            return
        step = step_between(before, frame)
        if not step.dx.size:
            return
        velocity = np.asarray((step.dx + 1j * step.dy) / step.seconds, dtype=np.complex128)
        self._take_wind(before, frame, step, velocity)
        self._velocities.append((frame.id[step.after], velocity))
        self._correlate()
        self._disperse(frame)
        assert self._start is not None
        if frame.window - self._start.window == self.interval:
            self._deform(self._start, frame)
            self._start = frame

    def _take_wind(
        self, before: Frame, frame: Frame, step: Step, velocity: NDArray[np.complex128]
    ) -> None:
        if self.wind is None or frame.window % self.wind.every:
            return
        x, y = (
            0.5 * (one[step.before] + two[step.after])
            for one, two in ((before.x, frame.x), (before.y, frame.y))
        )
        wind = self.wind.at(frame.window, x, y)
        share = before.share[step.before]
        weight = before.area[step.before] * share
        packed = share >= PACK
        self.winds.append(
            (
                frame.window,
                {
                    kind: wind_sums(wind[chosen], velocity[chosen], weight[chosen])
                    for kind, chosen in (("pack", packed), ("loose", ~packed))
                },
            )
        )
        speed = np.abs(wind)
        along = np.divide(
            (velocity * wind.conj()).real, speed, out=np.zeros_like(speed), where=speed > 0
        )
        self.drift_counts += np.histogram2d(
            speed, along, bins=(WIND_BINS, DRIFT_BINS), weights=weight
        )[0]

    def _correlate(self) -> None:
        ids, now = self._velocities[-1]
        for lag, (others, then) in enumerate(reversed(self._velocities)):
            _, i, j = np.intersect1d(ids, others, assume_unique=True, return_indices=True)
            a, b = then[j], now[i]
            squares = ((np.abs(a) ** 2).sum(), (np.abs(b) ** 2).sum())
            self.lagged[lag] += (i.size, a.sum(), b.sum(), (b * a.conj()).sum(), *squares)

    def _set_base(self, frame: Frame) -> None:
        self._base = frame
        corners = triangles(frame.x, frame.y, frame.spacing) if frame.id.size else self._edges[:0]
        if corners.shape[1] == 3:
            sides = np.sort(np.concatenate([corners[:, k] for k in ([0, 1], [1, 2], [2, 0])]), 1)
            self._edges = np.unique(sides, axis=0)
        else:
            self._edges = corners

    def _disperse(self, frame: Frame) -> None:
        assert self._base is not None
        lag = frame.window - self._base.window
        if lag > LAGS:
            self._set_base(frame)
            return
        step = step_between(self._base, frame)
        moved = np.full(self._base.id.size, complex(np.nan, np.nan))
        moved[step.before] = step.dx + 1j * step.dy
        parted = np.abs(moved[self._edges[:, 1]] - moved[self._edges[:, 0]]) ** 2
        parted = parted[np.isfinite(parted)]
        self.pairs[lag] += (parted.size, parted.sum())

    def _deform(self, one: Frame, two: Frame) -> None:
        step = step_between(one, two)
        x, y = one.x[step.before], one.y[step.before]
        corners = triangles(x, y, self.spacing)
        if not len(corners):
            return
        fine = triangle_strain(x, y, step.dx / step.seconds, step.dy / step.seconds, corners)
        pieces = [fine, *(box_strain(fine, size) for size in self.sizes)]
        sums = [moment_sums(piece) for piece in pieces]
        self.intervals.append(two.time)
        self.counts.append(np.array([item[0] for item in sums], dtype=float))
        self.scales.append(np.array([item[1] for item in sums]))
        self.moments.append(np.stack([item[2] for item in sums]))
        weight = fine.area / fine.area.sum()
        self.means.append(
            (
                float((weight * fine.total).sum()),
                float((weight * np.abs(fine.divergence)).sum()),
                float((weight * fine.shear).sum()),
            )
        )
        self.features.append(linear_features(fine, corners, (x, y)))
        self.rates[0] += _rates(fine)
        coarse = np.flatnonzero(self.sizes >= COARSE * self.spacing * (1.0 - 1e-9))
        if coarse.size:
            self.rates[1] += _rates(pieces[1 + int(coarse[0])])

    @property
    def moment_array(self) -> Array:
        """Sums of total deformation to each order, (interval, scale, order)."""
        empty = np.zeros((0, 1 + self.sizes.size, ORDERS.size))
        return np.stack(self.moments) if self.moments else empty


def _sizes(frame: Frame) -> Array:
    """Boxes for the ice of a frame."""
    if frame.id.size < 3:
        return np.zeros(0)
    return box_sizes(frame.spacing, float(np.sqrt((frame.area * frame.share).sum())))


def _rates(strain: Strain) -> Array:
    """Pieces by rate, (kind of rate, bin)."""
    opening = strain.divergence
    values = (opening[opening > 0.0], -opening[opening < 0.0], strain.shear)
    return np.stack([np.histogram(each, bins=RATE_BINS)[0] for each in values]).astype(float)


# Lags with fewer pairs than this share of those of the first were followed in calm spells alone.
ENOUGH = 0.25


def correlation(lagged: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Complex correlation of velocities at each lag, NaN where few were followed so long.

    Parameters
    ----------
    lagged : ndarray
        Number, sums of first and second velocities, of second times the conjugate of first, and of
        both squared moduli, (lag, 6).

    Returns
    -------
    ndarray
        Complex, 1 in size at most, (lags,); its angle is that by which the velocity has turned.
    """
    n = lagged[:, 0].real
    out = np.full(len(n), complex(np.nan, np.nan))
    some = n > ENOUGH * n[1:2].max(initial=0.0)
    first, second, cross, square, other = (lagged[some, k] / n[some] for k in range(1, 6))
    spread = np.sqrt(
        np.maximum(square.real - np.abs(first) ** 2, 0.0)
        * np.maximum(other.real - np.abs(second) ** 2, 0.0)
    )
    cross = cross - second * first.conj()
    out[some] = np.divide(
        cross, spread, out=np.full(cross.shape, complex(np.nan, np.nan)), where=spread > 0
    )
    return out
