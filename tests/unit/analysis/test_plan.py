# SPDX-License-Identifier: GPL-2.0-or-later
"""Plans: proposals keep their promise, models are recovered by the fit, the command speaks."""

from __future__ import annotations

import itertools
import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from floeflow.analysis.estimate import cost
from floeflow.analysis.estimate.conditions import Conditions, conditions
from floeflow.analysis.estimate.cost import WORK, coefficients, run_seconds, sizes, stage_seconds
from floeflow.analysis.plan.command import main
from floeflow.analysis.plan.fit_costs import (
    Run,
    fit_costs,
    fit_whole_runs,
    read_runs,
    read_whole_runs,
)
from floeflow.analysis.plan.fit_errors import Study, fit_choices, fit_laws
from floeflow.analysis.plan.pack import fitted_to_pack
from floeflow.analysis.plan.precision import (
    ErrorModel,
    error_model,
    resolutions,
    setting_errors,
    total_error,
)
from floeflow.analysis.plan.propose import adjusted, for_budget, for_error, parse_budget, proposals
from floeflow.analysis.plan.refit import held_out, refit
from floeflow.analysis.studies.numerical_settings import numerical_settings
from floeflow.analysis.studies.variants import changed
from floeflow.core.errors import FloeError
from floeflow.core.records import WINDOW_CPU
from floeflow.coupling.initial import make_state
from floeflow.dynamics.motion import engine_params, nearing
from floeflow.dynamics.step.critical import critical_step
from floeflow.forcings.window import window_forcing
from floeflow.masks.mask import make_mask
from floeflow.packings.bonds import make_bonds
from floeflow.packings.packing import make_packing
from floeflow.scene import Scene, load_scene
from floeflow.scene.load import build_scene, read_keys
from floeflow.state.elements import element_arrays, pair_arrays

ROOT = Path(__file__).parents[3]
SMOKE = ROOT / "config/scenes/smoke.yaml"
MODEL = ErrorModel(
    {
        "step_share": {"drift": (0.05, 1.0)},
        "softness": {"drift": (1.0, 0.5)},
        "element_size": {"drift": (0.3, 1.0), "volume": (0.01, 1.0)},
        "column_step": {"volume": (0.2, 1.0)},
    },
    {"column_scheme": {"zero_layer": {"volume": 0.2}, "bl99": {"volume": 0.1}}},
)


@pytest.fixture(autouse=True)
def _in_project(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)


@pytest.fixture(scope="module")
def scene() -> Scene:
    return load_scene(SMOKE)


@pytest.fixture(scope="module")
def c(scene: Scene) -> Conditions:
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(ROOT)
        return conditions(scene)


def test_budgets_are_times():
    assert parse_budget("2h") == 7200.0 and parse_budget("1.5 m") == 90.0
    for wrong in ("2", "h", "-1h", "0s", "2 weeks"):
        with pytest.raises(FloeError, match="give a time such as"):
            parse_budget(wrong)


def test_finer_settings_have_smaller_errors(scene: Scene, c: Conditions):
    for setting in resolutions(scene, c):
        assert resolutions(scene, c)[setting] > 0
    share = 0.25 * scene.dynamics.step_share
    fine = scene.model_copy(
        update={"dynamics": scene.dynamics.model_copy(update={"step_share": share})}
    )
    one, two = (setting_errors(s, c, MODEL)["step_share"]["drift"] for s in (scene, fine))
    assert two == pytest.approx(one / 4)
    assert total_error({"a": {"drift": 0.3}, "b": {"drift": 0.4}}) == pytest.approx(0.5)
    assert total_error({"a": {"drift": 0.3}, "b": {"drift": 0.4}}, but=("b",)) == 0.3


