# SPDX-License-Identifier: GPL-2.0-or-later
"""What a frozen bond bears: its strength grows with its ice, cracks stay, and files keep it all."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from mpi4py import MPI
from rafts import discs
from test_refreeze import COLD, DAY, contact, winter
from test_state import a_state

from floeflow.dynamics.bondtable import Arrays
from floeflow.dynamics.elements import element_arrays, moved_state, pair_arrays
from floeflow.dynamics.engine import Engine, EngineParams
from floeflow.dynamics.refreeze import freeze, refreeze, thicken
from floeflow.state import read_state, write_state

EFFECTS = ("friction", "bonds", "ridging", "refreeze", "thermodynamics")
PULL = EngineParams(
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
        for _ in range(4000):
            engine.run(1)
            impulse = engine.diagnostics()["impulse_fixed_x"]
            largest, last = max(largest, abs(impulse - last) / PULL.time_step), impulse
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
        # Within the step of 2e-4 m, of 0.2 m at which it breaks.
        assert bears[-1] == pytest.approx(1e5 * thickness * length, rel=3e-3)
    assert bears[0] < 0.4 * bears[1] < 0.2 * bears[2]


def test_a_cracked_part_bears_nothing_and_does_not_heal(tmp_path: Path) -> None:
    pair = discs([0.0, 2000.0], [0.0, 0.0])
    table, _ = freeze(contact((1, 2), touch=DAY), pair, COLD, PULL)
    cracked = table | {"crack_a": np.array([0.3]), "crack_b": np.array([0.2])}
    grown = thicken(cracked, pair, winter, COLD, DAY)
    assert grown["crack_a"][0] == 0.3 and grown["crack_b"][0] == 0.2
    whole = strength(pair, thicken(table, pair, winter, COLD, DAY), tmp_path / "log")
    assert strength(pair, grown, tmp_path / "log") == pytest.approx(0.5 * whole, rel=3e-3)


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


LAWS = EngineParams(
    time_step=0.1, bonds=True, ridging=True, friction=True, compressive_strength=1e5
)


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
    assert in_memory["bond_crack_a"].values[0] == 0.25
    assert in_memory["bond_thickness"].values.max() > COLD.thickness
    for name in in_memory.variables:
        np.testing.assert_array_equal(on_disk[name].values, in_memory[name].values, str(name))
