# SPDX-License-Identifier: GPL-2.0-or-later
"""Time axes as files spell them: dates, time zones, single precision, bounds."""

from __future__ import annotations

from datetime import datetime

import numpy as np
import pytest
import xarray as xr

from floeflow.core import cf_reading as cf
from floeflow.core import times
from floeflow.core.errors import FloeError

START = datetime(2000, 1, 2)


def seconds(values: np.ndarray, units: str) -> list[float]:
    axis = cf.Variable("time", ("time",), values.shape, {"units": units})
    return list(times.seconds_since(values, axis, START, "f.nc"))


@pytest.mark.parametrize(
    ("units", "value", "right"),
    [
        ("days since 2000-01-01", 1.0, 0.0),
        ("days since 2000-01-01T00:00:00Z", 1.5, 43200.0),
        ("days since 2000-01-01T12Z", 1.0, 43200.0),
        ("hours since 2000-1-1 12:00", 12.0, 0.0),
        ("hours since 2000-01-01 00:00:0.0", 25.0, 3600.0),
        ("seconds since 2000-01-02 00:00:00 UTC", 7.0, 7.0),
        ("hours since 2000-01-02 00:00:00 +02:00", 2.0, 0.0),
        ("hours since 2000-01-02 00:00:00 -0330", 0.0, 12600.0),
        ("days since 20000101", 1.0, 0.0),
        ("days since 2000/01/01", 1.25, 21600.0),
        ("days since 2000", 1.0, 0.0),
        ("day as %Y%m%d.%f", 20000102.25, 21600.0),
    ],
)
def test_dates(units: str, value: float, right: float) -> None:
    assert seconds(np.array([value]), units) == [right]


@pytest.mark.parametrize("units", ["days since yesterday", "fortnights since 2000-01-01", "days"])
def test_what_is_no_date(units: str) -> None:
    with pytest.raises(FloeError, match="time variable 'time' with units .* cannot be read"):
        seconds(np.array([1.0]), units)


def test_days_in_single_precision_are_on_their_hours() -> None:
    hours = np.arange(0.0, 24.0)
    days = ((datetime(2000, 1, 2) - datetime(1900, 1, 1)).days + hours / 24.0).astype(np.float32)
    assert np.abs(days.astype(float) * 24 % 1).max() > 0.01
    assert seconds(days, "days since 1900-01-01") == list(3600.0 * hours)


def test_bounds_become_intervals() -> None:
    data = xr.Dataset(
        {"time_bnds": (("time", "nv"), [[0.0, 1.0], [1.0, 2.0]])},
        {"time": ("time", [1.0, 2.0], {"units": "days since 2000-01-02", "bounds": "time_bnds"})},
    )
    stamps, bounds = times.axis_seconds(data, cf.variables_of(data), "time", START, "f.nc")
    assert list(stamps) == [86400.0, 172800.0] and bounds is not None
    assert [list(side) for side in bounds] == [[0.0, 86400.0], [86400.0, 172800.0]]
