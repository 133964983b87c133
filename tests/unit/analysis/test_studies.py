# SPDX-License-Identifier: GPL-2.0-or-later
"""Studies: variants of a scene, what they share, comparisons, orders, recommendations, pages."""

from __future__ import annotations

import itertools
import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from floeflow.analysis.estimate.choose import scene_estimates
from floeflow.analysis.studies import compare
from floeflow.analysis.studies.ablation_figure import ablation_figure
from floeflow.analysis.studies.ablation_page import effect_table, sentences
from floeflow.analysis.studies.ablation_table import ablation_table
from floeflow.analysis.studies.accuracy_figure import accuracy_figure, is_felt
from floeflow.analysis.studies.accuracy_page import order_table, recommendation_table, run_table
from floeflow.analysis.studies.accuracy_table import (
    Accuracy,
    Convergence,
    Point,
    Runs,
    as_dataset,
    pareto,
)
from floeflow.analysis.studies.measures import KEPT, NORMS
from floeflow.analysis.studies.numerical_settings import numerical_settings
from floeflow.analysis.studies.orders import observed_order, with_tail
from floeflow.analysis.studies.outcome import read_outcome
from floeflow.analysis.studies.plans import STUDIES, study_variants
from floeflow.analysis.studies.recommend import combinations, most_accurate, quieted, recommend
from floeflow.analysis.studies.run import FASTEST, results_of
from floeflow.analysis.studies.variants import Variant, changed, run_name, variant_scene
from floeflow.core.errors import FloeError
from floeflow.core.grids import scene_grid
from floeflow.report.study_page import Study, as_markdown, render_study
from floeflow.scene import Scene, load_scene
from floeflow.scene.effects import EFFECTS
from floeflow.scene.hashes import BEFORE, chain_hash
from floeflow.scene.load import read_keys
from support.synthetic import make_run

ROOT = Path(__file__).parents[3]
SMOKE = ROOT / "config/scenes/smoke.yaml"
EXAMPLES = ("free_drift_day", "winter_pack", "summer_melt_month", "marginal_ice_zone")


@pytest.fixture(autouse=True)
def _in_project(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)


def test_changes_are_set_by_dotted_key_and_leave_the_scene_alone():
    keys = {"time": {"windows": 2}}
    found = changed(keys, {"time.window": 10.0, "packing.elements": 7})
    assert found == {"time": {"windows": 2, "window": 10.0}, "packing": {"elements": 7}}
    assert keys == {"time": {"windows": 2}}


def test_a_variant_is_a_scene_of_its_own():
    scene, keys = load_scene(SMOKE), read_keys(SMOKE)
    variant = Variant("fine", {"packing.elements": 400})
    made = variant_scene(keys, scene, "accuracy", variant)
    assert made.name == "smoke+accuracy-fine" and made.packing.elements == 400
    assert made.effects == scene.effects and made.domain == scene.domain
    assert Variant.from_text(variant.as_text()) == variant
    # One job runs all of its windows.
    assert made.workflow.windows_per_job == scene.time.windows
    longer = variant_scene(keys, scene, "accuracy", Variant("long", {"time.windows": 99}))
    assert longer.workflow.windows_per_job == 99
    with pytest.raises(FloeError, match=r"variant 'smoke\+accuracy-bad': packing.elements"):
        variant_scene(keys, scene, "accuracy", Variant("bad", {"packing.elements": 0}))


@pytest.mark.parametrize("name", EXAMPLES)
@pytest.mark.parametrize("study", list(STUDIES))
def test_every_variant_of_the_example_scenes_is_valid(name: str, study: str):
    path = ROOT / f"config/scenes/{name}.yaml"
    scene = load_scene(path)
    variants = study_variants(study, scene)
    assert next(iter(variants)) == "base"
    for variant in variants.values():
        made = variant_scene(read_keys(path), scene, study, variant)
        assert made.name == run_name(name, study, variant.name)
        length = made.time.windows * made.time.window
        assert length == pytest.approx(scene.time.windows * scene.time.window)


def test_ablation_leaves_out_each_effect_and_what_needs_it():
    scene = load_scene(ROOT / "config/scenes/winter_pack.yaml")
    variants = study_variants("ablation", scene)
    for name in scene.effects:
        left = variants[f"no_{name}"].changes["effects"]
        assert name not in left
        assert all(set(EFFECTS[e].needs) <= set(left) for e in left)
    assert "refreeze" not in variants["no_bonds"].changes["effects"]


