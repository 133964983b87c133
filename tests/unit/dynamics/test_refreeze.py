# SPDX-License-Identifier: GPL-2.0-or-later
"""Elements that stay in touch in the cold freeze together, without a jump of force."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI

from floeflow.dynamics.bonds.refreeze import Cold, freeze, refreeze, thicken, touch_times
from floeflow.dynamics.engine.engine import Engine
from floeflow.state.bonds import Arrays, empty_pairs
from floeflow.state.schema import check_state
from support.full_ice import full_params
from support.rafts import bonded, discs
from unit.state.test_state import a_state

DAY = 86400.0
COLD = Cold(DAY, 263.15, 0.05, 271.3, 1.33e-8)
PARAMS = full_params(time_step=0.1, bonds=True, friction=False, bond_damping=0.0)


def winter(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return np.full(len(x), 251.3)


def summer(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return np.full(len(x), 270.0)


def contact(*pairs: tuple[int, int], touch: float = 0.0) -> Arrays:
    table = empty_pairs(("slip", "rest_overlap"))
    table |= {"id_lo": np.array([p[0] for p in pairs]), "id_hi": np.array([p[1] for p in pairs])}
    zero = np.zeros(len(pairs))
    return table | {"slip": zero, "rest_overlap": zero.copy(), "touch_time": zero + touch}


def first_impulse(elements: Arrays, bonds: Arrays | None, contacts: Arrays | None, log: Path):
    """Velocities after a step from rest."""
    with Engine(MPI.COMM_SELF, PARAMS, log) as engine:
        engine.load(elements, bonds, contacts)
        engine.run(1)
        out = engine.elements()
    return np.concatenate([out["u"], out["v"]])


def test_touch_counts_windows_in_the_cold_only() -> None:
    row = discs([0.0, 1999.0, 3998.0, 6500.0], [0.0] * 4)
    table = contact((1, 2), (2, 3), (3, 4))
    old = contact((1, 2), (3, 4), touch=5.0)
    assert touch_times(table, old, row, winter, COLD, 100.0).tolist() == [105.0, 0.0, 0.0]
    assert touch_times(table, old, row, summer, COLD, 100.0).tolist() == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("overlap", [0.01, 0.0])
def test_a_pair_freezes_without_a_jump_of_force(tmp_path: Path, overlap: float) -> None:
    pair = discs([0.0, (2000.0 - overlap) * 0.6], [0.0, (2000.0 - overlap) * 0.8])
    pair["theta"] = np.array([0.3, -1.2])
    table = contact((1, 2), touch=DAY)
    thick = Cold(DAY, 263.15, 0.5, 271.3, 1.33e-8)
    made, healed = freeze(table, pair, thick, PARAMS)
    assert healed.tolist() == [True] and made["thickness"].tolist() == [0.5]
    before = first_impulse(pair, None, table, tmp_path / "log")
    after = first_impulse(pair, made, None, tmp_path / "log")
    assert (np.abs(before).max() > 0) == (overlap > 0)
    np.testing.assert_allclose(after, before, rtol=0, atol=1e-7 * np.abs(before).max())
    # A soft new bond takes over the contact's energy, not its force.
    made, _ = freeze(table, pair, COLD, PARAMS)
    with Engine(MPI.COMM_SELF, PARAMS, tmp_path / "log") as engine:
        engine.load(pair, None, table)
        energy = engine.diagnostics()["elastic_contact"]
        engine.load(pair, made)
        assert engine.diagnostics()["elastic_bond"] == pytest.approx(energy, rel=1e-6, abs=1e-6)


def test_what_does_not_freeze() -> None:
    pair = discs([0.0, 1999.99], [0.0, 0.0])
    assert not freeze(contact((1, 2), touch=0.9 * DAY), pair, COLD, PARAMS)[1].any()
    assert freeze(contact((1, 2), touch=DAY), pair, COLD, PARAMS)[1].all()
    coast = pair | {"type": np.array([2, 1])}
    assert not freeze(contact((1, 2), touch=DAY), coast, COLD, PARAMS)[1].any()
    fast = replace(COLD, to_coast=True)
    assert freeze(contact((1, 2), touch=DAY), coast, fast, PARAMS)[1].all()
    land = pair | {"type": np.array([2, 2])}
    assert not freeze(contact((1, 2), touch=DAY), land, fast, PARAMS)[1].any()
    bare = pair | {"thickness": np.array([1.0, 0.0])}
    assert not freeze(contact((1, 2), touch=DAY), bare, COLD, PARAMS)[1].any()
    pressed = pair | {"x": np.array([0.0, 1990.0])}
    assert not freeze(contact((1, 2), touch=DAY), pressed, COLD, PARAMS)[1].any()


def test_bonds_thicken_by_stefan_s_law_and_keep_their_force(tmp_path: Path) -> None:
    pair = discs([0.0, 2000.0], [0.0, 0.0])
    table = bonded(pair) | {"thickness": np.array([0.1])}
    pair |= {"x": np.array([0.0, 2000.05]), "y": np.array([0.0, -0.03])}
    pair["theta"] = np.array([2e-5, -1e-5])
    grown = thicken(table, pair, winter, COLD, DAY)
    assert grown["thickness"][0] == pytest.approx(np.sqrt(0.01 + 1.33e-8 * 20.0 * DAY))
    before, after = (first_impulse(pair, t, None, tmp_path / "log") for t in (table, grown))
    np.testing.assert_allclose(after, before, rtol=0, atol=1e-7 * np.abs(before).max())
    assert thicken(table, pair, winter, COLD, 1e9)["thickness"].tolist() == [1.0]
    assert thicken(table, pair, lambda x, y: 0 * x + 280.0, COLD, DAY)["thickness"][0] == 0.1
    thicker = table | {"thickness": np.array([2.0])}
    assert thicken(thicker, pair, winter, COLD, DAY)["thickness"][0] == 2.0


def test_a_state_with_new_bonds_is_a_state() -> None:
    state = a_state(("bonds", "refreeze", "thermodynamics"))
    row = discs(1999.999 * np.arange(4), np.zeros(4))
    for name in ("type", "x", "y", "theta", "radius"):
        state[name] = ("element", row[name])
    state["ice_volume"].values[:] = 1.0
    state = state.isel(bond=[0, 2])  # 1-2 and 3-4
    state["contact_id_lo"], state["contact_id_hi"] = ("contact", [2]), ("contact", [3])
    state["contact_rest_overlap"].values[:] = 0.0
    after, formed = refreeze(state, contact((2, 3), touch=DAY), winter, COLD, PARAMS, 10.0)
    check_state(after)
    assert formed == 1 and after.sizes == {**state.sizes, "bond": 3, "contact": 0}
    assert after["bond_id_lo"].values.tolist() == [1, 2, 3]
    later, formed = refreeze(state, contact((2, 3), touch=5.0), winter, COLD, PARAMS, 10.0)
    check_state(later)
    assert formed == 0 and later["contact_touch_time"].values.tolist() == [15.0]


def test_fast_ice_forms_and_thickens_beside_the_coast() -> None:
    state = a_state(("bonds", "refreeze", "thermodynamics"))
    row = discs(1999.999 * np.arange(4), np.zeros(4))
    for name in ("x", "y", "theta", "radius"):
        state[name] = ("element", row[name])
    state["type"] = ("element", np.array([1, 1, 1, 2], np.int8))
    state["ice_volume"].values[:] = [[1.0], [0.8], [0.5], [0.0]]
    state = state.isel(bond=[0])
    state["contact_id_lo"], state["contact_id_hi"] = ("contact", [3]), ("contact", [4])
    state["contact_rest_overlap"].values[:] = 0.0
    state["bond_thickness"].values[:] = 0.8
    old = contact((3, 4), touch=DAY)
    assert refreeze(state, old, winter, COLD, PARAMS, 10.0)[1] == 0
    fast, formed = refreeze(state, old, winter, replace(COLD, to_coast=True), PARAMS, 10.0)
    check_state(fast)
    assert formed == 1 and fast["bond_id_hi"].values.tolist() == [2, 4]
    assert fast["bond_thickness"].values.tolist() == [0.8, COLD.thickness]
    # It grows by Stefan's law to the ice's own thickness: the coast, which has no ice, is no limit.
    later = refreeze(fast, old, winter, COLD, PARAMS, DAY)[0]
    grown = np.sqrt(COLD.thickness**2 + COLD.growth * 20.0 * DAY)
    assert later["bond_thickness"].values[1] == pytest.approx(grown)
    late = refreeze(fast, old, winter, COLD, PARAMS, 1e9)[0]
    assert late["bond_thickness"].values.tolist() == [0.8, 0.5]
