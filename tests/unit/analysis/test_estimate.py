# SPDX-License-Identifier: GPL-2.0-or-later
"""Estimates of effects: limits that are known without a run, the recommendation, `auto`."""

from __future__ import annotations

import inspect
import json
import math
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import pytest
from typer.testing import CliRunner

from floeflow.analysis.estimate import drift, ice
from floeflow.analysis.estimate.choose import OUTPUT, SETTING, estimate, recommended
from floeflow.analysis.estimate.conditions import Conditions, conditions
from floeflow.analysis.estimate.cost import coefficients, critical_step, sizes, stage_seconds
from floeflow.analysis.estimate.dimensionless_numbers import (
    ICE_CONDUCTIVITY,
    ICE_HEAT,
    NUMBERS,
    meaning,
    sea_delay,
)
from floeflow.analysis.estimate.drift import run_drift
from floeflow.analysis.estimate.ice import open_water_loss, run_ice
from floeflow.analysis.estimate.influence import influence, without
from floeflow.analysis.estimate.summary import estimates
from floeflow.analysis.resolve import resolve_scene
from floeflow.cli import app
from floeflow.scene import load_scene
from floeflow.scene.effects import EFFECTS

ROOT = Path(__file__).parents[3]
SMOKE = ROOT / "config/scenes/smoke.yaml"


@pytest.fixture(scope="module", autouse=True)
def _in_project():
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(ROOT)
        yield


@pytest.fixture(scope="module")
def smoke() -> Conditions:
    return conditions(load_scene(SMOKE))


def test_every_effect_has_a_number_with_a_meaning():
    for name in EFFECTS:
        assert (EFFECTS[name].number is None) == (name in NUMBERS) and meaning(name), name


def test_conditions_are_those_of_the_scene(smoke: Conditions):
    assert 70 < smoke.latitude < 76
    assert smoke.seconds == 64800.0
    assert 0.5 < smoke.concentration <= 1 and 1 < smoke.thickness <= 2
    assert 5 < smoke.wind < 15
    # A vortex blows from all sides.
    assert 0.8 * smoke.wind < smoke.wind_spread <= smoke.wind


def test_drift_goes_to_free_drift(smoke: Conditions):
    calm = replace(smoke, current=0.0, seconds=30 * 86400.0)
    place = run_drift(calm, frozenset({"wind", "ocean_drag"}))
    assert abs(place) == pytest.approx(calm.nansen * calm.wind * calm.seconds, rel=1e-2)
    assert place.imag == pytest.approx(0.0, abs=1e-6 * abs(place))


def test_drift_without_drag_is_accelerated(smoke: Conditions):
    calm = replace(smoke, current=0.0)
    place = run_drift(calm, frozenset({"wind"}))
    fall = 0.5 * calm.wind_stress / calm.mass * calm.seconds**2
    assert abs(place) == pytest.approx(fall, rel=0.01)


def test_coriolis_turns_to_the_right_in_the_north(smoke: Conditions):
    calm = replace(smoke, current=0.0)
    place = run_drift(calm, frozenset({"wind", "ocean_drag", "coriolis"}))
    assert place.imag < 0 < place.real
    south = run_drift(replace(calm, latitude=-75.0), frozenset({"wind", "ocean_drag", "coriolis"}))
    assert south.imag > 0


def test_ice_grows_as_stefan_s_law_has_it(smoke: Conditions):
    # A surface held at the air's temperature by strong wind: h^2 grows by 2 k dT t / (rho L).
    cold = replace(
        smoke,
        concentration=1.0,
        thickness=0.5,
        wind=1e4,
        longwave_down=5.67e-8 * smoke.air_temperature**4,
        specific_humidity=11637800.0 * math.exp(-5897.8 / smoke.air_temperature) / 1.3,
        ocean_heat_flux=0.0,
        seconds=10 * 86400.0,
    )
    warm = 2.0 * ICE_CONDUCTIVITY * (271.35 - cold.air_temperature) * cold.seconds / ICE_HEAT
    found = run_ice(cold, frozenset({"thermodynamics"}))
    assert found.volume == pytest.approx(math.sqrt(0.25 + warm), rel=0.01)


