# SPDX-License-Identifier: GPL-2.0-or-later
"""Time axes: CF units and calendars to seconds since the scene's start."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

import netCDF4
import numpy as np
from numpy.typing import ArrayLike, NDArray

from floeflow.core import cf_reading as cf
from floeflow.core.errors import FloeError

Array = NDArray[np.float64]


def window_span(window: int, length: float) -> tuple[float, float]:
    """Start and end of a window (s since the scene's start); the first window is 1."""
    return (window - 1) * length, window * length


def seconds_since(
    values: ArrayLike, variable: cf.Variable, start: datetime, path: str | Path
) -> Array:
    """Times of a file in seconds since the scene's start, in the file's own calendar.

    Raises
    ------
    FloeError
        Where units or calendar make no sense, or a time is missing.
    """
    times: Array = np.atleast_1d(np.ma.filled(np.ma.asarray(values, dtype=float), np.nan))
    if not np.isfinite(times).all():
        raise FloeError(f"{path}: time variable '{variable.name}' has missing values")
    units, calendar = variable.text("units"), variable.text("calendar") or "standard"
    try:
        dates = netCDF4.num2date(times, units, calendar)
        since = f"seconds since {start.isoformat(sep=' ')}"
        # A microsecond is what num2date resolves.
        return np.round(np.asarray(netCDF4.date2num(dates, since, calendar), dtype=float), 6)
    except (ValueError, OverflowError, TypeError) as error:
        raise FloeError(
            f"{path}: time variable '{variable.name}' with units '{units}' and calendar "
            f"'{calendar}' cannot be read: {error}"
        ) from None


def say(start: datetime, seconds: float) -> str:
    """A time of the scene as text, or as seconds where the calendar has none."""
    try:
        date = netCDF4.num2date(
            np.array([seconds]), f"seconds since {start.isoformat(sep=' ')}", "standard"
        )
    except (ValueError, OverflowError):
        return f"{seconds:g} s after the start"
    return str(np.asarray(date)[0])[:19]