def test_runs_share_what_their_keys_share():
    """Where hashes agree, a variant takes the base scene's file of that stage."""
    scene = load_scene(SMOKE)

    def same(changes: dict) -> set[str]:
        made = variant_scene(read_keys(SMOKE), scene, "accuracy", Variant("x", changes))
        return {stage for stage in BEFORE if chain_hash(made, stage) == chain_hash(scene, stage)}

    assert same({"dynamics.young_modulus": 1.0e8}) == set(BEFORE)
    assert same({"time.window": 43200.0}) == set(BEFORE)
    # What is made from another packing is another file, though it reads no other key.
    assert same({"packing.elements": 9}) == {"land", "mask"}

    assert same({"column.categories": 2}) == {"land", "mask", "packing", "bonds", "cells"}
    assert same({"mask.refine": 2 * scene.mask.refine}) == set()


def test_a_run_equals_itself_and_a_moved_one_by_its_move(tmp_path: Path):
    run = make_run(tmp_path, windows=1)
    ends = compare.read_ends(run.state(0), run.state(1))
    found = compare.differences(ends, ends)
    assert set(found.values()) == {0.0}
    moved = ends.last.copy(deep=True)
    moved["x"] = moved["x"] + 3000.0
    moved["ice_volume"] = 1.1 * moved["ice_volume"]
    found = compare.differences(ends, compare.RunEnds(ends.first, moved))
    assert found["drift"] == pytest.approx(3000.0)
    assert found["volume"] == pytest.approx(0.1 * compare.totals(ends.last)["volume"])
    assert found["area"] == 0.0
    # Interpolated to other elements: a shift of all is still that shift.
    fewer = slice(0, None, 2)
    half = compare.RunEnds(ends.first.isel(element=fewer), moved.isel(element=fewer))
    assert 1000 < compare.drift_difference(ends, half) < 9000


def test_costs_are_read_from_what_jobs_and_windows_left(tmp_path: Path):
    run = make_run(tmp_path, windows=2)
    for name, seconds in (("packing", 1.25), ("variant", 99.0), ("windows-0002", 99.0)):
        path = run.folder / f"cpu/{name}.json"
        path.parent.mkdir(exist_ok=True)
        rule = name.partition("-")[0]
        path.write_text(json.dumps({"rule": rule, "cpu_seconds": seconds}))
    costs = run.of_chunks("cost", ".json")
    outcome = read_outcome(run.scene.name, "", costs, run.folder / "cpu")
    # Nor an earlier try of this very job, nor windows that their own records tell.
    assert outcome.cpu == {"packing": 1.25, "dynamics": 4.2}
    assert outcome.steps == 8000 and outcome.element_steps == 8000 * outcome.elements
    whole = read_outcome(run.scene.name, "", costs, run.folder / "cpu", job=5.0)
    assert whole.cpu["window"] == pytest.approx(5.0 - 4.2)
    assert whole.cpu_seconds == pytest.approx(5.0 + 1.25)


def test_a_run_whose_ice_flies_away_has_failed(tmp_path: Path):
    run = make_run(tmp_path, windows=1)
    ends = compare.read_ends(run.state(0), run.state(1))
    found, fault = results_of(ends, ends)
    assert not fault and found["differences"]["drift"] == 0.0
    fast = ends.last.copy(deep=True)
    fast["u"].values[0] = -1.01 * FASTEST
    assert results_of(ends, compare.RunEnds(ends.first, fast)) == (
        {},
        "unstable: the ice moves at 5.05 m/s",
    )
    lost = ends.last.copy(deep=True)
    lost["ice_volume"].values[0] = np.nan
    assert results_of(ends, compare.RunEnds(ends.first, lost))[1].startswith("unstable")


@pytest.mark.parametrize("order", [1.0, 2.0])
def test_order_and_limit_of_a_convergent_series(order: float):
    levels = [0.25, 0.5, 1.0, 2.0]
    values = [7.0 + 0.3 * level**order for level in levels]
    against = [abs(value - values[0]) for value in values]
    steps = [abs(b - a) for a, b in zip(values, values[1:], strict=False)]
    assert observed_order(levels, steps) == pytest.approx(order)
    found, seen, converges = with_tail(levels, against, steps)
    assert converges and seen == pytest.approx(order)
    assert found == pytest.approx([0.3 * level**order for level in levels])


def test_a_series_that_does_not_converge_is_said_to():
    _, order, converges = with_tail([0.5, 1.0, 2.0], [0.0, 1.0, 1.4], [1.0, 1.0])
    assert not converges and order == pytest.approx(0.0, abs=1e-9)
    assert math.isnan(observed_order([0.5, 1.0], [1.0]))


