# SPDX-License-Identifier: GPL-2.0-or-later
"""Stress in the ice and the force that it makes: closed forms, and what balances momentum."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from mpi4py import MPI

from floeflow.coupling.coupled_windows import advance_window
from floeflow.coupling.initial import make_state
from floeflow.dynamics.engine.engine import Engine, EngineError, EngineParams
from floeflow.dynamics.motion import with_stress
from floeflow.forcings.window import window_forcing
from floeflow.scene.load import build_scene
from floeflow.state import walls
from floeflow.state.bonds import Arrays
from floeflow.state.schema import check_state
from support.full_ice import full_params
from support.rafts import bonded, discs, lattice, uniform
from support.ranks import run_parts
from unit.coupling.test_walls import a_packing

SELF = MPI.COMM_SELF
RADIUS, THICK = 1000.0, 0.8
STIFFNESS = 1e8 * THICK  # contact modulus times thickness, of one disc against a wall
STEP = 0.1


def inside(folder: Path, elements: Arrays, params: EngineParams, **more: Arrays) -> Arrays:
    """Internal forces of elements as they are loaded."""
    with Engine(SELF, params, folder / "log", more.pop("walls", None)) as engine:
        engine.load(elements, **more)
        return engine.internal_forces()


def test_two_pressed_discs_push_each_other_along_their_line(tmp_path: Path) -> None:
    angle, overlap = 0.4, 5.0
    way = (2 * RADIUS - overlap) * np.array([np.cos(angle), np.sin(angle)])
    pair = discs([0.0, way[0]], [0.0, way[1]], thickness=THICK)
    found = inside(tmp_path, pair, full_params(time_step=STEP, friction=False))
    push = 0.5 * STIFFNESS * overlap  # two discs in series
    along = np.array([np.cos(angle), np.sin(angle)])
    np.testing.assert_allclose([found["force_x"][1], found["force_y"][1]], push * along, rtol=1e-9)
    # Compression: each disc's arm is half of the way.
    arm = -0.5 * push * (2 * RADIUS - overlap)
    for name, share in (
        ("moment_xx", along[0] ** 2),
        ("moment_yy", along[1] ** 2),
        ("moment_xy", along[0] * along[1]),
    ):
        np.testing.assert_allclose(found[name], arm * share, rtol=1e-9, err_msg=name)
    # The invariants do not see the axes: half of the only stress each.
    xx, yy, xy = (found[f"moment_{pair}"] for pair in ("xx", "yy", "xy"))
    np.testing.assert_allclose(0.5 * (xx + yy), 0.5 * arm, rtol=1e-9)
    np.testing.assert_allclose(np.hypot(0.5 * (xx - yy), xy), -0.5 * arm, rtol=1e-9)


def test_a_wall_pushes_a_disc_and_presses_it(tmp_path: Path) -> None:
    disc = discs([995.0, 9e3], [300.0, 0.0], thickness=THICK)
    disc["type"][1] = 2
    face = walls.join([walls.plane(0.0, 0.0, (1.0, 0.0))])
    found = inside(tmp_path, disc, full_params(STEP, friction=False, walls=True), walls=face)
    np.testing.assert_allclose(found["force_x"], [5.0 * STIFFNESS, 0.0], rtol=1e-9)
    np.testing.assert_allclose(found["moment_xx"], [-995.0 * 5.0 * STIFFNESS, 0.0], rtol=1e-9)
    assert not found["force_y"].any() and not found["moment_yy"].any()


def test_a_stretched_row_of_bonds_carries_one_force(tmp_path: Path) -> None:
    """Uniaxial tension: the same force through each line, none on the discs in the middle."""
    row = discs(2 * RADIUS * np.arange(5.0), np.zeros(5), thickness=THICK)
    table = bonded(row)
    strain = 1e-6
    row["x"] *= 1.0 + strain
    params = full_params(STEP, friction=False, bonds=True)
    found = inside(tmp_path, row, params, bonds=table)
    pull = params.young_modulus * strain * THICK * float(table["length"][0])
    ends = pull * np.array([1, 0, 0, 0, -1])
    np.testing.assert_allclose(found["force_x"], ends, atol=1e-4 * pull)
    middle = slice(1, 4)
    np.testing.assert_allclose(found["moment_xx"][middle], 2 * RADIUS * pull, rtol=1e-4)
    np.testing.assert_allclose(found["moment_xx"][[0, 4]], RADIUS * pull, rtol=1e-4)
    for name in ("moment_yy", "moment_xy", "force_y"):
        assert np.abs(found[name]).max() < 1e-9 * RADIUS * pull


def test_the_force_is_what_momentum_lacks(tmp_path: Path) -> None:
    """The residual of the balance: what wind and water do not account for, in each element."""
    raft = lattice(6, 5)
    random = np.random.default_rng(5)
    raft["u"], raft["v"] = 0.02 * random.normal(size=(2, len(raft["id"])))
    params = full_params(STEP, bonds=True, wind=True, ocean_drag=True)
    with Engine(SELF, params, tmp_path / "log") as engine:
        engine.load(raft, bonded(raft))
        engine.set_forcing(uniform((8.0, -3.0), (0.1, 0.05)))
        engine.run(200)
        before, force = engine.elements(), engine.internal_forces()
        engine.run(1)
        after = engine.elements()
    scale = np.hypot(force["force_x"], force["force_y"]).max()
    for axis, speed in (("x", "u"), ("y", "v")):
        gained = before["mass"] * (after[speed] - before[speed])
        given = sum(
            after[f"{name}_impulse_{axis}"] - before[f"{name}_impulse_{axis}"]
            for name in ("wind", "ocean")
        )
        residual = (gained - given) / STEP
        np.testing.assert_allclose(force[f"force_{axis}"], residual, atol=1e-6 * scale)
        # Neighbours take what they give.
        assert abs(force[f"force_{axis}"].sum()) < 1e-9 * scale * len(raft["id"])


def test_nothing_is_told_of_no_elements(tmp_path: Path) -> None:
    engine = Engine(SELF, full_params(STEP), tmp_path / "log")
    with pytest.raises(EngineError, match="holds no elements"):
        engine.internal_forces()


@pytest.mark.mpi
def test_two_ranks_find_the_forces_of_one(tmp_path: Path) -> None:
    (one, _), (two, _) = (
        run_parts("engine_ranks.py", tmp_path / str(n), n, 20, "walls") for n in (1, 2)
    )
    for name in (name for name in one if name.startswith("internal.")):
        scale = np.abs(one[name]).max()
        assert scale > 0.0, name
        np.testing.assert_allclose(two[name], one[name], rtol=0, atol=1e-6 * scale, err_msg=name)


def test_a_scene_keeps_them_where_it_names_them(tmp_path: Path) -> None:
    """The same ice to the bit, and the stress beside it."""
    ends = []
    for more in ([], ["internal_stress"]):
        scene = build_scene(
            {
                "name": "a",
                "effects": ["wind", "friction", *more],
                "domain": {f"{a}_{e}": s for a in "xy" for e, s in (("min", 0.0), ("max", 4e4))}
                | {"spacing": 1e4},
                "time": {"window": 3600.0},
                "forcing": {"step": 3600.0},
                "dynamics": {"samples": 2},
            }
        )
        state, forcing = make_state(scene, a_packing(), None), window_forcing(scene, 1, tmp_path)
        # Towards each other.
        state["u"] = -0.2 * np.sign(state["x"] - state["x"].mean())
        ends.append(advance_window(SELF, scene, state, forcing, tmp_path / "log", lambda **_: None))
    plain, told = (done.state for done in ends)
    check_state(told)
    new = set(map(str, told.data_vars)) - set(map(str, plain.data_vars))
    assert new == {"internal_force_x", "internal_force_y", "stress_xx", "stress_yy", "stress_xy"}
    assert told.drop_vars(new).drop_attrs().identical(plain.drop_attrs())
    assert float(told["stress_xx"].min()) < 0.0


def test_stress_is_per_area_and_the_coast_has_none() -> None:
    state = xr.Dataset({"area": ("element", [2.0, 0.0])})
    names = ("force_x", "force_y", "moment_xx", "moment_yy", "moment_xy")
    found = with_stress(state, {name: np.array([6.0, 5.0]) for name in names})
    np.testing.assert_array_equal(found["stress_xy"], [3.0, 0.0])
    np.testing.assert_array_equal(found["internal_force_y"], [3.0, 0.0])
