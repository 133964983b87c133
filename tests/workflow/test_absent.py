# SPDX-License-Identifier: GPL-2.0-or-later
"""What a scene does not name is absent: no rule, no switch, no variable, no figure.

All of it is asked of the registry, so that an effect that is added there is tested here.
"""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from floeflow.analysis.estimate.influence import without
from floeflow.diagnostics.collect import expected_series
from floeflow.forcings.window import window_forcing
from floeflow.scene import load_scene
from floeflow.scene.effects import EFFECTS, compatible
from floeflow.scene.windows import window_name
from floeflow.state import read_dataset, read_state
from floeflow.state.schema import expected_variables
from support.runner import Done, Place, make_place

pytestmark = pytest.mark.workflow

BARE = ("wind",)
# The scheme with the most variables, and categories for the redistribution.
COLUMN = {"scheme": "mushy", "categories": 2}
# Along a meridian through the middle of the scene.
GATES = {"names": ["middle"], "lines": [[-127.0, 80.0, -127.0, 65.0]]}
# Shallow enough for the ridges of the scene, on ground too soft to hold them fast.
GROUNDING = {"depth": 10.0, "strength": 0.05}
# Of two effects that exclude each other only the first can be in a run.
EVERY = compatible(EFFECTS)


def changes(effects: tuple[str, ...]) -> dict[str, object]:
    """What makes a small scene with these effects of ``smoke``."""
    return {
        "effects": list(effects),
        "mask": {"land": "mask"},
        "packing": {"elements": 60},
        "time": {"windows": 1},
        "column": COLUMN,
        "gates": GATES,
        "grounding": GROUNDING,
    }


def figures(results: Path) -> set[str]:
    """Names of the figures in a report."""
    page = (results / "report.html").read_text()
    return set(re.findall(r'<figure id="(\w+)"', page))


def run_with(folder: Path, effects: tuple[str, ...]) -> Done:
    place = make_place(folder / "place")
    scene = place.scene(**changes(effects))
    done = place.run(scene, ranks=1)
    assert done.returncode == 0, done.stdout
    return Done(place, scene, done.stdout)


@pytest.fixture(scope="module")
def bare(tmp_path_factory: pytest.TempPathFactory) -> Done:
    """A run with hardly an effect."""
    return run_with(tmp_path_factory.mktemp("bare"), BARE)


@pytest.fixture(scope="module")
def full(tmp_path_factory: pytest.TempPathFactory) -> Done:
    """A run with every effect of the registry that goes with the others."""
    return run_with(tmp_path_factory.mktemp("full"), EVERY)


def test_an_effect_brings_its_rules_and_none_other_does(place: Place):
    named = {effect.name: set(effect.rules) for effect in EFFECTS.values() if effect.rules}
    # It has files beside the report, and these are made for the scene of the command line: first.
    order = sorted(named, key=lambda name: name != "trajectory_output")
    every = {name: compatible(EFFECTS, name) for name in order}
    left = {name: tuple(without(every[name], name)) for name in order}
    brought, other = (
        place.rules({name: changes(effects) for name, effects in scenes.items()})
        for scenes in (every, left)
    )
    for name, rules in named.items():
        assert rules <= brought[name], name
        kept = {rule for effect in left[name] for rule in EFFECTS[effect].rules}
        assert not (rules - kept) & other[name], name


def test_every_switch_is_on_with_all_effects_and_off_with_none(bare: Done, full: Done):
    logs = [
        (run.results / f"log/windows/{window_name(1)}.liggghts.log").read_text()
        for run in (bare, full)
    ]
    for effect in EFFECTS.values():
        for switch in effect.plugin:
            off, on = (re.findall(rf"\b{switch} (\S+)", log) for log in logs)
            assert on and not set(on) & {"no", "0.0"}, (effect.name, switch, on)
            if effect.name not in BARE:
                assert set(off) <= {"no", "0.0"}, (effect.name, switch, off)


def test_the_state_holds_what_the_effects_name(bare: Done, full: Done):
    for run in (bare, full):
        state = read_state(run.results / "state/0001.nc")
        assert set(map(str, state.variables)) == set(
            expected_variables(load_scene(run.scene).effects, "mushy")
        )
    bare_names = set(map(str, read_state(bare.results / "state/0001.nc").variables))
    for effect in EFFECTS.values():
        if effect.name not in BARE:
            assert not set(effect.state) & bare_names


