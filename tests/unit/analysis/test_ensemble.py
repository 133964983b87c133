# SPDX-License-Identifier: GPL-2.0-or-later
"""Ensembles: statistics of boxes, members, and what a table says of settings that are known."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from floeflow.analysis.studies import document
from floeflow.analysis.studies.ensemble_figure import ensemble_figure
from floeflow.analysis.studies.ensemble_page import change_table, per_cent, sentences, setting_table
from floeflow.analysis.studies.ensemble_plan import (
    AGAIN,
    BASE_MEMBERS,
    MEMBERS,
    ensemble_variants,
    nudges,
    seen_settings,
    tried_levels,
)
from floeflow.analysis.studies.ensemble_statistics import (
    Boxes,
    box_deformation,
    box_drift,
    box_sums,
    make_boxes,
    run_statistics,
)
from floeflow.analysis.studies.ensemble_table import (
    Ensemble,
    ensemble_table,
    is_beaten,
    member_values,
    wishes,
)
from floeflow.analysis.studies.equivalence import BEYOND, UNKNOWN, WITHIN, Interval
from floeflow.analysis.studies.variants import BASE
from floeflow.diagnostics.collect import broken_by_motion, displacement, intact, read_series
from floeflow.scene import load_scene
from floeflow.state import read_state
from floeflow.state.schema import MOBILE
from floeflow.state.snapshots import bonded_length, read_snapshots
from support.synthetic import make_run

ROOT = Path(__file__).parents[3]
BOXES = Boxes(0.0, 0.0, 10.0, 4, 3)


def elements(x: np.ndarray, y: np.ndarray, time: float) -> xr.Dataset:
    data = {"x": x, "y": y, "area": np.full(x.size, 25.0), "id": np.arange(x.size)}
    data |= {"type": np.full(x.size, MOBILE)}
    found = xr.Dataset({name: ("element", values) for name, values in data.items()})
    return found.assign_attrs(time=time)


@pytest.fixture
def packed() -> tuple[np.ndarray, np.ndarray]:
    """Elements of 25 m2 that fill the boxes."""
    x, y = np.meshgrid(np.arange(2.5, 40.0, 5.0), np.arange(2.5, 30.0, 5.0))
    return x.ravel(), y.ravel()


def test_boxes_hold_what_is_in_them_and_drop_what_is_outside():
    x, y = np.array([1.0, 11.0, 39.0, -1.0, 41.0]), np.array([1.0, 29.0, 5.0, 5.0, 5.0])
    sums = box_sums(BOXES, x, y, np.array([1.0, 2.0, 4.0, 8.0, 16.0]))
    assert sums.shape == (3, 4) and sums.sum() == 7.0
    assert sums[0, 0] == 1.0 and sums[2, 1] == 2.0 and sums[0, 3] == 4.0


def test_boxes_cover_the_domain_with_six_across_at_least():
    domain = load_scene(ROOT / "config/scenes/smoke.yaml").domain
    boxes = make_boxes(domain)
    assert boxes.width <= 150e3
    assert boxes.nx * boxes.width >= domain.x_max - domain.x_min
    assert min(boxes.nx, boxes.ny) >= 6


def test_a_linear_flow_has_its_gradient_as_deformation(packed):
    """Opening along x and shear, at rates that a text book's formula gives."""
    x, y = packed
    rate, shear, seconds = 1e-6, 2e-6, 1e3
    first = elements(x, y, 0.0)
    last = elements(x + (rate * x + shear * y) * seconds, y, seconds)
    drift = box_drift(BOXES, first, last)
    centre_x = np.array([5.0, 15.0, 25.0, 35.0])[None, :]
    centre_y = np.array([5.0, 15.0, 25.0])[:, None]
    assert drift[0] == pytest.approx(rate * centre_x + shear * centre_y)
    assert drift[1] == pytest.approx(np.zeros((3, 4)), abs=1e-18)
    wanted = math.hypot(rate, math.hypot(rate, shear))
    assert box_deformation(BOXES, drift) == pytest.approx(np.full((1, 2), wanted))


def test_a_box_with_little_ice_counts_for_nothing(packed):
    x, y = packed
    kept = (x > 10.0) | (x < 5.0) & (y < 5.0)  # one of four elements is left in the first box
    first, last = elements(x[kept], y[kept], 0.0), elements(x[kept] + 1.0, y[kept], 1.0)
    drift = box_drift(BOXES, first, last)
    assert np.isnan(drift[:, :, 0]).all() and (drift[0, :, 1:] == 1.0).all()
    assert np.isnan(box_deformation(BOXES, drift)[0, 0])


