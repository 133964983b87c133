# SPDX-License-Identifier: GPL-2.0-or-later
"""Studies through the real workflow: they run, keep failures, resume, and end in a page."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from floeflow.analysis.studies.measures import KEPT
from floeflow.state import read_dataset
from support.runner import Done, make_place

pytestmark = pytest.mark.workflow

TINY = {
    "effects": ["wind", "ocean_drag"],
    "packing": {"elements": 30},
    "time": {"windows": 1},
    "mask": {"land": "mask"},
}


def run_study(folder: Path, study: str, **changes: object) -> Done:
    place = make_place(folder / "place")
    scene = place.scene(**{**TINY, **changes})
    done = place.run(scene, "--keep-going", study, ranks=1)
    assert done.returncode == 0, done.stdout
    return Done(place, scene, done.stdout)


@pytest.fixture(scope="module")
def ablation(tmp_path_factory: pytest.TempPathFactory) -> Done:
    return run_study(tmp_path_factory.mktemp("ablation"), "ablation")


def record(done: Done, study: str, name: str) -> dict:
    folder = done.place.results(f"smoke+{study}-{name}")
    found: dict = json.loads((folder / "record.json").read_text())
    return found


def test_leave_one_out_tells_what_moves_the_ice(ablation: Done):
    table = json.loads((ablation.results / "ablation/ablation.table.json").read_text())
    rows = {row["name"]: row for row in table["rows"]}
    assert set(rows) == {"wind", "ocean_drag"}
    # Without wind nothing moves but the current; without drag nothing stops.
    assert rows["wind"]["share"] > 0.5
    assert rows["ocean_drag"]["share"] is None or rows["ocean_drag"]["share"] > 0.5
    assert table["floor"] < 1e-3
    page = (ablation.results / "ablation.html").read_text()
    assert '<figure id="ablation">' in page and "ocean_drag" in page


def test_variants_are_scenes_that_share_their_preprocessing(ablation: Done):
    base = ablation.place.results("smoke+ablation-base")
    other = ablation.place.results("smoke+ablation-no_wind")
    for folder in (base, other):
        assert not (folder / "preprocess").exists()
        assert "do not edit" in (folder / "scene.yaml").read_text()
    # A state names its effects, so another set of them has a state 0 of its own.
    assert not (base / "state/0000.nc").exists() and (other / "state/0000.nc").is_file()
    assert record(ablation, "ablation", "no_wind")["effects"] == ["ocean_drag"]
    assert record(ablation, "ablation", "base")["results"]["differences"]["drift"] == 0.0
    for name in ("base", "no_wind"):
        cpu = record(ablation, "ablation", name)["cpu"]
        assert cpu["window"] > 0 and cpu["dynamics"] > 0


def test_an_interrupted_study_goes_on(ablation: Done):
    """A lost record is made anew from its finished windows, and nothing else runs."""
    folder = ablation.place.results("smoke+ablation-no_wind")
    before = json.loads((folder / "record.json").read_text())
    (folder / "record.json").unlink()
    (ablation.results / "ablation.html").unlink()
    done = ablation.place.run(ablation.scene, "ablation", ranks=1)
    assert done.returncode == 0, done.stdout
    assert re.findall(r"Study: (\S+)", done.stdout) == ["smoke+ablation-no_wind"]
    after = json.loads((folder / "record.json").read_text())
    # Windows that were not run again have the times that they had.
    assert after["wall"] == before["wall"] and after["results"] == before["results"]
    assert "window" not in after["cpu"]


@pytest.mark.slow
def test_accuracy_ends_in_orders_and_a_recommendation(tmp_path: Path):
    # So few elements have long steps: samples in between would cut them all to the same.
    done = run_study(tmp_path, "accuracy", dynamics={"samples": 1})
    data = read_dataset(done.results / "accuracy/accuracy.nc")
    settings = {str(name) for name in data["setting"].values}
    assert {"step_share", "softness", "element_size", "together"} <= settings
    norms = [str(name) for name in data["norm"].values]
    stable = data["stable"].values == 1
    for setting in ("step_share", "element_size"):
        rows = stable & (data["setting"].values == setting)
        order = data["level"].values[rows].argsort()
        work = data["element_steps"].values[rows][order]
        assert (work[:-1] > work[1:]).all(), setting
        for norm in KEPT:
            assert (data["error"].values[rows, norms.index(norm)] >= 0).all()
    page = (done.results / "accuracy.html").read_text()
    assert "Cheapest setting for an error" in page and '<figure id="accuracy_drift">' in page
    assert (done.results / "accuracy/figures/accuracy_drift.png").is_file()


@pytest.mark.slow
def test_an_ensemble_ends_in_verdicts_with_intervals(tmp_path: Path):
    done = run_study(tmp_path, "ensemble", dynamics={"samples": 1})
    table = json.loads((done.results / "ensemble/ensemble.table.json").read_text())
    rows = {row["name"]: row for row in table["settings"]}
    assert {"again", "all-fine", "all-coarse", "step_share-2"} <= set(rows)
    again = rows["again"]["changes"]
    # Free drift is not chaotic: stresses that differ by 0.1 % move it by about as much.
    assert again["drift_speed"]["high"] - again["drift_speed"]["low"] < 0.02
    fine, coarse = (rows[f"step_share-{place}"]["cost"]["mean"] for place in (2, 4))
    assert fine > coarse
    page = (done.results / "ensemble.html").read_text()
    assert '<figure id="ensemble">' in page and "not known" in page
    # Finished members are not run again.
    base = done.place.results("smoke+ensemble-base")
    before = json.loads((base / "record.json").read_text())
    (base / "record.json").unlink()
    (done.results / "ensemble.html").unlink()
    again_done = done.place.run(done.scene, "ensemble", ranks=1)
    assert again_done.returncode == 0, again_done.stdout
    assert json.loads((base / "record.json").read_text())["members"] == before["members"]
