# SPDX-License-Identifier: GPL-2.0-or-later
"""Stored numbers to values: flags and fills are told apart before anything is scaled."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from floeflow.core.unpack import HOLE, LAND, MISSING, status_flags, unpack

NSIDC = {
    "scale_factor": 0.004,
    "flag_values": np.array([251, 252, 253, 254, 255], np.uint8),
    "flag_meanings": "pole_hole_mask unused coast land missing",
}


def test_flags_of_nsidc_are_no_ice() -> None:
    raw = np.array([[0, 125, 250], [251, 252, 253], [254, 255, 1]], np.uint8)
    found = unpack(raw, NSIDC)
    right = [[0.0, 0.5, 1.0], [np.nan] * 3, [np.nan, np.nan, 0.004]]
    np.testing.assert_allclose(found.values, right, rtol=1e-12)
    assert found.flags[HOLE].sum() == 1 and found.flags[HOLE][1, 0]
    assert found.flags[LAND].sum() == 2
    assert found.flags[MISSING].sum() == 2


def test_signed_bytes_that_are_unsigned() -> None:
    """Climate data records (G02202) in classic NetCDF: flags -5 .. -1 of signed bytes."""
    attrs = {
        "_Unsigned": "true",
        "scale_factor": 0.01,
        "flag_values": np.array([-5, -4, -3, -2, -1], np.int8),
        "flag_meanings": "pole_hole lakes coastal land_mask missing_data",
    }
    raw = np.array([[100, -5, -4, -2, -1]], np.int8)
    found = unpack(raw, attrs)
    np.testing.assert_array_equal(found.values, [[1.0, np.nan, np.nan, np.nan, np.nan]])
    assert list(found.flags[LAND][0]) == [False, False, True, True, False]


@pytest.mark.parametrize(
    ("attrs", "raw", "right"),
    [
        ({"valid_range": np.array([0, 250], np.uint8), "scale_factor": 0.004}, 252, np.nan),
        ({"valid_max": 100.0}, 101, np.nan),
        ({"valid_min": np.float32(0.0), "scale_factor": 0.1, "add_offset": -5.0}, 10, np.nan),
        ({"valid_min": np.float32(0.0), "scale_factor": 0.1, "add_offset": -5.0}, 60, 1.0),
        ({"missing_value": np.array([110, 120])}, 110, np.nan),
        ({"_FillValue": 7}, 7, np.nan),
        ({"floeflow_flags": [(3, "land")]}, 3, np.nan),
        ({"flag_values": "9", "flag_meanings": "open_water"}, 9, 0.0),
    ],
)
def test_bounds_fills_and_flags(attrs: dict[str, Any], raw: int, right: float) -> None:
    found = unpack(np.array([raw], np.uint8), attrs).values
    np.testing.assert_allclose(found, [right], rtol=1e-6)


def test_default_fills_without_attributes() -> None:
    """What NetCDF libraries write where nothing was written, and no attribute tells of."""
    for dtype, fill in (("f4", 9.969209968386869e36), ("f8", 9.969209968386869e36), ("i2", -32767)):
        found = unpack(np.array([fill, 1], dtype), {}).values
        np.testing.assert_array_equal(found, [np.nan, 1.0])


def test_amsr2_land_and_missing_in_whole_per_cent() -> None:
    """AU_SI12: 0-100 per cent, 110 missing, 120 land, told by no attribute."""
    found = unpack(np.array([[0, 100, 110, 120]], np.uint8), {"units": "percent"})
    np.testing.assert_array_equal(found.values, [[0.0, 100.0, np.nan, np.nan]])
    assert list(found.flags[LAND][0]) == [False, False, False, True]
    # A third number beyond 100 is not of that product, and is left to be refused.
    other = unpack(np.array([[0, 110, 120, 130]], np.uint8), {"units": "percent"})
    assert np.isfinite(other.values).all()


def test_status_flags_of_osi_saf() -> None:
    bits = {
        "flag_masks": np.array([1, 2, 4, 8], np.int16),
        "flag_meanings": "land lake open_water_filter land_spill_over",
    }
    found = status_flags(np.array([[0, 1, 2, 4, 8, 5]], np.int16), bits)
    assert list(found[LAND][0]) == [False, True, True, False, False, True]
    values = {"flag_values": "0b 100b", "flag_meanings": "nominal land"}
    assert list(status_flags(np.array([[0, 100]], np.int8), values)[LAND][0]) == [False, True]
