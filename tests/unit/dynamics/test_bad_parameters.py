# SPDX-License-Identifier: GPL-2.0-or-later
"""Each number of scene, engine and plugin: what no ice has is refused, and the key is named."""

from __future__ import annotations

import dataclasses
import logging
import math
from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI

from floeflow.core.errors import FloeError
from floeflow.coupling.launch import warn_of_step
from floeflow.dynamics.engine.engine import Engine, EngineParams
from floeflow.dynamics.engine.params import FIXED
from floeflow.scene.blocks import Dynamics, Scene
from floeflow.scene.load import parse_scene
from support.full_ice import full_params
from support.rafts import bonded, lattice

# Of the engine's parameters: those that may be of either sign, those that may be 0.
SIGNED = {"turning_angle"}
MAY_BE_ZERO = {
    *("poisson_ratio", "bond_damping", "tensile_share", "contact_damping"),
    *("friction_coefficient", "ridge_hardening", "lead_softening"),
    *("wind_stress_factor", "ocean_stress_factor"),
}
NUMBERS = [
    f.name for f in dataclasses.fields(EngineParams) if str(f.type) in ("float", "float | None")
]
KEYS = [name for name, info in Dynamics.model_fields.items() if info.annotation is float]
# What the plugin's commands take from EngineParams, by the words of the command.
PLUGIN = (
    *("bond_young", "poisson", "bond_damping", "compressive_strength", "tensile_share"),
    *("friction_angle", "contact_young", "contact_shear_ratio", "contact_damping"),
    *("friction_coefficient", "ridge_force", "ridge_hardening", "ridge_thickness"),
    *("lead_softening", "reach"),
)
ZERO_ELEMENT = {"radius", "mass"}


def scene_of(dynamics: str) -> Scene:
    return parse_scene(f"dynamics: {{{dynamics}}}".encode(), "some")


@pytest.mark.parametrize("name", NUMBERS)
def test_a_number_of_the_engine_is_refused(name: str) -> None:
    for value in (math.nan, math.inf, -math.inf):
        with pytest.raises(FloeError, match=rf"^{name} must be finite, not -?(nan|inf)\.$"):
            full_params(**{"time_step": 1.0, name: value})
    if name not in SIGNED:
        with pytest.raises(FloeError, match=rf"^{name} must "):
            full_params(**{"time_step": 1.0, name: -1.0})
    if name not in SIGNED | MAY_BE_ZERO:
        with pytest.raises(FloeError, match=rf"^{name} must "):
            full_params(**{"time_step": 1.0, name: 0.0})


@pytest.mark.parametrize(
    "period", [(0.0, 0.0, 0.0, 1.0), (0.0, 2.0, 1.0, 1.0), (0.0, 0.0, math.nan, 1.0)]
)
def test_a_period_that_is_no_rectangle_is_refused(period: tuple[float, ...]) -> None:
    with pytest.raises(FloeError, match="^period must be west, south, east and north edges"):
        full_params(time_step=1.0, period=period)


@pytest.mark.parametrize("name", KEYS)
def test_a_number_of_a_scene_is_refused(name: str) -> None:
    for value in (".nan", ".inf", "-.inf", "-91.0"):
        with pytest.raises(FloeError, match=rf"^dynamics\.{name}: "):
            scene_of(f"{name}: {value}")


@pytest.mark.parametrize("name", PLUGIN)
def test_a_number_of_the_plugin_is_refused(tmp_path: Path, name: str) -> None:
    # The commands themselves, as in an input script.
    faults = {"nan": "is not finite", "inf": "is not finite", "much": "must be a number"}
    faults["-1.0"] = "must (not be negative|be above 0)"
    with Engine(MPI.COMM_SELF, full_params(time_step=1.0), tmp_path / "log") as engine:
        for value, fault in faults.items():
            engine.load(lattice(2, 1))
            with pytest.raises(FloeError, match=rf"pair_style gran model floe: {name} {fault}"):
                engine._command(f"pair_style gran model floe {name} {value}")


@pytest.mark.parametrize(
    "name",
    ["x", "y", "theta", "u", "v", "omega", "radius", "mass", "thickness", "ice_area"],
)
def test_a_number_of_an_element_is_refused(tmp_path: Path, name: str) -> None:
    values = [math.nan, math.inf, *([0.0, -1.0] if name in ZERO_ELEMENT else [])]
    with Engine(MPI.COMM_SELF, full_params(time_step=1.0), tmp_path / "log") as engine:
        for value in values:
            raft = lattice(3, 2)
            raft[name][4] = value
            with pytest.raises(FloeError, match=rf"^{name} of element 5 must be .*, not {value}"):
                engine.load(raft)


@pytest.mark.parametrize("name", ["span", "thickness", "crack_a", "crack_b", "lo_ax", "hi_by"])
def test_a_number_of_a_bond_is_refused(tmp_path: Path, name: str) -> None:
    raft = lattice(3, 2)
    with Engine(MPI.COMM_SELF, full_params(time_step=1.0, bonds=True), tmp_path / "log") as engine:
        for value in (math.nan, math.inf, *([] if "_a" in name or "_b" in name else [-1.0])):
            table = bonded(raft)
            table[name][1] = value
            with pytest.raises(FloeError, match=rf"{name} of the bond \d-\d is "):
                engine.load(raft, table)


def test_elements_that_cannot_move_are_no_fault(tmp_path: Path) -> None:
    raft = lattice(3, 2)
    raft["type"][:] = FIXED
    with Engine(MPI.COMM_SELF, full_params(time_step=1.0), tmp_path / "log") as engine:
        engine.load(raft)
        engine.run(2)
        np.testing.assert_array_equal(engine.elements()["x"], raft["x"])


def test_a_step_above_the_critical_one_is_asked_for_and_warned_of(
    capsys: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    with pytest.raises(FloeError, match=r"^dynamics\.step_share \(1\.5\) is above 1: .*allow_unst"):
        scene_of("step_share: 1.5")
    with caplog.at_level(logging.WARNING):
        warn_of_step(scene_of("step_share: 1.0, allow_unstable_step: true"))
        assert not caplog.records and not capsys.readouterr().err
        warn_of_step(scene_of("step_share: 1.5, allow_unstable_step: true"))
    said = "dynamics.step_share is 1.5: at such a time step the ice may blow up"
    assert [record.message for record in caplog.records] == [said]
    assert capsys.readouterr().err == f"floeflow: warning: {said}\n"
