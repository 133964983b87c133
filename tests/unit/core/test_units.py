# SPDX-License-Identifier: GPL-2.0-or-later
"""Units as files spell them, to SI; what is unknown or of another kind stays unknown."""

from __future__ import annotations

import pytest

from floeflow.core.units import COMMON, _by_pint, conversion


@pytest.mark.parametrize(
    "text", ["1", "", "(0 - 1)", "unitless", "none", "0-1", "Fraction", "fractional", "[-]"]
)
def test_shares(text: str) -> None:
    assert conversion(text, "1") == (1.0, 0.0)


@pytest.mark.parametrize(
    ("text", "si", "factor", "offset"),
    [
        ("%", "1", 0.01, 0.0),
        ("percent", "1", 0.01, 0.0),
        ("degK", "K", 1.0, 0.0),
        ("Kelvin", "K", 1.0, 0.0),
        ("degC", "K", 1.0, 273.15),
        ("Celsius", "K", 1.0, 273.15),
        ("Pascals", "Pa", 1.0, 0.0),
        ("hPa", "Pa", 100.0, 0.0),
        ("HPa", "Pa", 100.0, 0.0),
        ("percent (%)", "1", 0.01, 0.0),
        ("millibars", "Pa", 100.0, 0.0),
        ("100 km", "m", 1e5, 0.0),
        ("m s**-1", "m s-1", 1.0, 0.0),
        ("meter second-1", "m s-1", 1.0, 0.0),
        ("ms-1", "m s-1", 1.0, 0.0),
        ("knots", "m s-1", 1852.0 / 3600.0, 0.0),
        ("cm/s", "m s-1", 0.01, 0.0),
        ("W m**-2", "W m-2", 1.0, 0.0),
        ("kg m**-2 s**-1", "kg m-2 s-1", 1.0, 0.0),
        ("kg m-2 day-1", "kg m-2 s-1", 1.0 / 86400.0, 0.0),
        ("g kg-1", "kg kg-1", 1e-3, 0.0),
        ("g/kg", "kg kg-1", 1e-3, 0.0),
    ],
)
def test_spellings(text: str, si: str, factor: float, offset: float) -> None:
    found = conversion(text, si)
    assert found is not None
    assert found == pytest.approx((factor, offset), rel=1e-12)


@pytest.mark.parametrize(
    ("text", "si"),
    [
        ("furlongs", "m s-1"),
        ("K", "Pa"),
        ("c", "m s-1"),
        ("10 degC", "K"),
        ("degrees", "m"),
        ("", "K"),
    ],
)
def test_what_is_no_such_unit(text: str, si: str) -> None:
    assert conversion(text, si) is None


def test_what_is_told_without_pint_is_what_pint_says():
    for (text, si), found in COMMON.items():
        assert conversion(text, si) == found == _by_pint(text, si)
