# SPDX-License-Identifier: GPL-2.0-or-later
"""LIGGGHTS with the models built in, and the example script for those who write their own."""

from __future__ import annotations

import math
import re
import subprocess
from pathlib import Path

import pytest

from floeflow.dynamics.pluginlib import plugin_path
from floeflow.mpi import mpi_environment

FOLDER = Path("liggghts_models") / "examples"


def run(project: Path, folder: Path, script: str, ranks: int) -> subprocess.CompletedProcess[str]:
    program = plugin_path().with_name("liggghts-floe")
    command = ["mpirun", "-n", str(ranks), str(program), "-in", script]
    return subprocess.run(
        command,
        cwd=folder,
        env=mpi_environment(),
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
    )


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [1, 2])
def test_the_example_drifts_as_fast_as_the_wind_makes_it(
    project: Path, tmp_path: Path, ranks: int
) -> None:
    done = run(project, tmp_path, str(project / FOLDER / "in.bonded_raft"), ranks)
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
    done = run(project, tmp_path, str(wrong), 1)
    assert done.returncode != 0
    assert "pair_style gran model floe: unknown keyword frction_coefficient" in done.stdout
    wild = tmp_path / "in.wild"
    wild.write_text(text.replace("timestep        0.4", "timestep        40"))
    done = run(project, tmp_path, str(wild), 1)
    assert done.returncode != 0
    assert re.search(r"Element \d+ moves further than its radius in a step at \(", done.stdout)