def points() -> list[Point]:
    """Two settings: time step (error and work of order 1), softness that saves little."""
    found = []
    for setting, share in (("step_share", 0.1), ("softness", 0.02)):
        for level in (0.5, 1.0, 2.0):
            errors = {norm: share * level for norm in NORMS}
            name = "base" if level == 1.0 else f"{setting}-{level:g}"
            found.append(
                Point(name, setting, level, 1 / level, 1.0, 1 / level, True, errors, errors)
            )
    found.append(Point("soft", "softness", 64.0, 0.1, 1.0, 0.1, False, {}, {}))
    whole = {"drift": 0.12}
    found.append(Point("base", "together", math.nan, 1.0, 1.0, 1.0, True, whole, whole))
    return found


def accuracy() -> Accuracy:
    orders = [Convergence("step_share", norm, 1.0, 1.02, True) for norm in NORMS]
    orders += [Convergence("softness", "drift", None, 0.1, False)]
    return Accuracy(points(), orders, dict.fromkeys(NORMS, 1e-4), 0.02, 1.5)


def test_the_recommendation_is_the_cheapest_that_holds():
    names = ("step_share", "softness")
    found = recommend(points(), names, 0.11)
    assert found is not None and found.levels == {"step_share": 1.0, "softness": 2.0}
    assert found.error == pytest.approx(math.hypot(0.1, 0.04)) and found.work == 0.5
    assert recommend(points(), names, 0.01) is None
    best = most_accurate(points(), names, 1.0)
    assert best is not None and best.work <= 1.0 and best.levels["step_share"] == 0.5


def test_the_front_holds_no_beaten_run():
    front = pareto(points(), "drift")
    for one in front:
        assert not [
            p
            for p in points()
            if p.stable
            and "drift" in p.totals
            and p.work <= one.work
            and p.totals["drift"] < one.totals["drift"]
        ]


def test_figures_and_tables_of_an_accuracy_study():
    study, scene = accuracy(), load_scene(SMOKE)
    figure = accuracy_figure(study, "drift")
    text = " ".join(t.get_text() for t in figure.axes[0].get_legend().get_texts())
    assert "unstable" in text and "step share" in text and "Pareto" in text
    assert "(0.10)" in as_markdown(order_table(study))
    assert "unstable" in as_markdown(run_table(study))
    data = as_dataset(study, scene)
    assert data.sizes == {"point": 8, "norm": len(NORMS)}
    assert int(data["stable"].sum()) == 7
    rows = recommendation_table(study, scene).rows
    assert [row[0] for row in rows] == [1.0, 5.0, 20.0] * 2
    assert [row[1] for row in rows] == ["any"] * 3 + ["the scene's"] * 3
    # 5 % is the finest of either setting; 20 % is had for less than the default's work.
    assert str(rows[0][2]).startswith("least 5.1") and float(rows[2][3]) < 1.0


def test_a_norm_that_no_run_feels_has_no_figure():
    study = accuracy()
    assert is_felt(study, "drift")
    still = [replace(p, errors={"drift": 0.0}, totals={"drift": 0.0}) for p in study.points]
    assert not is_felt(replace(study, points=still), "drift")
    assert not is_felt(replace(study, points=still), "volume")


def test_what_is_neither_cheaper_nor_better_is_not_recommended():
    def at(level: float, work: float, error: float) -> Point:
        errors = dict.fromkeys(KEPT, error)
        return Point(f"a{level}", "a", level, work, 1.0, 1.0, True, errors, errors)

    # Two levels within the clock's noise of the default, one cheaper beyond it.
    runs = [at(4.0, 0.97, 0.1), at(1.0, 1.03, 0.1), at(2.0, 0.98, 0.05), at(8.0, 0.6, 0.3)]
    for target, level in ((0.01, None), (0.05, 2.0), (0.2, 2.0), (0.3, 8.0)):
        found = recommend(quieted(runs, 0.05), ["a"], target)
        assert (found and found.levels["a"]) == level
    same = [at(4.0, 0.97, 0.1), at(1.0, 1.03, 0.1)]
    found = recommend(quieted(same, 0.05), ["a"], 0.2)
    assert found is not None and found.levels["a"] == 1.0


def record(name: str, group: str, drift: float, cpu: float, fault: str = "") -> dict:
    results = {
        "scales": {"drift": 1e4, "volume": 0.1, "area": 0.1},
        "differences": {"drift": drift, "volume": 0.0, "area": 0.0},
    }
    return {
        "variant": name,
        "group": group,
        "effects": ["wind", "ocean_drag", "coriolis", "tilt"],
        "fault": fault,
        "results": {} if fault else results,
        "cpu_seconds": cpu,
        "cpu": {"dynamics": 0.5 * cpu},
        "element_steps": 100.0,
    }