def test_a_proposal_is_a_valid_scene_that_keeps_its_promise(scene: Scene, c: Conditions):
    fit = coefficients()
    found = proposals(scene, c, 1, fit, MODEL)
    assert not found[0].changes
    errors = sorted(p.error for p in found)
    target = errors[len(errors) // 3]
    best = for_error(found, target)
    assert best is not None and best.error <= target
    assert not [p for p in found if p.error <= target and p.seconds < best.seconds]
    keys = changed(read_keys(SMOKE), {"name": "planned", **best.changes})
    planned = build_scene(keys)
    assert run_seconds(conditions(planned), planned, planned.effects, 1, fit) == pytest.approx(
        best.seconds, rel=0.01
    )
    budget = found[0].seconds
    rich = for_budget(found, budget)
    assert rich is not None and rich.seconds <= budget and rich.error <= found[0].error
    assert for_error(found, 0.0) is None and for_budget(found, 0.0) is None


def test_ranks_share_the_work_and_pay_for_messages(scene: Scene, c: Conditions):
    fit = {**coefficients(), "message": 1e-6}
    one, many = (run_seconds(c, scene, scene.effects, n, fit) for n in (1, 4))
    seconds = stage_seconds(sizes(c, scene, scene.effects, fit), scene.effects, fit)
    assert one == pytest.approx(sum(seconds.values()))
    assert one - sum(seconds[part] for part in WORK) < many < one


def made_record(scene: Scene, c: Conditions, fit: dict[str, float]) -> dict:
    """What a run would have left if the cost model were the truth."""
    s = sizes(c, scene, scene.effects, fit)
    seconds = stage_seconds(s, scene.effects, fit)
    step = scene.time.windows * scene.time.window / s.steps
    parts = ("dynamics", "column", "window", "forcing")
    cpu = {name: seconds[name] for name in parts if name in seconds}
    cpu |= {"initial": fit["job"], "land": fit["land"]}
    return {
        "cpu": cpu,
        "steps": s.steps,
        "element_steps": s.steps * s.elements,
        "elements": s.elements,
        "time_step": step,
        "fault": "",
    }


def test_the_fit_finds_the_coefficients_of_made_runs(scene: Scene, c: Conditions):
    truth = {**coefficients(), "job": 0.7, "step": 2e-5, "dynamics": 4e-8, "dynamics_bonds": 5e-8}
    truth |= {"dynamics_wind": 1e-8, "dynamics_friction": 2e-8, "column": 3e-6, "land": 2.0}
    truth |= {"forcing_per_cell": 2e-5, "launch": 1.0, "window": 0.2}
    truth |= {"window_per_element": 3e-5, "column_start": 0.01, "column_zero_layer": 2e-6}
    truth |= {"column_bl99": 8e-6, "column_delta_eddington": 5e-6, "column_shortwave": 1e-6}
    truth |= {"window_ridging": 2e-5}
    runs = []
    for elements in (100, 400, 1600):
        for effects in (
            ("wind", "ocean_drag", "thermodynamics"),
            ("ocean_drag", "thermodynamics"),
            ("wind", "friction", "thermodynamics"),
            ("wind", "ocean_drag", "friction", "bonds", "thermodynamics"),
            ("wind", "friction", "bonds"),
            ("wind",),
            ("wind", "bonds", "friction", "ridging"),
        ):
            for windows in (1, 4):
                keys = {"dynamics.young_modulus": 1e9, "dynamics.contact_modulus": 1e8}
                keys |= {"packing.elements": elements, "effects": list(effects)}
                keys |= {"time.windows": windows, "workflow.windows_per_job": windows}
                other = build_scene(changed(scene.model_dump(mode="json"), keys))
                own = adjusted(c, other)
                runs.append(Run(other, own, made_record(other, own, truth)))
    for scheme, light, many in itertools.product(
        ("zero_layer", "bl99"), ("ccsm3", "delta_eddington"), (1, 3)
    ):
        keys = {"column.scheme": scheme, "column.light": light, "column.categories": many}
        keys["effects"] = ["wind", "thermodynamics", "shortwave"]
        other = build_scene(changed(scene.model_dump(mode="json"), keys))
        runs.append(Run(other, c, made_record(other, c, truth)))
    found = fit_costs(runs, coefficients())
    for name in ("column_zero_layer", "column_bl99", "column_delta_eddington", "window_ridging"):
        assert found[name] == pytest.approx(truth[name], rel=0.02), name
    names = ("job", "step", "dynamics", "dynamics_bonds", "dynamics_friction", "column")
    for name in (*names, "forcing_per_cell"):
        assert found[name] == pytest.approx(truth[name], rel=0.02), name
    assert found["launch"] == pytest.approx(1.0, rel=0.05)
    # Samples cut the step a little.
    assert found["step_bonds"] == pytest.approx(truth["step_bonds"], rel=0.05)


def test_members_and_whole_runs_tell_what_windows_take_beside_their_parts(tmp_path: Path):
    """CPU time of all of a window less dynamics, column and forcing; no start of a program."""
    folder = tmp_path / "whole"
    (folder / "cost").mkdir(parents=True)
    (folder / "scene.yaml").write_text(load_scene(SMOKE).model_dump_json())
    parts = [{"name": "dynamics", "cpu_seconds": 2.0, "n": 5, "steps": 10, "time_step": 1.0}]
    parts += [{"name": "column", "cpu_seconds": 1.0, "n": 5}]
    parts += [{"name": "exchange", WINDOW_CPU: 3.5, "n": 5}]
    records = [part | {"ranks": 1, "seconds": [9.0], "window": 1} for part in parts]
    (folder / "cost/0003.json").write_text(json.dumps(records))
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(ROOT)
        (run,) = read_whole_runs([folder])
        assert run.cpu == {"dynamics": 2.0, "column": 1.0, "window": 0.5} and not run.launched
        # The time of two ranks that wait for each other is no cost.
        (folder / "cost/0003.json").write_text(json.dumps([r | {"ranks": 2} for r in records]))
        assert read_whole_runs([folder]) == []


def test_a_plan_knows_the_step_of_the_scenes_own_pack(scene: Scene, c: Conditions, tmp_path: Path):
    keys = changed(scene.model_dump(mode="json"), {"mask.land": "mask", "packing.elements": 60})
    small = build_scene(keys)
    fit = fitted_to_pack(small, c, coefficients())
    own = adjusted(c, small)
    mask = make_mask(small, None)
    packing = make_packing(mask, small.packing, small.seed, True)
    state = make_state(small, packing, make_bonds(packing, small.packing.bond_gap, 0.8, False))
    elements = element_arrays(state, small.dynamics.minimum_thickness)
    # That of the run's first window.
    way = nearing(small, elements, window_forcing(small, 1, tmp_path))
    step = critical_step(elements, pair_arrays(state, "bond"), engine_params(small), way)[0]
    assert cost.critical_step(own, small, small.effects, fit) == pytest.approx(step, rel=1e-12)
    assert sizes(own, small, small.effects, fit).elements == pytest.approx(
        len(elements["id"]), 0.02
    )


def test_reports_and_grids_are_timed_by_whole_runs(tmp_path: Path):
    run = tmp_path / "one"
    (run / "cpu").mkdir(parents=True)
    (run / "fields").mkdir()
    stages = [("estimate", 1.0), ("diagnostics", 2.0), ("report", 4.0), ("land", 3.0)]
    for rule, seconds in [*stages, ("fields", 2.5), ("fields", 3.5), ("tendencies", 1.6)]:
        path = run / f"cpu/{rule}-{seconds}.json"
        path.write_text(json.dumps({"rule": rule, "cpu_seconds": seconds}))
    grid = xr.Dataset(
        {"siconc": (("time", "y", "x"), np.zeros((2, 4, 5)))}, {"x": range(5), "y": range(4)}
    )
    grid.to_netcdf(run / "grid.nc")
    for chunk in ("0001", "0002"):
        grid.to_netcdf(run / f"fields/{chunk}.nc")
    found = fit_whole_runs([run], job=1.0)
    # Two jobs of one second each; the other four are for 2 x 20 cells.
    # 0.6 seconds are for the 20 cells of one window.
    per_cell = {"grid_per_cell": pytest.approx(0.1), "tendencies_per_cell": pytest.approx(0.03)}
    assert found == {"report": 7.0, "land": 3.0, **per_cell}
    assert fit_whole_runs([], job=1.0) == {}


def made_study(scene: Scene, laws: dict[str, float], ways: dict[str, float]) -> Study:
    """A study whose settings' errors in volume are factor x level or, for ways, as given."""
    rows = []
    for setting in numerical_settings(scene):
        for level in setting.levels:
            if setting.ways:
                error = ways.get(setting.told(level), 0.0)
            else:
                error = laws.get(setting.name, 0.0) * level
            rows.append((setting.name, level, error))
    names, levels, errors = zip(*rows, strict=True)
    runs = xr.Dataset(
        {
            "setting": ("point", np.array(names)),
            "level": ("point", np.array(levels)),
            "stable": ("point", np.ones(len(rows), np.int8)),
            "error": (("point", "norm"), np.array(errors)[:, None] * [0.0, 1.0, 0.0]),
            "norm": ("norm", ["drift", "volume", "area"]),
        }
    )
    return Study(scene, runs)


def test_the_fit_finds_the_errors_of_made_studies(scene: Scene, c: Conditions):
    ways = {"zero_layer": 0.4, "bl99": 0.1}
    studies = [
        made_study(scene, {"window": f}, {name: f * error for name, error in ways.items()})
        for f in (1, 4)
    ]
    x = resolutions(scene, c)["window"]
    factor, order = fit_laws(studies)["window"]["volume"]
    assert order == pytest.approx(1.0) and factor * x == pytest.approx(2.0)  # the geometric mean
    assert fit_choices(studies) == {
        "column_scheme": {
            "bl99": {"volume": pytest.approx(0.2)},
            "zero_layer": {"volume": pytest.approx(0.8)},
        }
    }


def test_a_choice_has_its_own_error_and_the_best_has_none(scene: Scene, c: Conditions):
    def error(scheme: str) -> float:
        column = scene.column.model_copy(update={"scheme": scheme})
        other = scene.model_copy(update={"column": column})
        return setting_errors(other, c, MODEL)["column_scheme"].get("volume", 0.0)

    assert [error(name) for name in ("mushy", "bl99", "zero_layer")] == [0.0, 0.1, 0.2]


def test_held_out_scenes_are_not_fitted_to(tmp_path: Path):
    name = sorted(held_out())[0]
    for path in (f"{name}/accuracy/digest.json", f"{name}+accuracy-base/scene.yaml"):
        (tmp_path / path).parent.mkdir(parents=True)
        (tmp_path / path).write_text("")
    with pytest.raises(FloeError, match="there is no study to fit to"):
        refit(tmp_path, tmp_path / "costs.json", tmp_path / "precision.json")


def test_a_folder_without_a_study_is_refused(tmp_path: Path):
    with pytest.raises(FloeError, match="there is no study here"):
        read_runs([tmp_path])


def test_the_command_proposes_and_refuses(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    def plan(*more: str) -> int:
        return main(more)

    monkeypatch.setattr("logging.disable", lambda _: None)
    assert plan(str(SMOKE), "--budget", "1h", "--ranks", "2") == 0
    said = capsys.readouterr().out
    assert "on 2 ranks, as it stands: about" in said and "Error by setting" in said
    assert plan(str(SMOKE), "--error", "1e-9") == 0
    assert "No setting reaches an error of 1e-09" in capsys.readouterr().out
    assert plan(str(SMOKE), "--budget", "soon") == 1
    assert "--budget soon" in capsys.readouterr().err
    assert plan("--refit", "--results", str(tmp_path)) == 1
    assert "there is no study to fit to" in capsys.readouterr().err
    assert error_model()
