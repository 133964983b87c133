# SPDX-License-Identifier: GPL-2.0-or-later
"""The workflow of one machine, started inside of an allocation, as a step of it."""

from __future__ import annotations

import subprocess

import pytest

from floeflow.state import read_state
from support.runner import STREAMS, Done, bits, digest

pytestmark = [pytest.mark.cluster, pytest.mark.workflow]

TARGET = "results/smoke/state/0003.nc"
# Only a run that hangs takes so long.
PATIENCE = 600  # s


def test_its_ranks_start_inside_of_a_step(smoke: Done, undone):
    """On one task of two cores, where a step that mpirun asks Slurm for would wait for ever."""
    cluster = undone()
    place = cluster.place
    limits = ["--ntasks=1", "--cpus-per-task=2", "--time=20", f"--chdir={place.folder}"]
    command = ["srun", *limits, *place.command(smoke.scene, 2, TARGET)]
    done = subprocess.run(
        command, check=False, env=cluster.slurm.environment, timeout=PATIENCE, **STREAMS
    )
    assert done.returncode == 0, done.stdout
    ends = [read_state(results / "state/0003.nc") for results in (place.results(), smoke.results)]
    assert bits(place.results()) == bits(smoke.results) and digest(ends[0]) == digest(ends[1])
