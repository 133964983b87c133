# SPDX-License-Identifier: GPL-2.0-or-later
"""What a frozen bond bears: strength grows with its ice, cracks freeze again, files keep it all."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from mpi4py import MPI

from floeflow.dynamics.bonds.refreeze import freeze, heal, refreeze, thicken
from floeflow.dynamics.engine.engine import Engine
from floeflow.state import read_state, write_state
from floeflow.state.bonds import Arrays
from floeflow.state.elements import element_arrays, moved_state, pair_arrays
from support.full_ice import full_params
from support.rafts import bonded, discs
from unit.dynamics.test_refreeze import COLD, DAY, contact, summer, winter
from unit.state.test_state import a_state

EFFECTS = ("friction", "bonds", "ridging", "refreeze", "thermodynamics", "snow")
PULL = full_params(
    time_step=0.02, bonds=True, friction=False, bond_damping=0.0, compressive_strength=1e6,
    tensile_share=0.1,
)  # fmt: skip


def strength(pair: Arrays, table: Arrays, log: Path) -> float:
    """Largest force (N) with which element 2 pulls while it leaves element 1."""
    pulled = {name: values.copy() for name, values in pair.items()}
    pulled["type"][0], pulled["mass"][1], pulled["u"][1] = 2, 1e27, 0.01
    largest = last = 0.0
    with Engine(MPI.COMM_SELF, PULL, log) as engine:
        engine.load(pulled, table)
        for _ in range(400):
            engine.run(5)
            impulse = engine.diagnostics()["impulse_fixed_x"]
            largest, last = max(largest, abs(impulse - last) / (5 * PULL.time_step)), impulse
            if len(engine.bonds()["id_lo"]) == 0:
                return largest
    raise AssertionError("the bond does not break")


def test_the_strength_of_a_frozen_crack_grows_with_its_ice(tmp_path: Path) -> None:
    pair = discs([0.0, 2000.0], [0.0, 0.0])
    table, _ = freeze(contact((1, 2), touch=DAY), pair, COLD, PULL)
    length, bears = table["length"][0], []
    for days in (0.0, 1.0, 10.0):
        grown = thicken(table, pair, winter, COLD, days * DAY)
        thickness = math.sqrt(COLD.thickness**2 + COLD.growth * 20.0 * days * DAY)
        bears.append(strength(pair, grown, tmp_path / "log"))
        # Within 1e-3 m, the way between two looks, of 0.2 m at which it breaks.
        assert bears[-1] == pytest.approx(1e5 * thickness * length, rel=1e-2)
    assert bears[0] < 0.4 * bears[1] < 0.2 * bears[2]


def test_a_cracked_part_bears_nothing_until_it_freezes_again(tmp_path: Path) -> None:
    pair = discs([0.0, 2000.0], [0.0, 0.0], thickness=0.3)
    whole = bonded(pair)
    cracked = whole | {"crack_a": np.array([0.3]), "crack_b": np.array([0.2])}
    bears = strength(pair, whole, tmp_path / "log")
    assert strength(pair, cracked, tmp_path / "log") == pytest.approx(0.5 * bears, rel=1e-2)
    # By 1/e in a third of the time in which 0.3 m of ice grows, and in the end to nothing.
    time = 0.09 / (COLD.growth * 20.0) / 3
    later = heal(cracked, pair, winter, COLD, time, PULL)
    assert later["crack_a"][0] == pytest.approx(0.3 / math.e)
    assert later["crack_b"][0] == pytest.approx(0.2 / math.e)
    assert later["thickness"][0] == 0.3
    now = (1 - 0.5 / math.e) * bears
    assert strength(pair, later, tmp_path / "log") == pytest.approx(now, rel=1e-2)
    closed = heal(cracked, pair, winter, COLD, 10 * time, PULL)
    assert closed["crack_a"][0] == closed["crack_b"][0] == 0.0
    assert strength(pair, closed, tmp_path / "log") == pytest.approx(bears, rel=1e-2)
    same = heal(cracked, pair, summer, replace(COLD, freezing_point=270.0), time, PULL)
    for name in same:
        np.testing.assert_array_equal(same[name], cracked[name], name)


def kick(pair: Arrays, table: Arrays, log: Path) -> np.ndarray:
    """Speeds (m/s) after a step from rest; those of spins at the radius."""
    with Engine(MPI.COMM_SELF, PULL, log) as engine:
        engine.load(pair, table)
        engine.run(1)
        out = engine.elements()
    return np.concatenate([out["u"], out["v"], out["omega"] * out["radius"]])


@pytest.mark.parametrize("seed", range(4))
def test_a_crack_closes_without_a_jump_of_force(tmp_path: Path, seed: int) -> None:
    random = np.random.default_rng(seed)
    pair = discs([0.0, 1300.0], [0.0, 1700.0], [1000.0, 1200.0], [0.7, 1.4])
    pair["theta"][:] = random.uniform(-3, 3, 2)
    table = bonded(pair, gap=100.0)
    for name, size in (("x", 0.02), ("y", 0.02), ("theta", 2e-5)):
        pair[name] = pair[name] + random.uniform(-size, size, 2)
    crack = random.uniform(0.05, 0.45, 2)
    table |= {"crack_a": crack[:1], "crack_b": crack[1:]}
    before = kick(pair, table, tmp_path / "log")
    closed = heal(table, pair, winter, COLD, 5 * DAY, PULL)
    assert (closed["crack_a"] < table["crack_a"]).all()
    after = kick(pair, closed, tmp_path / "log")
    np.testing.assert_allclose(after, before, rtol=0, atol=1e-6 * np.abs(before).max())


def test_a_crack_does_not_close_where_the_line_would_bear_too_much(tmp_path: Path) -> None:
    # Cracked over half of its length, in even tension: a whole line would bear it off its middle,
    # with 1.25 times the stress at one end.
    pair = discs([0.0, 2000.0], [0.0, 0.0], thickness=0.3)
    table = bonded(pair) | {"crack_a": np.array([0.5])}
    for tension, closes in ((0.39, True), (0.41, False)):
        pair["x"][1] = 2000.0 + tension * 0.2  # m; the strength is met at 0.2 m
        later = heal(table, pair, winter, COLD, 1e9, PULL)
        assert later["crack_a"][0] == (0.0 if closes else 0.5)
        np.testing.assert_allclose(
            kick(pair, later, tmp_path / "log"), kick(pair, table, tmp_path / "log"), atol=1e-12
        )


def pack() -> xr.Dataset:
    """A row of elements pressed together between two of the coast."""
    row = discs(1999.995 * np.arange(6), np.zeros(6), thickness=np.linspace(0.3, 1.5, 6))
    row["type"][[0, 5]] = 2
    state = a_state(EFFECTS, n=6).isel(bond=slice(0, 0), contact=slice(0, 0))
    for name in ("type", "x", "y", "theta", "u", "v", "omega", "radius"):
        state[name] = ("element", row[name])
    mobile = row["type"] == 1
    state["area"] = ("element", np.where(mobile, row["ice_area"], 0.0))
    for name, value in (("ice_fraction", 1.0), ("ice_volume", row["thickness"])):
        state[name].values[:, 0] = np.where(mobile, value, 0.0)
    state["snow_volume"].values[:] = 0.0
    state.attrs |= {"ocean_area": float(state["area"].sum()), "unclaimed_water": 0.0}
    return state


LAWS = full_params(time_step=0.1, bonds=True, ridging=True, friction=True, compressive_strength=1e5)


def window(state: xr.Dataset, log: Path) -> tuple[xr.Dataset, int]:
    touched = pair_arrays(state, "contact")
    with Engine(MPI.COMM_SELF, LAWS, log) as engine:
        engine.load(element_arrays(state, 1e-3), pair_arrays(state, "bond"), touched)
        engine.run(400)
        tables = (engine.elements(), engine.bonds(), engine.contacts())
    moved = moved_state(state, *tables)
    # Two windows in touch are enough.
    cold = replace(COLD, touch_time=80.0, to_coast=True)
    return refreeze(moved, touched, winter, cold, LAWS, 40.0)


def test_states_on_disk_keep_what_is_freezing(tmp_path: Path) -> None:
    in_memory = on_disk = pack()
    formed = []
    for k in range(5):
        in_memory, new = window(in_memory, tmp_path / "log")
        if k == 3:  # one bond is cracked on its way
            in_memory["bond_crack_a"].values[0] = 0.25
        formed.append(new)
    for k in range(5):
        on_disk, _ = window(on_disk, tmp_path / "log")
        if k == 3:
            on_disk["bond_crack_a"].values[0] = 0.25
        write_state(on_disk, tmp_path / f"{k}.nc")
        on_disk = read_state(tmp_path / f"{k}.nc")
    # Contacts first age, then freeze, and later bonds thicken.
    assert formed[0] == 0 < sum(formed)
    assert 0.2 < in_memory["bond_crack_a"].values[0] < 0.25
    assert in_memory["bond_thickness"].values.max() > COLD.thickness
    for name in in_memory.variables:
        np.testing.assert_array_equal(on_disk[name].values, in_memory[name].values, str(name))