def test_summer_melts_and_winter_freezes(smoke: Conditions):
    every = frozenset({"thermodynamics", "snow", "frazil", "shortwave"})
    start = smoke.concentration * smoke.thickness
    assert run_ice(smoke, every).volume > start
    assert open_water_loss(smoke) > 100
    july = replace(
        smoke,
        air_temperature=274.0,
        shortwave_down=250.0,
        longwave_down=300.0,
        specific_humidity=0.0037,
        seconds=30 * 86400.0,
    )
    assert run_ice(july, every).volume < 0.9 * start
    # Ice without layers thins, and loses area from its sides alone.
    assert run_ice(july, every).area == pytest.approx(smoke.concentration)
    assert run_ice(july, every | {"lateral_melt"}).area < 0.99 * smoke.concentration
    assert run_ice(replace(july, layered=True), every).area < smoke.concentration


def test_a_mixed_layer_keeps_heat_for_its_own_time(smoke: Conditions):
    """All of the sea's heat has melted ice after many delays, next to none after a short time."""
    base = frozenset({"thermodynamics"})
    calm = replace(
        smoke,
        concentration=1.0,
        concentration_spread=0.0,
        thickness=3.0,
        ocean_heat_flux=20.0,
        shortwave_down=0.0,
    )
    for seconds, kept in ((0.05, 1.0), (1.0, -math.expm1(-1.0)), (20.0, 0.05)):
        c = replace(calm, seconds=seconds * sea_delay(calm))
        cold = run_ice(replace(c, ocean_heat_flux=0.0), base).volume
        melted = cold - run_ice(c, base).volume
        late = cold - run_ice(c, base | {"mixed_layer"}).volume
        assert 1.0 - late / melted == pytest.approx(kept, abs=0.06)


def test_leads_freeze_what_the_mixed_layer_lacks(smoke: Conditions):
    still = {"concentration": 0.5, "concentration_spread": 0.0, "seconds": 7200.0}
    c = replace(smoke, ocean_heat_flux=30.0, **still)
    every = frozenset({"thermodynamics", "frazil"})
    plain, slab = run_ice(c, every), run_ice(c, every | {"mixed_layer"})
    # The sea's heat goes where it is lost: fewer new floes, thicker old ones, as much ice in all.
    assert slab.area < plain.area
    given = 0.5 * c.ocean_heat_flux * c.seconds / ICE_HEAT
    assert slab.volume == pytest.approx(plain.volume, abs=0.2 * given)


def test_a_weak_wind_closes_no_strong_pack(smoke: Conditions):
    names = tuple(EFFECTS)
    pressed = replace(smoke, concentration=1.0, convergence=1e-5, seconds=5 * 86400.0)
    assert pressed.crushing < 1.0 < replace(pressed, wind=0.3 * pressed.wind).crushing
    assert influence(pressed, "ridging", names).drift > 1e3
    weak = replace(pressed, wind=0.3 * pressed.wind)
    assert influence(weak, "ridging", names).share == 0.0


def test_what_the_coast_holds_stands_still(smoke: Conditions):
    """The root mean square over ice of which a quarter stands and the rest drifts freely."""
    c = replace(smoke, coast_share=0.25)
    found = influence(c, "coast", tuple(EFFECTS)).drift
    assert found == pytest.approx(0.5 * c.slip * c.seconds)


def test_stiffnesses_add_up_in_the_time_step(smoke: Conditions):
    scene, fit = load_scene(SMOKE), coefficients()
    dense = replace(smoke, concentration=1.0)
    step = {
        effects: critical_step(dense, scene, effects, fit)
        for effects in ((), ("friction",), ("bonds",), ("friction", "bonds"))
    }
    rate = {effects: value**-2 for effects, value in step.items()}
    added = rate["friction",] + rate["bonds",] - rate[()]
    assert rate["friction", "bonds"] == pytest.approx(added)
    assert step["friction", "bonds"] < step["bonds",] < step[()]


