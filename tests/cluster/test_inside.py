# SPDX-License-Identifier: GPL-2.0-or-later
"""The workflow of one machine, started inside of an allocation: in a step of srun, in a batch job."""

from __future__ import annotations

import shlex
import subprocess

import pytest

from floeflow.state import read_state
from support.runner import STREAMS, Done, bits, digest

pytestmark = [pytest.mark.cluster, pytest.mark.workflow]

TARGET = "results/smoke/state/0003.nc"
# Only a run that hangs takes so long.
PATIENCE = 600  # s


@pytest.mark.parametrize("start", ["srun", "sbatch"])
def test_its_ranks_start_inside_of_an_allocation(smoke: Done, undone, start: str):
    """On one task of two cores: a launcher that counts tasks, or asks Slurm for a step, would not."""
    cluster = undone()
    place = cluster.place
    run = place.command(smoke.scene, 2, TARGET)
    limits = ["--ntasks=1", "--cpus-per-task=2", "--time=20", f"--chdir={place.folder}"]
    if start == "srun":
        command = ["srun", *limits, *run]
    else:
        output = f"--output={place.folder}/said.txt"
        command = ["sbatch", "--wait", *limits, output, f"--wrap={shlex.join(run)}"]
    done = subprocess.run(
        command, check=False, env=cluster.slurm.environment, timeout=PATIENCE, **STREAMS
    )
    said = place.folder / "said.txt"
    assert done.returncode == 0, said.read_text() if said.is_file() else done.stdout
    ends = [read_state(results / "state/0003.nc") for results in (place.results(), smoke.results)]
    assert bits(place.results()) == bits(smoke.results) and digest(ends[0]) == digest(ends[1])
