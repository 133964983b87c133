# SPDX-License-Identifier: GPL-2.0-or-later
"""Scenes whose ice has layers and thickness categories, through the real pipeline."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from floeflow.forcings.window import window_forcing
from floeflow.scene import load_scene
from floeflow.state import read_dataset, read_state
from support.kills import start_over
from support.runner import Place, make_place

pytestmark = pytest.mark.workflow

EFFECTS = ["wind", "ocean_drag", "friction", "thermodynamics", "snow", "shortwave"]
EFFECTS += ["lateral_melt", "frazil", "mixed_layer"]
SMALL = {"packing": {"elements": 60}, "mask": {"land": "mask"}, "time": {"windows": 2}}
SHORT = SMALL | {"time": {"windows": 1}}


def budgets(place: Place) -> dict[str, dict]:
    """Budgets of the run by name."""
    numbers = json.loads((place.results() / "diagnostics.json").read_text())
    return {budget["name"]: budget for budget in numbers["budgets"]}


def test_bl99_in_five_categories(place: Place, tmp_path: Path):
    column = {"scheme": "bl99", "categories": 5, "layers": 4}
    scene = place.scene(**SMALL, column=column, effects=EFFECTS)
    done = place.run(scene, ranks=1)
    assert done.returncode == 0, done.stdout
    first, last = (read_state(place.results() / f"state/{w:04d}.nc") for w in (0, 2))
    assert last["ice_enthalpy"].shape[1:] == (5, 4) and "ice_salinity" not in last
    mobile = last["type"].values == 1
    # Where water froze there are new elements, whose ids are the highest.
    old = first["id"].values
    stayed = np.isin(last["id"].values, old)
    was, now = first["ice_enthalpy"].values, last["ice_enthalpy"].values
    assert (now[stayed] != was[np.isin(old, last["id"].values)]).any()
    # Leads have frozen: thin ice beside the thick.
    assert (last["ice_fraction"].values[mobile, 0] > 0).any()
    found = budgets(place)
    for name in ("ice_volume", "snow_volume", "column_energy", "column_water"):
        assert found[name]["verdict"] == "closed", found[name]
    assert "column_salt" not in found
    # As two jobs the windows give the same bits, whatever the layers hold.
    apart = make_place(tmp_path / "apart", like=place)
    start_over(apart)
    scene = apart.scene(**SMALL, column=column, effects=EFFECTS, workflow={"windows_per_job": 1})
    done = apart.run(scene, "results/smoke/state/0002.nc", ranks=1)
    assert done.returncode == 0, done.stdout
    again = read_state(apart.results() / "state/0002.nc")
    for name in last.variables:
        np.testing.assert_array_equal(again[name], last[name], err_msg=str(name))


def test_ice_alone_has_no_snow_no_sun_and_no_sea(place: Place):
    bare = ["wind", "thermodynamics"]
    scene = place.scene(**SHORT, column={"scheme": "bl99"}, effects=bare)
    done = place.run(scene, ranks=1)
    assert done.returncode == 0, done.stdout
    state = read_state(place.results() / "state/0001.nc")
    for name in ("snow_volume", "snow_enthalpy", "sea_temperature", "pending_freeze"):
        assert name not in state
    forcing = window_forcing(load_scene(scene), 1, place.folder)
    assert "snowfall" not in forcing and "shortwave_down" not in forcing
    series = read_dataset(place.results() / "series/0001.nc")
    for word in ("snow", "new_ice", "lateral"):
        assert not [name for name in series if word in str(name)], word
    assert "Snow volume" not in (place.results() / "report.html").read_text()
