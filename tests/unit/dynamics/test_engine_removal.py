# SPDX-License-Identifier: GPL-2.0-or-later
"""Elements that are taken out or go far away take their bonds along, and nothing else."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI

from floeflow.core.errors import FloeError
from floeflow.dynamics.engine.engine import Engine
from floeflow.state import walls
from floeflow.state.bonds import without
from support.full_ice import full_params
from support.rafts import bonded, discs, lattice, uniform

SELF = MPI.COMM_SELF


def test_removed_elements_take_their_bonds_along(tmp_path: Path) -> None:
    """In the midst of fracture, against a wall; what is left goes on as if alone from the start."""
    raft = lattice(10, 8)
    raft["u"] = -4e-5 * raft["x"] + 0.2
    params = full_params(time_step=0.2, bonds=True, ridging=True, compressive_strength=3e5)
    faces = walls.plane(-1000.0, 0.0, (1.0, 0.0), (0.3, 0.0))
    gone = np.array([5, 33, 34, 35, 80])
    with Engine(SELF, params, tmp_path / "log", faces) as engine:
        engine.load(raft, bonded(raft))
        engine.run(500)
        assert engine.diagnostics()["bonds_broken"] > 0
        tables = engine.elements(), engine.bonds(), engine.contacts(), engine.wall_contacts()
        assert all(len(next(iter(table.values()))) for table in tables)
        engine.remove(gone)
        left = engine.bonds()
        assert len(left["id_lo"]) < len(tables[1]["id_lo"])
        for name, values in without(tables[1], gone).items():
            np.testing.assert_array_equal(left[name], values, err_msg=name)
        engine.run(500)
        out, bonds = engine.elements(), engine.bonds()
    assert not np.isin(gone, out["id"]).any() and len(out["id"]) == 75
    rest, table, contacts, held = (without(t, gone) for t in tables)
    with Engine(SELF, params, tmp_path / "log2", faces) as engine:
        engine.load(rest, table, contacts, 100.0, held)
        engine.run(500)
        for name, values in engine.elements().items():
            np.testing.assert_array_equal(out[name], values, err_msg=name)
        np.testing.assert_array_equal(bonds["id_hi"], engine.bonds()["id_hi"])


def test_the_last_element_cannot_be_removed(tmp_path: Path) -> None:
    with Engine(SELF, full_params(time_step=1.0), tmp_path / "log") as engine:
        engine.load(discs([0.0], [0.0]))
        with pytest.raises(FloeError, match="There are no elements"):
            engine.remove(np.array([1]))


def test_elements_may_leave_the_box_with_their_bonds(tmp_path: Path) -> None:
    """Two rafts fly apart until they are a hundred widths away, past the forcing's edge."""
    one, two = lattice(4, 3), lattice(4, 3)
    two["x"] += 20e3
    both = {name: np.concatenate([one[name], two[name]]) for name in one}
    both |= {"id": np.arange(1, 25), "u": np.repeat([-50.0, 50.0], 12)}
    table = bonded(both)
    params = full_params(time_step=0.5, bonds=True, wind=True, wind_stress_factor=1e-3)
    with Engine(SELF, params, tmp_path / "log") as engine:
        engine.load(both, table)
        engine.set_forcing(uniform((0.0, 5.0)))
        engine.run(40_000)
        out, left = engine.elements(), engine.bonds()
    np.testing.assert_array_equal(left["id_hi"], table["id_hi"])
    assert np.ptp(out["x"]) > 1.9e6
    inside = np.hypot(out["x"][:12] - out["x"][0], out["y"][:12] - out["y"][0])
    np.testing.assert_allclose(inside, np.hypot(one["x"], one["y"]), atol=1.0)