def test_statistics_of_a_run_count_bonds_and_ridges(tmp_path: Path):
    """A made-up run: bonds that broke, area that ridged, drift, and its totals."""
    run = make_run(tmp_path)
    first, series = read_state(run.state(0)), read_series(run.files.series, run.scene.effects)
    last = list(read_snapshots(run.files.elements))[-1]
    ocean, held = float(first.attrs["ocean_area"]), bonded_length(first).sum()
    joined = xr.merge(series).assign(ridged_area=("window", [0.02 * ocean, 0.01 * ocean, 0.0]))
    found, drift = run_statistics(run.scene.domain, first, last, joined)
    assert found["ridged"] == pytest.approx(0.03)
    assert found["bonded"] == pytest.approx(float(last["bonded_length"].sum()) / held)
    assert found["broken"] == int(broken_by_motion(joined, [1, 2, 3])[-1]) / len(intact(first))
    assert 0.0 < found["broken"] < 1.0 and found["patchiness"] > 0.0
    assert found["volume"] > 0.0 and 0.0 < found["area"] <= 1.0
    moved, step = displacement(first, last)
    fastest = np.hypot(*step.T).max() / float(last.attrs["time"])
    assert 0.0 < np.nanmax(np.hypot(*drift)) <= fastest


def test_members_lie_on_both_sides_and_the_same_for_all_settings():
    base, other, again = nudges(BASE), nudges("softness-2"), nudges(AGAIN)
    assert len(base) == BASE_MEMBERS and len(other) == MEMBERS
    assert base[0] == 1.0 and other == base[:MEMBERS]
    assert np.mean(other) == pytest.approx(1.0, abs=1e-12)
    assert not set(again) & set(base)


def test_each_setting_is_tried_finer_and_coarser():
    scene = load_scene(ROOT / "config/scenes/winter_pack.yaml")
    names = [variant.name for variant in ensemble_variants(scene)]
    assert names[:2] == [BASE, AGAIN] and len(set(names)) == len(names)
    assert not any(name.startswith("grid_transfer") for name in names)
    softness = next(setting for setting in seen_settings(scene) if setting.name == "softness")
    assert tried_levels(softness) == [0.25, 4, 64]
    # Finer elements are in no run that changes all settings.
    fine = next(v for v in ensemble_variants(scene) if v.name == "all-fine")
    assert "packing.elements" not in fine.changes
    assert fine.changes["dynamics.step_share"] < scene.dynamics.step_share


def member(random: np.random.Generator, shift: float, cost: float, **more: float) -> dict:
    """A member whose ridged share is moved by a relative shift."""
    field = random.normal(0.0, 1e-3, (2, 6, 6)) + 0.1 * more.get("drift", 1.0)
    numbers = {"ridged": 0.01 * (1.0 + shift) * (1.0 + random.normal(0.0, 0.005))}
    numbers |= {"volume": 1.05, "area": 0.8}
    pace = math.exp(random.normal(0.0, 0.1))  # of the machine at the time
    return {
        "fault": "",
        "statistics": numbers,
        "start": {"volume": 1.0, "area": 0.8},
        "drift": field.tolist(),
        "cpu_seconds": 10.0 * cost * pace * math.exp(random.normal(0.0, 0.01)),
        "clock_seconds": 2.0 * pace,
    }


@pytest.fixture
def records() -> list[dict]:
    random = np.random.default_rng(3)
    parting = {"time": [86400.0], "drift": [5e3], "apart": {"1e-06": [10.0], "0.001": [900.0]}}

    def record(name: str, count: int, shift: float, cost: float, **more: float) -> dict:
        members = [member(random, shift, cost, **more) for _ in range(count)]
        group = name.partition("-")[0]
        return {"variant": name, "group": group, "label": name, "members": members}

    faulty = record("softness-4", 3, 0.0, 1.0)
    faulty["members"][1] = {"fault": "Element 3 left the box", "clock_seconds": 2.0}
    return [
        record(BASE, 8, 0.0, 1.0) | {"parting": parting},
        record("step-1", 3, 0.1, 0.5),
        record("step-2", 3, 0.0, 0.7),
        record("window-2", 3, 0.0, 0.9, drift=1.3),
        record("layers-2", 3, 0.1, 1.4),
        record(AGAIN, 8, 0.0, 1.0),
        faulty,
    ]


@pytest.fixture
def study(records: list[dict]) -> Ensemble:
    return ensemble_table(records)


