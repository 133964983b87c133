# SPDX-License-Identifier: GPL-2.0-or-later
"""The level nearest the surface, by what vertical axes of real products say of themselves."""

from __future__ import annotations

import numpy as np
import pytest

from floeflow.core.errors import FloeError
from floeflow.core.levels import surface

PRESSURE = [1000.0, 925.0, 500.0, 10.0]


@pytest.mark.parametrize(
    ("axis", "attrs", "values", "ocean", "right"),
    [
        ("level", {"units": "hPa"}, PRESSURE, False, 1000.0),
        ("level", {"units": "millibars", "positive": "down"}, PRESSURE[::-1], False, 1000.0),
        ("plev", {"units": "Pa", "standard_name": "air_pressure"}, [1e5, 5e4], False, 1e5),
        ("lev", {"standard_name": "atmosphere_sigma_coordinate"}, [0.02, 0.995], False, 0.995),
        ("hybrid", {"units": "1", "positive": "down"}, [137.0, 136.0, 1.0], False, 137.0),
        ("lev", {"units": "1", "positive": "up"}, [1.0, 2.0, 60.0], False, 1.0),
        ("height", {"units": "m", "positive": "up"}, [100.0, 10.0], False, 10.0),
        ("height", {"units": "km"}, [2.0, 0.01], False, 0.01),
        ("depth", {"units": "m", "positive": "down"}, [0.5, 10.0, 4000.0], True, 0.5),
        ("Z", {"units": "m", "positive": "up"}, [-4000.0, -10.0, -5.0], True, -5.0),
        ("s_rho", {"standard_name": "ocean_s_coordinate_g2"}, [-0.98, -0.5, -0.02], True, -0.02),
        ("lev", {"positive": "up", "units": "1"}, [1.0, 30.0], True, 30.0),
        ("lev", {"positive": "down", "units": "1"}, [1.0, 30.0], True, 1.0),
    ],
)
def test_the_surface_is_found(
    axis: str, attrs: dict[str, str], values: list[float], ocean: bool, right: float
) -> None:
    found = surface(axis, attrs, np.array(values), ocean, "f.nc: variable 'u'")
    assert values[found.index] == right
    assert f"{axis} = {right:g}" in found.said


@pytest.mark.parametrize(("wanted", "right"), [(10.0, 10.0), (2.0, 2.0)])
def test_of_heights_in_one_file_the_one_that_is_wanted_counts(wanted: float, right: float) -> None:
    """Winds belong to 10 m, temperatures to 2 m: neither to the lowest of 0, 2, 10 and 100 m."""
    for factor, units in ((1.0, "m"), (1e-3, "km")):
        values = factor * np.array([0.0, 2.0, 10.0, 100.0])
        found = surface("height", {"units": units}, values, False, "f.nc", wanted)
        assert values[found.index] == factor * right


def test_the_height_above_the_ground_is_told() -> None:
    found = surface("level", {"units": "hPa"}, np.array(PRESSURE), False, "f.nc")
    assert found.said.endswith("about 111 m above the ground")


@pytest.mark.parametrize(
    ("axis", "attrs", "values", "sentence"),
    [
        ("lev", {"units": "1"}, [1.0, 2.0], "does not say which end is the surface"),
        ("lev", {}, [137.0, 1.0], "give it the attribute positive"),
        (
            "level",
            {"units": "hPa"},
            [850.0, 500.0],
            "its lowest level is level = 850 hPa, about",
        ),
        ("level", {"units": "hPa"}, [500.0], "about 59.. m above the ground: no air at the surf"),
        ("height", {"units": "m"}, [1500.0, 3000.0], "about 1500 m above the ground"),
    ],
)
def test_what_is_not_told_is_refused(
    axis: str, attrs: dict[str, str], values: list[float], sentence: str
) -> None:
    with pytest.raises(FloeError, match=sentence) as caught:
        surface(axis, attrs, np.array(values), False, "f.nc: variable 'u'")
    assert str(caught.value).startswith("f.nc: variable 'u'")
