# SPDX-License-Identifier: GPL-2.0-or-later
"""Members of an ensemble: run once, kept in files, with a fault as a result."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from floeflow.analysis.studies import ensemble_run
from floeflow.analysis.studies.ensemble_plan import AGAIN, BASE_MEMBERS, MEMBERS, PARTING
from floeflow.analysis.studies.ensemble_run import distance, run_members, with_stress
from floeflow.analysis.studies.variants import BASE, Variant
from floeflow.core.errors import FloeError
from floeflow.coupling.chunk import Chunk
from floeflow.scene import load_scene

SMOKE = Path(__file__).parents[3] / "config/scenes/smoke.yaml"


class Runs:
    """Stands for LIGGGHTS: counts runs, and makes ends of them that follow the wind's stress."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, usual: float) -> None:
        self.usual, self.ran, self.fails = usual, [], ""
        for name in ("run_chunk", "window_seconds", "read_member", "fixed_hashes"):
            monkeypatch.setattr(ensemble_run, name, getattr(self, name))
        monkeypatch.setattr(ensemble_run, "run_statistics", self.run_statistics)
        monkeypatch.setattr(ensemble_run, "totals", lambda state: {"volume": 1.0, "area": 0.5})

    def run_chunk(self, chunk: Chunk) -> int:
        chunk.folder.mkdir(parents=True, exist_ok=True)
        self.ran.append(chunk)
        if self.fails and self.fails in str(chunk.folder):
            raise FloeError("Element 3 left the box")
        return len(chunk.windows)

    def window_seconds(self, chunk: Chunk) -> float:
        return float(len(chunk.windows))

    def fixed_hashes(self, chunk: Chunk) -> dict[str, str]:
        return {"library": chunk.library}

    def read_member(self, chunk: Chunk) -> tuple[xr.Dataset, list[xr.Dataset], xr.Dataset]:
        factor = chunk.scene.dynamics.air_drag / self.usual
        first = xr.Dataset(
            {name: ("element", np.zeros(3)) for name in ("x", "y", "u", "area")}
            | {"id": ("element", np.arange(3)), "type": ("element", np.ones(3, dtype=int))},
            attrs={"time": 0.0},
        )
        last = first.assign(x=first["x"] + 1e3 * factor, area=first["area"] + 1.0)
        return first, [last.assign_attrs(time=1.0)], xr.Dataset()

    def run_statistics(self, domain: Any, first: Any, last: xr.Dataset, series: Any) -> Any:
        return {"ridged": float(last["x"][0])}, np.array([[[0.1, np.nan]], [[0.0, np.nan]]])


@pytest.fixture
def chunk(tmp_path: Path) -> Chunk:
    folder, windows = tmp_path / "run", ("0001", "0002", "0003")
    return Chunk(load_scene(SMOKE), folder, windows, tmp_path / "0.nc", tmp_path / "p.so", 1)


@pytest.fixture
def runs(monkeypatch: pytest.MonkeyPatch, chunk: Chunk) -> Runs:
    return Runs(monkeypatch, chunk.scene.dynamics.air_drag)


def test_a_base_has_its_members_a_clock_before_each_and_runs_that_part(chunk: Chunk, runs: Runs):
    record = run_members(Variant(BASE), chunk, None)
    assert [member["statistics"]["ridged"] for member in record["members"][:3]] == pytest.approx(
        [1000.0, 999.0, 1001.0]
    )
    assert len(record["members"]) == BASE_MEMBERS
    assert all(m["cpu_seconds"] == 3.0 and m["clock_seconds"] == 1.0 for m in record["members"])
    # A box without ice is none in JSON, which knows no NaN.
    assert record["members"][0]["drift"] == [[[0.1, None]], [[0.0, None]]]
    assert record["parting"]["apart"]["0.001"] == pytest.approx([1.0])
    clocks = [each for each in runs.ran if each.windows == ("0001",)]
    assert len(clocks) == BASE_MEMBERS + 1
    assert len(runs.ran) == len(clocks) + BASE_MEMBERS + len(PARTING) + 1


def test_finished_members_are_kept_until_what_made_them_changes(chunk: Chunk, runs: Runs):
    first = run_members(Variant(BASE), chunk, None)
    runs.ran.clear()
    assert run_members(Variant(BASE), chunk, None) == first
    members = [each for each in runs.ran if "member-" in str(each.folder)]
    assert not members
    (chunk.folder / "members/member-1.json").unlink()
    run_members(Variant(BASE), chunk, None)
    members = [each for each in runs.ran if "member-" in str(each.folder)]
    assert [each.folder.name for each in members] == ["member-1"]
    runs.ran.clear()
    run_members(Variant(BASE), replace(chunk, library="other"), None)
    assert len([each for each in runs.ran if "member-" in str(each.folder)]) == BASE_MEMBERS


def test_a_failed_member_is_a_result_but_of_the_scene_itself_a_fault(chunk: Chunk, runs: Runs):
    runs.fails = "member-1"
    said = "the scene itself does not run: Element 3 left the box"
    with pytest.raises(FloeError, match=said):
        run_members(Variant(BASE), chunk, None)
    runs.fails = ""
    base = run_members(Variant(BASE), chunk, None)
    (chunk.folder / "scene.yaml").write_text(chunk.scene.model_dump_json())
    runs.fails = "other/members/member-2"
    other = replace(chunk, folder=chunk.folder.parent / "other")
    record = run_members(Variant("softness-2"), other, base)
    assert [member["fault"] for member in record["members"]] == ["", "", "Element 3 left the box"]
    assert len(record["members"]) == MEMBERS and "parting" not in record
    # The scene with other members is the scene too: without it nothing tells what chance does.
    with pytest.raises(FloeError, match=said):
        run_members(Variant(AGAIN), other, base)


def test_ice_faster_than_any_is_a_fault(chunk: Chunk, runs: Runs, monkeypatch: pytest.MonkeyPatch):
    usual = runs.read_member

    def too_fast(member: Chunk) -> tuple[xr.Dataset, list[xr.Dataset], xr.Dataset]:
        first, (last,), series = usual(member)
        return first, [last.assign(u=last["u"] + 7.0)], series

    monkeypatch.setattr(ensemble_run, "read_member", too_fast)
    with pytest.raises(FloeError, match="the ice moves at 7 m/s"):
        run_members(Variant(BASE), chunk, None)


def test_stress_is_the_only_change_and_distance_is_between_the_same_elements(chunk: Chunk):
    scene = with_stress(chunk.scene, 1.001)
    assert scene.dynamics.air_drag == pytest.approx(1.001 * chunk.scene.dynamics.air_drag)
    assert scene.model_copy(update={"dynamics": chunk.scene.dynamics}) == chunk.scene
    data = {"x": [0.0, 1.0, 5.0], "y": [0.0, 0.0, 0.0], "area": [1.0, 1.0, 1.0], "id": [1, 2, 9]}
    one = xr.Dataset({name: ("element", np.array(values)) for name, values in data.items()})
    two = one.assign(x=one["x"] + 3.0, y=one["y"] + 4.0).isel(element=[0, 1])
    assert distance(one, two) == pytest.approx(5.0)
