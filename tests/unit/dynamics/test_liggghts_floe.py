# SPDX-License-Identifier: GPL-2.0-or-later
"""LIGGGHTS with the models built in, and the example script for those who write their own."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path

import pytest

from support.ranks import run_liggghts

FOLDER = Path("liggghts_models") / "examples"


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [1, 2])
def test_the_example_drifts_as_fast_as_the_wind_makes_it(
    project: Path, tmp_path: Path, ranks: int
) -> None:
    done = run_liggghts(tmp_path, project / FOLDER / "in.bonded_raft", ranks)
    assert done.returncode == 0, done.stderr
    # 10 rows of 12 discs: 10 x 11 neighbours along the rows, 9 x 23 between them
    assert "floe_bonds: 317 bonds" in done.stdout
    drift = re.search(r"^drift (\S+) m/s", done.stdout, re.MULTILINE)
    assert drift is not None
    assert float(drift[1]) == pytest.approx(30 * math.sqrt(1.56e-3 / 5.643), rel=1e-6)


@pytest.mark.mpi
def test_a_wrong_keyword_and_a_fault_end_the_run_with_a_sentence(
    project: Path, tmp_path: Path
) -> None:
    text = (project / FOLDER / "in.bonded_raft").read_text()
    wrong = tmp_path / "in.wrong"
    wrong.write_text(text.replace("friction_coefficient", "frction_coefficient"))
    done = run_liggghts(tmp_path, wrong, 1)
    assert done.returncode != 0
    assert "pair_style gran model floe: unknown keyword frction_coefficient" in done.stdout
    wild = tmp_path / "in.wild"
    wild.write_text(text.replace("timestep        0.4", "timestep        40"))
    done = run_liggghts(tmp_path, wild, 1)
    assert done.returncode != 0
    assert re.search(r"Element \d+ moves further than its radius in a step at \(", done.stdout)


def raft_without(gone: Callable[[float, float], bool]) -> tuple[int, int]:
    """Elements and bonds of the example's raft without those at some (x, y) in lattice units."""
    places = [(i + 0.5 * (j % 2), 0.5 * j) for j in range(10) for i in range(12)]
    left = [(x, y * math.sqrt(3)) for x, y in places if not gone(x, y)]
    return len(left), sum(math.dist(a, b) < 1.01 for k, a in enumerate(left) for b in left[:k])


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [1, 2])
def test_elements_that_are_removed_or_leave_take_their_bonds_along(
    project: Path, tmp_path: Path, ranks: int
) -> None:
    setup, rest = (project / FOLDER / "in.bonded_raft").read_text().split("run             108000")
    removed = tmp_path / "in.removed"
    strong = setup.replace("compressive_strength 1e4", "compressive_strength 1e7")
    removed.write_text(
        f"{strong}run 2000\nregion hole block 5.9 8.1 -0.1 2.3 INF INF units lattice\n"
        "group gone region hole\ndelete_atoms group gone compress no\n"
        f"run 2000\nfloe_bonds gap 0.5 thickness 1\nrun 2000\n{rest}"
    )
    done = run_liggghts(tmp_path, removed, ranks)
    assert done.returncode == 0, done.stderr
    elements, bonds = raft_without(lambda x, y: 5.9 < x < 8.1 and y < 2.3)
    after = done.stdout.split("Deleted")[1]
    assert f"{120 - elements} atoms, new total = {elements}" in after and elements < 120
    assert f"floe_bonds: {bonds} bonds" in after
    # A box with an edge close to the raft: it drifts over it.
    leaving = tmp_path / "in.leaving"
    text = setup.replace("boundary        m m p", "boundary        f f p")
    text = text.replace("block -3 16 -3 9", "block -3 11.8 -3 9")
    leaving.write_text(
        text.replace("thermo          100000", "thermo_modify lost ignore") + "run 8000\n" + rest
    )
    done = run_liggghts(tmp_path, leaving, ranks)
    assert done.returncode == 0, done.stderr
    assert re.search(r"Loop time .* with (1[01]\d) atoms", done.stdout)