def test_the_ablation_lays_measured_beside_estimated():
    scene = load_scene(SMOKE)
    records = [
        record("base", "", 0.0, 10.0),
        record("repeat-1", "repeat", 1.0, 10.2),
        record("no_wind", "wind", 1e4, 9.0),
        record("no_ocean_drag", "ocean_drag", 0.0, 5.0, "unstable: it flew away"),
        record("no_coriolis", "coriolis", 2e3, 9.5),
        record("no_tilt", "tilt", 5e2, 9.8),
    ]
    study = ablation_table(scene, records, scene_estimates(scene))
    rows = {row.name: row for row in study.rows}
    assert rows["wind"].share == 1.0 and rows["ocean_drag"].share == math.inf
    assert rows["wind"].saving == pytest.approx(1 - 9.0 / 10.1)
    assert rows["wind"].run_saving == rows["wind"].saving
    assert study.floor == 1e-4 and study.rank == pytest.approx(1.0)
    table = as_markdown(effect_table(study))
    assert table.index("ocean_drag") < table.index("wind") < table.index("tilt")
    assert "it flew away" in table
    page = render_study(Study("<A>", "lead", sentences(study, scene), [], [effect_table(study)]))
    assert "&lt;A&gt;" in page and "nan" not in page
    axes = ablation_figure(study).axes
    assert [t.get_text() for t in axes[0].get_yticklabels()][-1] == "ocean_drag"
    assert np.isfinite(axes[0].get_xlim()).all()
    json.dumps([setting.name for setting in numerical_settings(scene)])


def test_settings_that_are_ways_start_from_the_most_accurate():
    scene = load_scene(SMOKE)
    found = {setting.name: setting for setting in numerical_settings(scene)}
    assert found["state_precision"].changes(2.0) == {"state.precision": "single"}
    assert found["grid_transfer"].levels == (1.0, 2.0, 4.0, 8.0)
    assert found["grid_transfer"].told(8.0) == "nearest"
    assert found["step_share"].told(0.5) == "x 0.5"
    assert "remap_order" not in found
    rough = scene.model_copy(
        update={
            "effects": (*scene.effects, "remap"),
            "remap": scene.remap.model_copy(update={"order": 1}),
        }
    )
    order = next(setting for setting in numerical_settings(rough) if setting.name == "remap_order")
    assert order.levels == (0.5, 1.0) and order.changes(0.5) == {"remap.order": 2}


def test_the_grid_norms_see_the_transfer(tmp_path: Path):
    run = make_run(tmp_path / "results", windows=1)
    scene = run.scene
    mask = sea_mask(scene)
    ends = [str(run.state(window)) for window in (0, 1)]
    records = {
        name: {"ends": ends, "changes": changes, "fault": ""}
        for name, changes in (("base", {}), ("near", {"grid.transfer": "nearest"}))
    }
    found = Runs(scene, records, mask).errors("base", "near")
    assert found["sithick"] > 0 or found["siconc"] > 0
    assert found["drift"] == found["volume"] == 0.0


def sea_mask(scene: Scene) -> xr.Dataset:
    """A mask grid without land."""
    grid = scene_grid(scene.domain)
    return xr.Dataset(
        {
            "land": (("y", "x"), np.zeros(grid.shape, np.int8)),
            "cell_area": (("y", "x"), np.full(grid.shape, grid.spacing**2)),
        },
        coords={"y": grid.y, "x": grid.x},
    )


def test_settings_are_those_of_all_combinations_that_nothing_beats():
    rng = np.random.default_rng(4)
    names = ("a", "b", "c")
    runs = [
        Point(f"{setting}{k}", setting, 2.0**k, work, 1.0, 1.0, True, errors, errors)
        for setting in names
        for k in range(4)
        for work, *values in [rng.uniform(0.01, 1.0, 1 + len(NORMS)).tolist()]
        for errors in [dict(zip(NORMS, values, strict=True))]
    ]
    series = [[p for p in runs if p.setting == setting] for setting in names]
    every = [
        (max(math.hypot(*(p.errors[norm] for p in choice)) for norm in KEPT), choice)
        for choice in itertools.product(*series)
    ]
    for target in (0.6, 0.9, 1.2):
        found = recommend(runs, names, target)
        best = min((math.prod(p.work for p in c) for e, c in every if e <= target), default=None)
        assert (found and found.work) == (best and pytest.approx(best))
    assert len(combinations(runs, names)) < len(every)
