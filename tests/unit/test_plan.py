# SPDX-License-Identifier: GPL-2.0-or-later
"""Plans: proposals keep their promise, models are recovered by the fit, the command speaks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from floeflow.config import Scene, load_scene
from floeflow.config.load import build_scene, read_keys
from floeflow.errors import FloeError
from floeflow.estimate.conditions import Conditions, conditions
from floeflow.estimate.cost import WORK, coefficients, run_seconds, sizes, stage_seconds
from floeflow.plan.__main__ import as_time, main
from floeflow.plan.fit_costs import Run, fit_costs, read_runs
from floeflow.plan.fit_errors import Study, fit_choices, fit_laws
from floeflow.plan.precision import ErrorModel, error_model, knob_errors, resolutions, total_error
from floeflow.plan.propose import adjusted, for_budget, for_error, parse_budget, proposals
from floeflow.studies.knobs import knobs
from floeflow.studies.variants import changed

ROOT = Path(__file__).parents[2]
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
    for knob in resolutions(scene, c):
        assert resolutions(scene, c)[knob] > 0
    share = 0.25 * scene.dynamics.step_share
    fine = scene.model_copy(
        update={"dynamics": scene.dynamics.model_copy(update={"step_share": share})}
    )
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
        return knob_errors(other, c, MODEL)["column_scheme"].get("volume", 0.0)

    assert [error(name) for name in ("mushy", "bl99", "zero_layer")] == [0.0, 0.1, 0.2]


def test_a_folder_without_a_study_is_refused(tmp_path: Path):
    with pytest.raises(FloeError, match="there is no study here"):
        read_runs([tmp_path])


def test_the_command_proposes_and_refuses(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    def plan(*more: str) -> int:
        monkeypatch.setattr("sys.argv", ["plan", *more])
        return main()

    monkeypatch.setattr("logging.disable", lambda _: None)
    assert plan(str(SMOKE), "--budget", "1h", "--ranks", "2") == 0
    said = capsys.readouterr().out
    assert "on 2 ranks, as it stands: about" in said and "Error by knob" in said
    assert plan(str(SMOKE), "--error", "1e-9") == 0
    assert "No setting reaches an error of 1e-09" in capsys.readouterr().out
    assert plan(str(SMOKE), "--budget", "soon") == 1
    assert "--budget soon" in capsys.readouterr().err
    assert plan("--refit", "--results", str(tmp_path)) == 1
    assert "there is no study to fit to" in capsys.readouterr().err
    assert error_model()


def test_times_are_said_in_their_best_unit():
    assert [as_time(s) for s in (5.0, 600.0, 7200.0, 3e5)] == ["5 s", "10 min", "2 h", "3.5 d"]
