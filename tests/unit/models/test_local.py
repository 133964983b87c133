# SPDX-License-Identifier: GPL-2.0-or-later
"""Computes of bonds and elements, the log of breakages, the sums of the integrator."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from support.liggghts import BOND, PRINT, discs, raft, run_script

pytestmark = pytest.mark.mpi

SHOW = (
    "compute bond all floe/bond/local\ncompute rows all reduce sum c_bond[5] c_bond[11]\n"
    "compute atom all floe/atom nbond damage\ncompute atoms all reduce sum c_atom[1] c_atom[2]\n"
    "compute worst all reduce max c_bond[7]\n"
    "thermo_style custom step c_rows[1] c_rows[2] c_atoms[1] c_atoms[2] c_worst"
    " f_motion[25] f_motion[26] f_motion[28] f_log\nthermo 100\n" + PRINT
)


@pytest.mark.parametrize("ranks", [1, 2])
def test_bonds_their_energy_and_their_breaking(tmp_path: Path, ranks: int) -> None:
    log = "fix log all floe/breakage 50 file broken.txt\n"
    done = run_script(tmp_path, raft() + log + BOND + SHOW + "run 1000\n", ranks)
    table = done.tables[-1]
    whole, energy, ends, damage, stress, broken, elastic, bonds, logged = (
        table[str(k)] for k in range(1, 10)
    )
    assert bonds[0] == 317 and broken[-1] == logged[-1] > 5
    np.testing.assert_array_equal(bonds + broken, 317)
    np.testing.assert_array_equal(ends, 2 * bonds)
    np.testing.assert_allclose(energy, elastic, rtol=1e-9)
    assert np.all(whole <= bonds) and np.all(damage >= 0.0) and damage[-1] > damage[0] == 0.0
    assert np.all(stress <= 1e3 * (1 + 1e-9))  # no line holds more than its tensile strength
    rows = [line.split() for line in (tmp_path / "broken.txt").read_text().splitlines()]
    assert rows[0][:2] == ["#", "step"] and len(rows) == 1 + broken[-1]
    steps = np.array([int(row[0]) for row in rows[1:]])
    assert np.all(np.diff(steps) >= 0)
    # Cut off the fixed shore by the wind: pulled, at more than what the line can hold.
    for row in rows[1:]:
        assert row[6] == "tension" and 0.0 < float(row[7]) < 2e3 and float(row[10]) > 0.0


def test_the_log_does_not_depend_on_the_ranks(tmp_path: Path) -> None:
    logs = []
    for ranks in (1, 2):
        folder = tmp_path / str(ranks)
        log = "fix log all floe/breakage 1000 file broken.txt\n"
        run_script(folder, raft("deterministic yes") + log + BOND + "run 700\n", ranks)
        logs.append((folder / "broken.txt").read_text())
    assert logs[0] == logs[1] and logs[0].count("\n") > 5


@pytest.mark.parametrize(
    ("velocity", "mode"), [((-1, 0), "compression"), ((0.2, 0), "tension"), ((-0.3, 1), "shear")]
)
def test_a_bond_breaks_by_its_name(
    tmp_path: Path, velocity: tuple[float, float], mode: str
) -> None:
    """A disc bonded to a fixed one is pushed, pulled, and pushed aside."""
    style = (
        "bonds yes bond_young 1e9 contact_young 1e8 compressive_strength 1e6 tensile_share 0.1 "
        "bond_damping 0 reach 1.2"
    )
    script = (
        discs([(0.0, 0.0), (2.0, 0.0)], style)
        + "group fixed id 1\nset group fixed type 2\nfix log all floe/breakage 1 file broken.txt\n"
        + "run 0\nfloe_bonds gap 0.1 thickness 1\ngroup free id 2\n"
        + f"velocity free set {velocity[0]} {velocity[1]} 0 units box\nrun 200\n"
    )
    run_script(tmp_path, script)
    row = (tmp_path / "broken.txt").read_text().splitlines()[1].split()
    normal, shear = float(row[7]), float(row[8])
    assert row[6] == mode and row[2:4] == ["1", "2"]
    if mode == "compression":
        assert normal == pytest.approx(-1e6, rel=0.02)
    elif mode == "tension":
        assert normal == pytest.approx(1e5, rel=0.15)
    else:
        assert normal < 0.0 and abs(shear) > 1e5 * math.tan(math.radians(35.0))


def test_an_unknown_word_is_named(tmp_path: Path) -> None:
    done = run_script(
        tmp_path, raft() + "compute bond all floe/bond/local id1 streess\n", works=False
    )
    assert done.code != 0
    assert "Compute floe/bond/local: unknown word streess; known: id1 id2" in done.out
