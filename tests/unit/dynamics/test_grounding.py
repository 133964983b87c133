# SPDX-License-Identifier: GPL-2.0-or-later
"""Grounding of ridges: what the seabed holds, budgets, ranks, scenes with and without it."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from mpi4py import MPI

from floeflow.core.errors import FloeError
from floeflow.coupling.coupled_windows import advance_window
from floeflow.coupling.initial import make_state
from floeflow.diagnostics.budgets import dem_energy_budget, momentum_budget
from floeflow.dynamics.engine.engine import Engine, Forcing
from floeflow.dynamics.engine.params import Force
from floeflow.dynamics.motion import engine_params
from floeflow.forcings.window import window_forcing
from floeflow.scene.blocks import Scene
from floeflow.scene.load import parse_scene
from floeflow.state.schema import expected_variables
from support.full_ice import full_params
from support.rafts import bonded, discs, lattice, uniform
from support.ranks import run_parts
from unit.coupling.test_walls import a_packing

SELF = MPI.COMM_SELF
SEABED = Force("seabed", (), ("sea_floor_depth",))
K1, K2, CREEP = 8.0, 15.0, 5.0e-5


def test_ice_creeps_where_its_keel_is_held_and_drifts_in_deep_water(tmp_path: Path) -> None:
    """tau_a = tau_b |u| / (|u| + u0): the depth is that of the place where the ice is."""
    params = full_params(time_step=300.0, wind=True, ocean_drag=True, forces=(SEABED,))
    x = np.array([-1e6, 1e6])
    one = np.ones((1, 2, 2))
    fields = {"wind_u": 8.0 * one, "wind_v": 0.0 * one, "ocean_u": 0.0 * one, "ocean_v": 0.0 * one}
    fields["sea_floor_depth"] = np.array([[10.0, 210.0], [10.0, 210.0]])
    ice = discs([-9e5, 9e5], [0.0, 0.0], thickness=3.0)
    with Engine(SELF, params, tmp_path / "log") as engine:
        engine.load(ice)
        engine.set_forcing(Forcing(np.zeros(1), x, x, fields))
        engine.run(2000)
        held, free = engine.elements()["u"]
    # 20 m of water at the first: ice of 3 m is half a metre above the critical thickness.
    stress, limit = params.wind_stress_factor * 64.0, K2 * (3.0 - 20.0 / K1)
    assert held == pytest.approx(CREEP * stress / (limit - stress), rel=1e-3)
    terminal = 8.0 * math.sqrt(params.wind_stress_factor / params.ocean_stress_factor)
    assert free == pytest.approx(terminal, rel=1e-3)


def test_budgets_close_with_the_seabed(tmp_path: Path) -> None:
    raft = lattice(6, 5)
    raft["thickness"] = np.linspace(0.5, 2.0, 30)
    raft["mass"] = raft["mass"] * raft["thickness"]
    raft["u"][:] = 0.3
    switches = dict.fromkeys(("bonds", "wind", "ocean_drag", "coriolis", "tilt"), True)
    params = full_params(time_step=0.5, forces=(SEABED,), turning_angle=0.3, **switches)
    with Engine(SELF, params, tmp_path / "log") as engine:
        engine.load(raft, bonded(raft))
        engine.set_forcing(uniform((4.0, -12.0), (0.1, 0.2), 1.4e-4, depth=8.0))
        first = engine.diagnostics()
        engine.run(2000)
        last = engine.diagnostics()
    for axis in "xy":
        names = ("wind", "ocean", "coriolis", "tilt", "seabed")
        terms = [last[f"impulse_{k}_{axis}"] for k in names]
        change = last[f"momentum_{axis}"] - first[f"momentum_{axis}"]
        assert abs(change - sum(terms)) < 1e-11 * sum(abs(t) for t in terms)
    works = [last[f"work_{k}"] for k in ("wind", "ocean", "coriolis", "tilt", "contact")]
    works.append(-last["dissipation_seabed"])
    change = last["kinetic"] - first["kinetic"]
    assert last["dissipation_seabed"] > 0.01 * first["kinetic"]
    assert abs(change - sum(works)) < 1e-11 * sum(abs(w) for w in works)


@pytest.mark.mpi
def test_the_seabed_on_two_ranks(tmp_path: Path) -> None:
    (one, _), (two, _) = (
        run_parts("engine_ranks.py", tmp_path / str(n), n, 200, "grounded") for n in (1, 2)
    )
    assert one["sum.dissipation_seabed"] > 0.0
    for name in ("dissipation_seabed", "impulse_seabed_x", "impulse_seabed_y"):
        np.testing.assert_allclose(two[f"sum.{name}"], one[f"sum.{name}"], rtol=1e-9)
    for name in ("element.x", "element.u"):
        scale = np.ptp(one[name])
        np.testing.assert_allclose(two[name], one[name], rtol=0, atol=1e-9 * scale)


SCENE = """
effects: [wind, ocean_drag, friction{more}]
domain: {{x_min: 0.0, x_max: 4.0e4, y_min: 0.0, y_max: 4.0e4, spacing: 1.0e4}}
time: {{window: 3600.0}}
forcing: {{step: 3600.0, cyclone: {{x: -4.0e5, y: 2.0e4, u: 0.0, v: 0.0, wind_speed: 8.0}}}}
dynamics: {{samples: 4}}
grounding: {{{keys}}}
"""


def a_scene(more: str = ", grounding", keys: str = "depth: 1.5") -> Scene:
    return parse_scene(SCENE.format(more=more, keys=keys).encode(), "shallow")


def moved(scene: Scene, folder: Path) -> tuple[xr.Dataset, xr.Dataset]:
    """State at the end of a window, and its series."""
    state, forcing = make_state(scene, a_packing(), None), window_forcing(scene, 1, folder)
    done = advance_window(SELF, scene, state, forcing, folder / "log", lambda **_: None)
    return done.state, done.series


def test_a_scene_holds_its_thick_ice(tmp_path: Path) -> None:
    held, series = moved(a_scene(), tmp_path)
    free, plain = moved(a_scene("", ""), tmp_path)
    thick = held["ice_volume"].values[:, 0] > 1.5 / K1 + 0.05
    speed, drift = (np.hypot(s["u"], s["v"]).values for s in (held, free))
    assert 20 < thick.sum() < 36
    assert speed[thick].max() < 0.01 < drift[thick].min()
    # What is not named leaves nothing.
    assert set(held.variables) == set(free.variables)
    assert expected_variables(("wind", "grounding")) == expected_variables(("wind",))
    assert not [name for name in plain.data_vars if "seabed" in str(name)]
    assert "seabed" not in engine_params(a_scene("", "")).fix_style()
    for name in ("impulse_seabed_x", "dissipation_seabed"):
        assert abs(float(series[name])) > 0.0
    run = series.expand_dims("window")
    for axis in "xy":
        assert (momentum_budget(run, axis).relative < 1e-10).all()
    kinetic, elastic = (
        (run[name][:, -1] - run[name][:, 0]).values for name in ("kinetic_energy", "elastic_energy")
    )
    energy = dem_energy_budget(run, kinetic, elastic)
    assert energy is not None and (energy.relative < 0.02).all()


def test_the_strength_is_that_of_the_keys(tmp_path: Path) -> None:
    weak, _ = moved(a_scene(keys="depth: 1.5, strength: 0.0"), tmp_path)
    free, _ = moved(a_scene("", ""), tmp_path)
    np.testing.assert_array_equal(weak["u"], free["u"])


@pytest.mark.parametrize(
    ("keys", "sentence"),
    [
        ("", "'grounding' needs grounding.file or a grounding.depth above 0"),
        ("depth: -1.0", "grounding.depth"),
        ("dept: 1.0", "did you mean 'grounding.depth'"),
        ("depth: 5.0, creep: 0.0", "grounding.creep"),
    ],
)
def test_bad_keys_are_refused(keys: str, sentence: str) -> None:
    with pytest.raises(FloeError, match=sentence):
        a_scene(keys=keys)


def test_a_force_of_no_number_is_refused() -> None:
    with pytest.raises(FloeError, match="seabed_strength must be finite"):
        Force("seabed", (("seabed_strength", math.nan),))
