# SPDX-License-Identifier: GPL-2.0-or-later
"""Time axes: CF units and calendars to seconds since the scene's start, bounds to intervals."""

from __future__ import annotations

import re
from collections.abc import Mapping
from datetime import datetime
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from floeflow.core import cf_reading as cf
from floeflow.core import coordinate_kinds as kinds
from floeflow.core.errors import FloeError

Array = NDArray[np.float64]

DAY = 86400.0
_REFERENCE = re.compile(
    r"^(?P<year>-?\d{1,4})(?:[-/.](?P<month>\d{1,2})(?:[-/.](?P<day>\d{1,2}))?)?"
    r"(?:[T ]+(?P<hour>\d{1,2})(?::(?P<minute>\d{1,2})(?::(?P<second>\d{1,2}(?:\.\d*)?))?)?)?"
    r"\s*(?P<zone>Z|UTC|GMT|UT|[+-]\d{1,2}(?::?\d{2})?)?$",
    re.IGNORECASE,
)
_PACKED_REFERENCE = re.compile(r"^(\d{4})(\d{2})(\d{2})(.*)$")
_ABSOLUTE = re.compile(r"^days? as %Y%m%d(\.%f)?$")


def window_span(window: int, length: float) -> tuple[float, float]:
    """Start and end of a window (s since the scene's start); the first window is 1.

    Parameters
    ----------
    window : int
        Number of the window, from 1.
    length : float
        Of a window (s).

    Returns
    -------
    tuple of float
        s.
    """
    return (window - 1) * length, window * length


def seconds_since(
    values: ArrayLike, variable: cf.Variable, start: datetime, path: str | Path
) -> Array:
    """Times of a file in seconds since the scene's start, in the file's own calendar.

    Parameters
    ----------
    values : array_like
        As stored.
    variable : cf.Variable
        With units and calendar.
    start : datetime
        Of the scene.
    path : str or Path
        Of the file, for messages.

    Returns
    -------
    ndarray
        s, of the shape of the values.

    Raises
    ------
    FloeError
        Where units or calendar make no sense, or a time is missing.
    """
    stored: Any = np.ma.asarray(values)
    times: Array = np.atleast_1d(np.ma.filled(stored.astype(float), np.nan))
    fill = variable.attrs.get("_FillValue")
    if not np.isfinite(times).all() or (fill is not None and np.isin(times, fill).any()):
        raise FloeError(f"{path}: time variable '{variable.name}' has missing values")
    units, calendar = variable.text("units"), variable.text("calendar").lower() or "standard"
    since = f"seconds since {start.isoformat(sep=' ')}"
    try:
        plain, values_in, shift = _plain_units(units, times)
        dates = netCDF4.num2date(values_in, plain, calendar)
        # A microsecond is what num2date resolves.
        found = np.asarray(netCDF4.date2num(dates, since, calendar), dtype=float) - shift
        return np.round(_snapped(found, stored, units), 6)
    except (ValueError, OverflowError, TypeError) as error:
        raise FloeError(
            f"{path}: time variable '{variable.name}' with units '{units}' and calendar "
            f"'{calendar}' cannot be read: {error}"
        ) from None


def _plain_units(units: str, times: Array) -> tuple[str, Array, float]:
    """Units that cftime reads rightly, times in them, and the reference's time zone (s)."""
    if _ABSOLUTE.match(units):
        whole = np.floor(times)
        days = [datetime.strptime(f"{int(item):08d}", "%Y%m%d") for item in whole]
        origin = datetime(1970, 1, 1)
        since = np.array([(item - origin).days for item in days], dtype=float) + times - whole
        return "days since 1970-01-01 00:00:00", since, 0.0
    unit, word, reference = units.partition(" since ")
    if not word:
        raise ValueError("it says no 'since'")
    packed = _PACKED_REFERENCE.match(reference.strip())
    if packed:
        reference = f"{packed[1]}-{packed[2]}-{packed[3]}{packed[4]}"
    found = _REFERENCE.match(reference.strip())
    if found is None:
        raise ValueError(f"'{reference.strip()}' is not a date")
    part = {name: text or "" for name, text in found.groupdict().items()}
    second = float(part["second"] or 0.0)
    date = (
        f"{int(part['year']):04d}-{int(part['month'] or 1):02d}-{int(part['day'] or 1):02d} "
        f"{int(part['hour'] or 0):02d}:{int(part['minute'] or 0):02d}:{second:09.6f}"
    )
    return f"{unit.strip()} since {date}", times, _zone(part["zone"])


