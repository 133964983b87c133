# SPDX-License-Identifier: GPL-2.0-or-later
"""Scenes that remap or merge, through the real pipeline: report, budgets, trajectory, meshes."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from floeflow.state import read_dataset, read_state
from support.runner import Place, make_place

pytestmark = pytest.mark.workflow

EFFECTS = ["wind", "ocean_drag", "friction", "bonds", "coast", "ridging", "thermodynamics"]
KEYS = {"remap": {"every": 1}, "merge": {"radius": 0.9}}


@pytest.fixture(scope="module", params=["remap", pytest.param("merge", marks=pytest.mark.slow)])
def remeshed(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Place:
    """Two windows of the smoke scene."""
    remesh = request.param
    place = make_place(tmp_path_factory.mktemp(remesh) / "place")
    changes = {"effects": [*EFFECTS, remesh], "time": {"windows": 2}, remesh: KEYS[remesh]}
    changes |= {"state": {"keep": "all"}, "mask": {"land": "mask"}, "packing": {"elements": 100}}
    done = place.run(place.scene(**changes), "all", "trajectory", "mesh", ranks=1)
    assert done.returncode == 0, done.stdout
    return place


def test_elements_change_and_budgets_close(remeshed: Place) -> None:
    results: Path = remeshed.results()
    states = [read_state(results / f"state/{window:04d}.nc") for window in range(3)]
    same = [np.array_equal(a["id"], b["id"]) for a, b in zip(states, states[1:], strict=False)]
    series = read_dataset(results / "series/0002.nc").drop_dims("sample")
    done = [series.isel(window=place) for place in range(2)]
    kind = "remap_done" if "remap_done" in done[0] else "merge_elements"
    assert sum(float(series[kind]) for series in done) > 0
    assert kind == "remap_done" or not all(same)
    for state, series in zip(states[1:], done, strict=True):
        total = float(state["area"].sum()) + state.attrs["unclaimed_water"]
        assert total == pytest.approx(state.attrs["ocean_area"], rel=1e-12)
        name = kind.split("_")[0]
        moved = abs(float(series["momentum_x_end"])) + abs(float(series["momentum_y_end"]))
        for axis in "xy":
            assert abs(float(series[f"{name}_momentum_{axis}"])) < 1e-12 * moved
    found = json.loads((results / "diagnostics.json").read_text())
    open_ones = [b["name"] for b in found["budgets"] if b["verdict"] == "open"]
    assert not open_ones


def test_report_trajectory_and_meshes_are_there(remeshed: Place) -> None:
    results: Path = remeshed.results()
    assert "elements_displacement" in (results / "report.html").read_text()
    assert read_dataset(results / "trajectory/drift.nc")["drift_distance"].values[-1].max() > 0
    counts = set()
    with (results / "trajectory/elements.lammpsdump").open() as dump:
        for line in dump:
            if line.startswith("ITEM: NUMBER OF ATOMS"):
                counts.add(int(next(dump)))
    assert len(counts) == 1
    assert all((results / f"mesh/{window:04d}.vtu").is_file() for window in range(3))
