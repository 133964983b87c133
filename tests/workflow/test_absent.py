# SPDX-License-Identifier: GPL-2.0-or-later
"""What a scene does not name is absent: no rule, no switch, no variable, no figure."""

from __future__ import annotations

import json

import pytest
import xarray as xr
from runner import Place

from floeflow.effects import EFFECTS
from floeflow.state import read_dataset, read_state

pytestmark = pytest.mark.workflow


def test_a_drift_of_free_floes_has_no_bonds_and_no_column(place: Place):
    scene = place.scene(effects=["wind", "ocean_drag"], time={"windows": 1})
    done = place.run(scene)
    assert done.returncode == 0, done.stdout
    results = place.results()
    assert "Bonds: glue lines" not in done.stdout
    assert not (results / "preprocess/bonds.nc").exists()
    state = read_state(results / "state/0001.nc")
    absent = set(EFFECTS["bonds"].state) | set(EFFECTS["thermodynamics"].state)
    assert not absent & set(state.variables)
    forcing = read_dataset(results / "forcing/0001.nc")
    assert set(forcing.data_vars) == {"wind_u", "wind_v", "ocean_u", "ocean_v"}
    series = read_dataset(results / "series/0001.nc")
    for word in ("bond", "fracture", "growth", "snow", "coriolis", "tilt", "friction"):
        assert not [name for name in series if word in str(name)], word
    names = {record["name"] for record in json.loads((results / "cost/0001.json").read_text())}
    assert names == {"setup", "dynamics", "exchange"}
    with xr.open_dataset(results / "grid/0001.nc") as grid:
        assert "sisnthick" not in grid
    log = (results / "log/window/0001.liggghts.log").read_text()
    assert "bonds no friction no" in log
    assert "wind yes" in log and "coriolis no tilt no" in log
    report = (results / "report.html").read_text()
    assert "Bonds broken" not in report and "Snow volume" not in report


def test_a_scene_without_ice_runs_to_its_report(place: Place):
    scene = place.scene(
        # The Norwegian Sea west of Lofoten: open water in any winter.
        domain={"x_min": 2.0e5, "x_max": 6.0e5, "y_min": -2.4e6, "y_max": -2.0e6},
        mask={"land": "mask"},
        time={"windows": 1},
    )
    done = place.run(scene)
    assert done.returncode == 0, done.stdout
    state = read_state(place.results() / "state/0001.nc")
    assert not (state["type"].values == 1).any()
    assert state.attrs["unclaimed_water"] == state.attrs["ocean_area"] > 0
    assert "no ice" in (place.results() / "report.html").read_text()
