# SPDX-License-Identifier: GPL-2.0-or-later
"""Sums and means over time put where they belong: at the middles of their intervals.

Bounds of the time axis say over which interval a record is meant or summed. Where a file has none,
no attribute says over which interval a record is summed. ERA5 sums over the hour that ends at the
record's time, however far apart a file's records are; ERA5-Land sums from midnight on; others sum
from record to record. On hourly records the first and the last are the same; else the scene says
which (``forcing.accumulation``).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from floeflow.core.errors import FloeError

Array = NDArray[np.float64]
Index = NDArray[np.int64]

HOUR, DAY = 3600.0, 86400.0
# Records may be off their hour by this much (s).
SLACK = 1.0


@dataclass(frozen=True)
class Rates:
    """How records make values at times: sums and means those of their intervals.

    Parameters
    ----------
    seconds : ndarray
        Times of the rates: middles of their intervals, and the outer ends, where the first and
        the last hold, (k,).
    record : ndarray
        Record of each rate, (k,).
    goes_on : ndarray of bool
        Whether the record before has to be subtracted, (k,).
    length : ndarray
        Intervals (s) of sums, 1 else, (k,).
    """

    seconds: Array
    record: Index
    goes_on: NDArray[np.bool_]
    length: Array

    @property
    def index(self) -> Index:
        """Records to read, ascending."""
        return np.union1d(self.record, self.record[self.goes_on] - 1)

    def of(self, sums: Array) -> Array:
        """Rates (k, place), per second, from the sums of the records of ``index`` (m, place).

        Parameters
        ----------
        sums : ndarray
            Per record, (m, place).

        Returns
        -------
        ndarray
            Per second, (k, place).
        """
        place = np.searchsorted(self.index, self.record)
        before = np.where(self.goes_on[:, None], sums[np.maximum(place - 1, 0)], 0.0)
        return np.asarray((sums[place] - before) / self.length[:, None])


@dataclass(frozen=True)
class Intervals:
    """Over which time each record is summed or meant.

    Parameters
    ----------
    start, end : ndarray
        Seconds, ascending, (k,).
    record : ndarray
        Record of each, (k,).
    goes_on : ndarray of bool
        Whether the sum of the record before has to be subtracted, (k,).
    """

    start: Array
    end: Array
    record: Index
    goes_on: NDArray[np.bool_]


def rates(
    seconds: Array, span: tuple[float, float], how: str, midnight: float, where: tuple[Path, str]
) -> Rates:
    """Plan the rates that cover a span, from sums over time.

    Parameters
    ----------
    seconds : ndarray
        Times of all records (s), ascending, (n,).
    span : tuple of float
        Start and end (s) that the rates have to cover.
    how : str
        ``hour``: over the hour up to the record; ``step``: since the record before; ``day``: since
        midnight; empty: one record an hour is asked for, which is summed over it.
    midnight : float
        A midnight (UTC) on the axis of ``seconds``.
    where : tuple
        File and variable, for the sentence.

    Returns
    -------
    Rates
        Times (s) of the rates, and from which records each is made.

    Raises
    ------
    FloeError
        Where the intervals are not known, or do not cover the span.
    """
    return plan(intervals(seconds, how, midnight, where), span, where, summed=True)


def intervals(
    seconds: Array, how: str, midnight: float, where: tuple[Path, str], means: bool = False
) -> Intervals:
    """Intervals that end at their records, without bounds in the file; see `rates`.

    ``means`` says that the records are means over their intervals, not sums.

    Parameters
    ----------
    seconds : ndarray
        Times of the records (s), ascending, (records,).
    how : str
        How the file accumulates, as `rates` knows it.
    midnight : float
        Time of a midnight, UTC (s).
    where : tuple of Path and str
        File and variable, for messages.
    means : bool, optional
        Whether the records are means over their intervals.

    Returns
    -------
    Intervals
        Start and end of each interval (s), its record, and whether its sum goes on from the one
        before.

    Raises
    ------
    FloeError
        Where the intervals are not known.
    """
    path, name = where
    what = "mean" if means else "sum"
    if seconds.size < 2:
        raise FloeError(
            f"{path}: '{name}' is a {what} over time of one record only"
            + (" without bounds" if means else ": give its rate")
        )
    before = np.concatenate([[2.0 * seconds[0] - seconds[1]], seconds[:-1]])
    steps = np.diff(seconds)
    if steps.max() > DAY + SLACK:
        # ERA5's monthly means of sums are those of a day, others are sums of the month.
        raise FloeError(
            f"{path}: '{name}' is a {what} over time whose records are further apart than a day: "
            f"over which time is not told, give bounds of its times{'' if means else ', or rates'}"
        )
    if not how:
        if np.abs(steps - HOUR).max() > SLACK:
            raise FloeError(
                f"{path}: '{name}' is a {what} over time and its records are not hourly: say in "
                "forcing.accumulation whether it is over the 'hour', the 'step' or the 'day'"
            )
        how = "hour"
    start = seconds - HOUR if how == "hour" else before
    goes_on, record = np.zeros(seconds.size, dtype=bool), np.arange(seconds.size)
    known = slice(None)
    if how == "day" and not means:
        since = np.mod(before - midnight, DAY)
        goes_on = (since > SLACK) & (since < DAY - SLACK)
        # The first record's rate is known only if its sum began with its own interval.
        known = slice(1, None) if goes_on[0] else known
    elif how != "hour" and np.ptp(steps) > SLACK:
        # How far back the first record reaches is known of equal steps alone.
        known = slice(1, None)
    start, record, goes_on = start[known], record[known], goes_on[known]
    return Intervals(start, seconds[record], record, goes_on)


def plan(
    found: Intervals, span: tuple[float, float], where: tuple[Path, str], summed: bool
) -> Rates:
    """Rates at the middles of intervals, and at their outer ends, that cover a span.

    Parameters
    ----------
    found : Intervals
        Of the records.
    span : tuple of float
        Start and end (s) that the rates have to cover.
    where : tuple
        File and variable, for the sentence.
    summed : bool
        Whether the records are sums, which their intervals' lengths divide; else means.

    Returns
    -------
    Rates
        Times (s) of the rates, from which records each is made, and the seconds to divide by.

    Raises
    ------
    FloeError
        Where the intervals do not cover the span.
    """
    path, name = where
    start, end = found.start, found.end
    nodes = np.concatenate([[start[0]], 0.5 * (start + end), [end[-1]]])
    row = np.concatenate([[0], np.arange(end.size), [end.size - 1]])
    if nodes[0] > span[0] + SLACK or nodes[-1] < span[1] - SLACK:
        what = "sums" if summed else "means"
        raise FloeError(f"{path}: the {what} of '{name}' do not cover the scene from start to end")
    first = max(int(np.searchsorted(nodes, span[0], side="right")) - 1, 0)
    last = min(int(np.searchsorted(nodes, span[1], side="left")), nodes.size - 1)
    kept = row[first : last + 1]
    length = (end - start)[kept] if summed else np.ones(kept.size)
    goes_on = found.goes_on[kept] & summed
    return Rates(nodes[first : last + 1], found.record[kept], goes_on, length)


def instants(seconds: Array, span: tuple[float, float]) -> Rates:
    """The records that bracket a span, each of its own time.

    Parameters
    ----------
    seconds : ndarray
        Times of the records (s), ascending, (records,).
    span : tuple of float
        Start and end (s).

    Returns
    -------
    Rates
        One of each record.
    """
    first = max(int(np.searchsorted(seconds, span[0], side="right")) - 1, 0)
    last = min(int(np.searchsorted(seconds, span[1], side="left")), seconds.size - 1)
    index = np.arange(first, last + 1)
    return Rates(seconds[index], index, np.zeros(index.size, bool), np.ones(index.size))