def _zone(text: str) -> float:
    """Seconds by which a time zone is ahead of UTC."""
    if not text or text[0] not in "+-":
        return 0.0
    digits = text[1:].replace(":", "")
    hours, minutes = (digits[:-2], digits[-2:]) if len(digits) > 2 else (digits, "0")
    return (1.0 if text[0] == "+" else -1.0) * (3600.0 * float(hours) + 60.0 * float(minutes))


def _snapped(found: Array, stored: NDArray[Any], units: str) -> Array:
    """Times of single precision on the hour or minute that they were rounded from.

    A day number of 30,000 in single precision is off by minutes.
    """
    unit = kinds.seconds_in(units.partition(" since ")[0])
    if stored.dtype != np.float32 or unit is None:
        return found
    off = unit * float(np.spacing(np.abs(np.atleast_1d(stored)).max()))
    for step in (3600.0, 60.0, 1.0):
        near = step * np.round(found / step)
        if np.abs(near - found).max() <= off:
            return np.asarray(near)
    return found


def axis_seconds(
    data: xr.Dataset,
    variables: Mapping[str, cf.Variable],
    name: str,
    start: datetime,
    path: str | Path,
) -> tuple[Array, tuple[Array, Array] | None]:
    """Times of an axis (s since the scene's start), and its bounds where it has them.

    Parameters
    ----------
    data : xarray.Dataset
        Of the file, not decoded.
    variables : mapping of cf.Variable
        Of the file, by name.
    name : str
        Of the time variable.
    start : datetime
        Of the scene.
    path : str or Path
        Of the file, for messages.

    Returns
    -------
    seconds : ndarray
        s, (nt,).
    bounds : tuple of ndarray or None
        Start and end of each interval (s), (nt,) each; None where there is none or all are empty.

    Raises
    ------
    FloeError
        As `seconds_since`, and where bounds are not two times for each.
    """
    axis = variables[name]
    seconds = seconds_since(data[name].values, axis, start, path)
    bounds = variables.get(axis.text("bounds"))
    if bounds is None:
        return seconds, None
    if bounds.shape != (*axis.shape, 2):
        raise FloeError(f"{path}: bounds '{bounds.name}' of '{name}' are not two for each time")
    # Bounds have the units of their axis where they name none.
    attrs = {**axis.attrs, **bounds.attrs}
    ends = seconds_since(
        data[bounds.name].values.reshape(-1),
        cf.Variable(bounds.name, bounds.dims, bounds.shape, attrs),
        start,
        path,
    ).reshape(-1, 2)
    if (ends[:, 1] < ends[:, 0]).any():
        raise FloeError(f"{path}: bounds '{bounds.name}' of '{name}' end before they start")
    if (ends[:, 1] == ends[:, 0]).all():
        return seconds, None
    return seconds, (ends[:, 0], ends[:, 1])


def first_date(axis: cf.Variable, value: float, path: str | Path) -> datetime:
    """A time of an axis as a date in the axis' own calendar, to the second.

    Parameters
    ----------
    axis : cf.Variable
        With units and calendar.
    value : float
        As stored.
    path : str or Path
        Of the file, for messages.

    Returns
    -------
    datetime.datetime
        Without a time zone.

    Raises
    ------
    FloeError
        As `seconds_since`, and for a day that other calendars lack.
    """
    origin = datetime(1970, 1, 1)
    seconds = seconds_since([value], axis, origin, path)
    calendar = axis.text("calendar").lower() or "standard"
    dates: Any = netCDF4.num2date(
        np.round(seconds), f"seconds since {origin.isoformat(sep=' ')}", calendar
    )
    date = dates[0]
    try:
        return datetime(date.year, date.month, date.day, date.hour, date.minute, date.second)
    except ValueError:
        raise FloeError(
            f"{path}: time variable '{axis.name}' begins on {date}, which no year has"
        ) from None


def say(start: datetime, seconds: float) -> str:
    """A time of the scene as text, or as seconds where the calendar has none.

    Parameters
    ----------
    start : datetime
        Of the scene.
    seconds : float
        Since the start (s).

    Returns
    -------
    str
        Such as ``1981-12-31 00:00:00``.
    """
    try:
        date = netCDF4.num2date(
            np.array([seconds]), f"seconds since {start.isoformat(sep=' ')}", "standard"
        )
    except (ValueError, OverflowError):
        return f"{seconds:g} s after the start"
    return str(np.asarray(date)[0])[:19]
