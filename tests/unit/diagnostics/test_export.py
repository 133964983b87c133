# SPDX-License-Identifier: GPL-2.0-or-later
"""Ice that leaves the scene's rectangle: what is inside, and what went through each side."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from floeflow.diagnostics.budgets import exports_of, ice_volume_budgets, total_of
from floeflow.diagnostics.collect import SIDES, side_beyond, stocks
from floeflow.diagnostics.diagnostics import headline
from floeflow.scene.blocks import Domain

DOMAIN = Domain(x_min=-1e5, x_max=1e5, y_min=-2e5, y_max=2e5, spacing=1e5)


def state(x: list[float], y: list[float]) -> xr.Dataset:
    """Four elements of 1, 2, 4 and 8 km2, all ice of 2 m with 0.1 m of snow."""
    area = 1e6 * np.array([1.0, 2.0, 4.0, 8.0])
    deep = {"ice_fraction": 1.0, "ice_volume": 2.0, "snow_volume": 0.1}
    data = {name: (("element", "category"), np.full((4, 1), value)) for name, value in deep.items()}
    places = {"x": ("element", x), "y": ("element", y), "area": ("element", area)}
    return xr.Dataset({**data, **places})


def boundaries() -> xr.Dataset:
    """Three boundaries: all inside, one beyond the left and one beyond the top, one back again."""
    places = [
        ([0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0]),
        ([0.0, -1.1e5, 0.0, 0.0], [0.0, 0.0, 0.0, 2.3e5]),
        ([0.0, -1.1e5, 0.0, 0.0], [0.0, 0.0, 0.0, 1.9e5]),
    ]
    rows = [stocks(state(x, y), True, DOMAIN) for x, y in places]
    return xr.Dataset(
        {name: ("boundary", np.array([row[name] for row in rows])) for name in rows[0]},
        {"boundary": [0, 1, 2]},
    )


def test_sides() -> None:
    x = np.array([0.0, -2e5, 2e5, 0.0, 0.0, 1.5e5])
    y = np.array([0.0, 0.0, 0.0, -3e5, 3e5, 4e5])
    names = ["inside", "left", "right", "bottom", "top", "top"]
    assert [(*SIDES, "inside")[k] for k in side_beyond(x, y, DOMAIN)] == names


def test_what_is_inside_and_what_left() -> None:
    found = boundaries()
    assert list(found["ice_area"]) == [15e6, 5e6, 13e6]
    assert list(total_of(found, "ice_volume")) == [30e6, 30e6, 30e6]
    left = exports_of(found, "ice_area")
    assert set(left) == {"through left side", "through top side"}
    assert list(left["through left side"]) == [-2e6, 0.0]
    assert list(left["through top side"]) == [-8e6, 8e6]


def test_the_budget_closes_with_the_export_and_not_without() -> None:
    found = boundaries()
    scalars = xr.Dataset(
        {name: ("window", np.full(2, 30e6)) for name in ("ice_volume_start", "ice_volume_dynamics")}
        | {"growth_base": ("window", np.zeros(2))},
        {"window": [1, 2]},
    )
    volume = found["ice_volume"].values
    closed = ice_volume_budgets(scalars, volume, exports_of(found, "ice_volume"))[0].summary()
    assert closed["verdict"] == "closed"
    assert closed["terms"]["through left side"] == -4e6
    assert closed["change"] == pytest.approx(-4e6)
    assert ice_volume_budgets(scalars, volume, {})[0].summary()["verdict"] == "open"


def test_the_headline_is_of_what_is_inside() -> None:
    plain = ("boundary_time", "mean_displacement", "largest_displacement")
    counts = ("elements", "coast_elements")
    found = boundaries().assign({name: ("boundary", np.zeros(3)) for name in (*plain, *counts)})
    speeds = ("largest_speed", "drift_speed")
    samples = xr.Dataset({name: ("sample", np.zeros(2)) for name in speeds})
    found["ocean_area"] = found["unclaimed_water"] = ("boundary", np.zeros(3))
    rims = {
        "export_ice_area_left": ("window", np.array([3e6])),
        "inflow_ice_area_top": ("window", np.array([1e6])),
    }
    told = headline(samples, xr.Dataset(rims), found.isel(boundary=[0, 1]), [])
    assert (told["ice_area_start"], told["ice_area_end"]) == (15e6, 5e6)
    # What lies beyond the side, and what the rim took out.
    assert told["ice_area_through_left_side"] == -5e6
    assert told["ice_area_through_top_side"] == -8e6 + 1e6
    assert told["snow_volume_through_top_side"] == pytest.approx(-8e5)
    assert "ice_area_through_right_side" not in told