def test_an_effect_matters_where_its_cause_is(smoke: Conditions):
    names = tuple(EFFECTS)
    still = replace(smoke, current=1e-6)
    assert influence(still, "tilt", names).share < 0.01 < influence(smoke, "tilt", names).share
    equator = replace(smoke, latitude=1.0)
    assert influence(equator, "coriolis", names).share < 0.02
    loose = replace(smoke, concentration=0.3, convergence=0.0)
    for name in ("friction", "ridging", "bonds"):
        assert influence(loose, name, names).share == 0.0
        assert influence(smoke, name, names).share > 0.0
    inland = replace(smoke, coast_share=0.0)
    assert influence(inland, "coast", names).drift == 0.0


def test_without_takes_along_what_needs_it():
    left = without(EFFECTS, "bonds")
    assert "refreeze" not in left and "wind" in left


def test_what_is_recommended_can_be_run(smoke: Conditions):
    scene = load_scene(SMOKE)
    rows = estimate(smoke, scene, EFFECTS, coefficients())
    assert [row.name for row in rows] == list(EFFECTS)
    assert all(-1 < row.cost < 1 and row.share >= 0 for row in rows)
    chosen = recommended(rows, ("grid_output",))
    for row in rows:
        if row.advice == "needed":
            assert row.name in chosen
        if row.name in chosen and row.name not in OUTPUT:
            assert row.advice == "needed" or any(row.name in EFFECTS[n].needs for n in chosen)
    assert not {"trajectory_output", *SETTING} & set(chosen)
    assert "walls" in recommended(rows, ("walls",))


def test_cost_grows_with_elements_steps_and_effects(smoke: Conditions):
    scene, fit = load_scene(SMOKE), coefficients()
    small = sizes(smoke, scene, scene.effects, fit)
    seconds = stage_seconds(small, scene.effects, fit)
    double = stage_seconds(replace(small, steps=2 * small.steps), scene.effects, fit)
    assert double["dynamics"] == pytest.approx(2 * seconds["dynamics"])
    assert "column" not in stage_seconds(small, ("wind",), fit)
    # Without stiff bonds the step is longer.
    assert sizes(smoke, scene, ("wind",), fit).steps < small.steps


def test_auto_chooses_and_says_why(tmp_path: Path):
    text = SMOKE.read_text() + "\nname: smoke\neffects: auto\n"
    path = tmp_path / "smoke.yaml"
    path.write_text(text)
    scene = resolve_scene(path)
    assert scene.auto and not load_scene(SMOKE).auto
    said = estimates(scene, "auto")
    named = {row["name"] for row in said["estimates"] if row["named"]}
    assert named == set(scene.effects) == set(said["effects"])
    assert "wind" in named
    json.dumps(said, allow_nan=False)
    # In calm air nothing but the heat is left.
    calm = text.replace("cyclone:", "gyre: {current_speed: 0}\n  cyclone:\n    wind_speed: 0")
    path.write_text(calm)
    chosen = set(resolve_scene(path).effects)
    assert {"thermodynamics", "grid_output"} <= chosen
    assert all(EFFECTS[name].column for name in chosen - {"grid_output"})


def test_the_command_prints_the_table():
    done = CliRunner().invoke(app, ["effects", str(SMOKE)])
    assert done.exit_code == 0, done.output
    for name in EFFECTS:
        assert f"\n{name} " in done.stdout
    assert "Recommended: effects: [wind" in done.stdout
    command = [sys.executable, "-m", "floeflow.cli", "effects", "none.yaml"]
    missing = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    assert missing.returncode == 1 and "none.yaml" in missing.stderr


@pytest.mark.parametrize("module", [drift, ice])
def test_runs_know_the_effects_that_they_ask_for(module: ModuleType):
    """Others are taken away before a run is looked up among those that were made."""
    asked = re.findall(r'"(\w+)" (?:not )?in effects', inspect.getsource(module))
    assert module.ACTING == set(asked)