def test_changes_and_costs_are_found_within_their_intervals(study: Ensemble):
    rows = {row.name: row for row in study.rows}
    assert study.rows[0].name == AGAIN
    step = rows["step-1"]
    assert step.changes["ridged"].low < 0.1 < step.changes["ridged"].high
    assert step.largest == "ridged"
    assert (step.verdict(0.05), step.verdict(0.2)) == (BEYOND, WITHIN)
    drift = rows["window-2"].changes["drift_speed"]
    assert drift.low < 0.3 < drift.high and rows["window-2"].verdict(0.2) == BEYOND
    for name, cost in (("step-1", 0.5), ("step-2", 0.7), ("layers-2", 1.4), (AGAIN, 1.0)):
        found = rows[name].cost
        assert found.low < cost < found.high and found.high / found.low < 1.2


def test_chance_alone_is_not_told_as_a_change(study: Ensemble):
    again = study.rows[0]
    assert again.verdict(0.05) == WITHIN and again.verdict(study.floor / 2.0) == UNKNOWN
    assert study.floor == again.bound > 0.0


def test_the_clock_takes_the_machines_pace_out(records: list[dict]):
    """All of a setting's members on a machine of half the speed: its cost is the same."""
    before = {row.name: row.cost for row in ensemble_table(records).rows}
    for each in records[1]["members"]:
        each["cpu_seconds"] *= 2.0
        each["clock_seconds"] *= 2.0
    after = {row.name: row.cost for row in ensemble_table(records).rows}
    assert after["step-1"].mean == pytest.approx(before["step-1"].mean)


def test_the_cheapest_setting_that_is_shown_good_is_recommended(study: Ensemble):
    strict, loose = wishes(study, (0.05, 0.2))
    assert strict.row is not None and strict.row.name == "step-2"
    assert loose.row is not None and loose.row.name == "step-1"
    tiny = wishes(study, (study.floor / 10.0,))[0]
    assert tiny.row is None and tiny.members >= 99 * study.members


def test_a_setting_that_fails_is_kept_with_its_sentence(study: Ensemble):
    failed = next(row for row in study.rows if row.name == "softness-4")
    assert failed.fault == "Element 3 left the box" and failed.members == 2
    assert not failed.changes and failed.bound == math.inf
    assert any("left the box" in str(cell) for row in setting_table(study).rows for cell in row)


def test_a_coarser_setting_that_costs_more_and_changes_more_is_beaten(study: Ensemble):
    rows = {row.name: row for row in study.rows}
    assert is_beaten(rows["window-2"], study.rows)
    assert not is_beaten(rows["step-1"], study.rows)
    # What is dearer than the scene shows what that lacks.
    assert not is_beaten(rows["layers-2"], study.rows)


def test_turned_drift_is_told_as_direction(records: list[dict]):
    for each in records[1]["members"]:
        u, v = np.array(each["drift"])
        each["drift"] = [(-v).tolist(), u.tolist()]
    values = member_values(records[1], records[0])
    assert values["drift_direction"] == pytest.approx(np.full(3, math.pi / 2), abs=0.02)
    assert values["drift_speed"] == pytest.approx(np.ones(3), abs=0.02)


def test_the_documents_page_is_made_from_what_the_study_left(
    records: list[dict], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """The page and its figure; nothing where no ensemble has finished."""
    page, images = tmp_path / "ensembles.md", tmp_path / "images"
    images.mkdir()
    monkeypatch.setattr(document, "ENSEMBLE_PAGE", page)
    monkeypatch.setattr(document, "IMAGES", images)
    monkeypatch.chdir(ROOT)
    assert document.write_ensembles(tmp_path) is None
    for each in records:
        folder = tmp_path / f"arctic_week+ensemble-{each['variant']}"
        folder.mkdir()
        (folder / "record.json").write_text(json.dumps(each))
    (tmp_path / "arctic_week").mkdir()
    (tmp_path / "arctic_week/ensemble.html").touch()
    assert document.write_ensembles(tmp_path) == page
    text = page.read_text()
    assert "(images/studies/arctic_week_ensemble.png)" in text and "step-2" in text
    assert (images / "arctic_week_ensemble.png").stat().st_size > 10_000


def test_pages_print_no_more_digits_than_intervals_have(study: Ensemble):
    assert per_cent(Interval(0.1234, 0.1034, 0.1434)) == "12 ± 2"
    assert per_cent(Interval(-0.00123, -0.00133, -0.00113)) == "−0.12 ± 0.01"
    assert per_cent(Interval(0.1, -math.inf, math.inf)) == "–"
    said = " ".join(sentences(study))
    assert "step-2" in said and "km" in said
    table = setting_table(study)
    assert len(table.rows) == len(study.rows) and len(table.rows[0]) == len(table.head)
    assert all(len(row) == len(change_table(study).head) for row in change_table(study).rows)
    assert len(ensemble_figure(study).axes) == 1
