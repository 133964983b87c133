# SPDX-License-Identifier: GPL-2.0-or-later
"""The first state in one call has the mask that the workflow's rules make."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from floeflow.coupling import first_state
from floeflow.scene import parse_scene
from floeflow.state.schema import check_state


def test_straits_and_the_sea_are_those_of_the_rules(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A strait is open though most of its cells is land; the mixed layer starts from the file."""
    keys = {
        "name": "t",
        "effects": ["wind", "ocean_drag", "bonds", "coast", "thermodynamics", "mixed_layer"],
        "domain": {"x_min": -5e5, "x_max": 5e5, "y_min": -2e6, "y_max": -1e6, "spacing": 1e5},
        "mask": {"concentration": "ice", "water": "sst", "refine": 1},
        "packing": {"elements": 40},
        "sea": {"temperature": "sst"},
    }
    share = np.zeros((10, 10))
    share[4] = 0.9
    land = (share > 0.5).astype(float)
    land[4, 6] = 0.0  # the strait
    fields = {"land_fraction": (("y", "x"), share), "land": (("y", "x"), land)}
    monkeypatch.setattr(first_state, "make_land", lambda _: xr.Dataset(fields))
    scene = parse_scene(json.dumps(keys).encode(), "t")
    made = first_state.first_state(scene, tmp_path)
    np.testing.assert_array_equal(made.mask["land"].values, land)
    assert "sst" in made.mask
    check_state(made.state)
    open_water = made.mask["siconc"].values[:4].mean() < 0.9
    assert open_water and float(made.state["sea_temperature"].max()) > 273.5
