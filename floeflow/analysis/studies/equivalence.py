# SPDX-License-Identifier: GPL-2.0-or-later
"""Differences of means with intervals, and what they show: equivalence, difference, or neither.

That no difference was found does not show that there is none. A setting is good to x per cent where
the whole interval of its difference lies within x per cent (Schuirmann 1987); it is not where the
interval lies beyond; else it is not known.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

Array = NDArray[np.float64]

WITHIN, BEYOND, UNKNOWN = "within", "beyond", "not known"
# A sample whose variance exceeds the pooled one by more than chance allows once in a thousand times
# counts with its own; a study compares some hundreds.
ODD = 0.999


@dataclass(frozen=True)
class Interval:
    """An estimate and the ends of its interval."""

    mean: float
    low: float
    high: float

    @property
    def bound(self) -> float:
        """Largest distance from zero that the interval allows."""
        return max(abs(self.low), abs(self.high))

    @property
    def half(self) -> float:
        """Half of its width."""
        return 0.5 * (self.high - self.low)


@dataclass(frozen=True)
class Spread:
    """Variance within samples, pooled over some of them, and its degrees of freedom."""

    variance: float
    freedom: int


def pool(samples: Sequence[Array]) -> Spread:
    """Variance within samples (n,) about their means; of those with two values or more.

    Parameters
    ----------
    samples : sequence of ndarray
        Values of a statistic, by setting, (n,) each.
    """
    some = [sample for sample in samples if len(sample) > 1]
    freedom = sum(len(sample) - 1 for sample in some)
    squares = sum(float(((sample - sample.mean()) ** 2).sum()) for sample in some)
    return Spread(squares / freedom if freedom else math.nan, freedom)


def without(spread: Spread, part: Spread) -> Spread:
    """A pooled variance without that of one of its samples.

    Parameters
    ----------
    spread : Spread
        Pooled variance, and its degrees of freedom.
    part : Spread
        Of the sample that is left out.

    Returns
    -------
    Spread
        NaN without degrees of freedom.
    """
    freedom = spread.freedom - part.freedom
    if freedom <= 0 or not part.freedom:
        return spread if not part.freedom else Spread(math.nan, 0)
    rest = spread.variance * spread.freedom - part.variance * part.freedom
    return Spread(max(rest, 0.0) / freedom, freedom)


def difference(own: Array, base: Array, spread: Spread, confidence: float) -> Interval:
    """Difference of two means with its interval (Student's, of pooled variance).

    Parameters
    ----------
    own, base : ndarray
        Values of the members, (n,) and (m,).
    spread : Spread
        Pooled over all settings that are compared with the base, this one included.
    confidence : float
        Of the two-sided interval, such as 0.95.

    Returns
    -------
    Interval
        Infinite where nothing is known of the variance.
    """
    mean = float(own.mean() - base.mean())
    mine = pool([own])
    others = without(spread, mine)
    used = spread
    if mine.freedom and others.freedom and others.variance > 0.0:
        most = stats.f.ppf(ODD, mine.freedom, others.freedom) * others.variance
        used, spread = (mine, others) if mine.variance > most else (spread, spread)
    if not used.freedom:
        return Interval(mean, -math.inf, math.inf)
    error = math.sqrt(used.variance / len(own) + spread.variance / len(base))
    half = float(stats.t.ppf(0.5 * (1.0 + confidence), used.freedom)) * error
    return Interval(mean, mean - half, mean + half)


def verdict(found: Interval, share: float) -> str:
    """Whether a difference is shown to be within a share, beyond it, or neither.

    Parameters
    ----------
    found : Interval
        Interval of the relative difference.
    share : float
        Relative difference that counts as none.

    Returns
    -------
    str
        ``WITHIN``, ``BEYOND`` or ``UNKNOWN``.
    """
    if found.bound <= share:
        return WITHIN
    if found.low > share or found.high < -share:
        return BEYOND
    return UNKNOWN


def together(verdicts: Sequence[str]) -> str:
    """Verdict on all statistics: within where all are, beyond where one is.

    Parameters
    ----------
    verdicts : sequence of str
        One a statistic: within, beyond or not known.
    """
    if BEYOND in verdicts:
        return BEYOND
    return WITHIN if all(each == WITHIN for each in verdicts) else UNKNOWN