def test_series_and_costs_are_those_of_the_effects(bare: Done, full: Done):
    names = set(map(str, read_dataset(bare.results / "series/0001.nc").variables))
    every = set(map(str, read_dataset(full.results / "series/0001.nc").variables))
    for effect in EFFECTS.values():
        own = set(expected_series((effect.name,))) - set(expected_series(()))
        assert own <= every or effect.name not in EVERY
        if effect.name not in BARE:
            assert not own & names, effect.name
    costs = json.loads((bare.results / "cost/0001.json").read_text())
    assert {record["name"] for record in costs} == {"forcing", "setup", "dynamics", "exchange"}


def test_figures_are_those_of_the_effects(bare: Done, full: Done):
    none, every = figures(bare.results), figures(full.results)
    for effect in EFFECTS.values():
        for start in effect.figures:
            assert [name for name in every if name.startswith(start)], (effect.name, start)
            if effect.name not in BARE:
                assert not [name for name in none if name.startswith(start)], start


def test_forcing_and_output_are_those_of_the_effects(bare: Done, full: Done, tmp_path: Path):
    forcing = window_forcing(load_scene(bare.scene), 1, tmp_path)
    assert set(forcing.data_vars) == set(EFFECTS["wind"].forcing)
    assert not (bare.results / "grid.nc").exists() and not (bare.results / "fields").exists()
    with xr.open_dataset(full.results / "grid.nc") as grid:
        for effect in EFFECTS.values():
            assert set(effect.output) <= set(map(str, grid.variables)), effect.name


def test_the_budgets_of_every_effect_close(full: Done):
    state = read_state(full.results / "state/0001.nc")
    assert state["ice_salinity"].shape[1:] == (2, 7)
    numbers = json.loads((full.results / "diagnostics.json").read_text())
    verdicts = {budget["name"]: budget["verdict"] for budget in numbers["budgets"]}
    assert verdicts.keys() >= {"ice_volume", "column_energy", "column_water", "column_salt"}
    assert set(verdicts.values()) == {"closed"}, verdicts
    assert "Salt in the ice" in (full.results / "report.html").read_text()


def test_tendencies_on_the_grid_are_all_growth_of_every_effect(bare: Done, full: Done):
    """What froze in open water and what dissolved with its element among it."""
    assert not (bare.results / "tendencies.nc").exists()
    scalars = read_dataset(full.results / "series/0001.nc")
    with xr.open_dataset(full.results / "tendencies.nc", decode_times=False) as made:
        seconds = float(np.diff(made["time_bnds"])[0, 0])
        for name, terms in (
            ("sidmassth", [n for n in scalars if str(n).startswith("growth_")]),
            ("sidconcth", ["ice_area_grown", "ice_area_dissolved"]),
        ):
            wanted = sum(float(scalars[term].values[0]) for term in terms if term in scalars)
            wanted *= 1.0 if name == "sidconcth" else 917.0
            found = seconds * float((made[name] * made["sea_area"]).sum())
            assert found == pytest.approx(wanted, rel=1e-9), name


def test_a_scene_without_ice_runs_to_its_report(place: Place):
    scene = place.scene(
        # The Norwegian Sea west of Lofoten: open water in any winter.
        domain={"x_min": 2.0e5, "x_max": 6.0e5, "y_min": -2.4e6, "y_max": -2.0e6},
        mask={"land": "mask"},
        time={"windows": 1},
    )
    done = place.run(scene, ranks=1)
    assert done.returncode == 0, done.stdout
    state = read_state(place.results() / "state/0001.nc")
    assert not (state["type"].values == 1).any()
    assert state.attrs["unclaimed_water"] == state.attrs["ocean_area"] > 0
    assert "no ice" in (place.results() / "report.html").read_text()


def test_a_scene_of_one_element_runs_to_its_report(place: Place):
    scene = place.scene(packing={"elements": 1}, mask={"land": "mask"}, time={"windows": 1})
    done = place.run(scene, ranks=1)
    assert done.returncode == 0, done.stdout
    state = read_state(place.results() / "state/0001.nc")
    assert (state["type"].values == 1).any()
    for name in ("x", "y", "u", "v", "ice_volume", "area"):
        assert np.isfinite(state[name].values).all(), name
    assert (place.results() / "report.html").exists()
