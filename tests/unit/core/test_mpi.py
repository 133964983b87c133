# SPDX-License-Identifier: GPL-2.0-or-later
"""``mpirun`` starts for root, on few cores, and below a process that uses MPI itself."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from floeflow.core.mpi import mpi_environment

BELOW = """
import subprocess
import sys
from mpi4py import MPI
from floeflow.core.mpi import mpi_environment
# As subprocess has it: MPI changes the environment behind Python's back.
lines = subprocess.run(["env", "-0"], capture_output=True, text=True).stdout.split("\\0")
inherited = dict(line.split("=", 1) for line in lines if line)
assert "PMIX_RANK" in inherited
ranks = subprocess.run(["mpirun", "-n", "3", "echo", "here"], env=mpi_environment(inherited),
                       capture_output=True, text=True)
sys.exit(0 if ranks.stdout == "here\\n" * 3 else ranks.stdout + ranks.stderr)
"""


@pytest.mark.mpi
def test_ranks_start_below_a_process_that_uses_mpi():
    done = subprocess.run([sys.executable, "-c", BELOW], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [1, 2])
def test_ranks_may_run_on_every_core_that_the_caller_has(ranks: int):
    """Bound to the first cores, programs side by side would share these."""
    base = {name: value for name, value in os.environ.items() if not name.startswith("OMPI_MCA_")}
    words = r"import os, sys; sys.stdout.write(f'{sorted(os.sched_getaffinity(0))}\n')"
    done = subprocess.run(
        ["mpirun", "-n", str(ranks), sys.executable, "-c", words],
        env=mpi_environment(base),
        capture_output=True,
        text=True,
    )
    assert done.stdout.splitlines() == [str(sorted(os.sched_getaffinity(0)))] * ranks, done.stderr


def test_the_user_s_own_settings_stay():
    base = {"PMIX_RANK": "0", "OMPI_COMM_WORLD_RANK": "0", "OMPI_MCA_btl": "self", "HOME": "/h"}
    environment = mpi_environment(base)
    assert environment["OMPI_MCA_btl"] == "self" and environment["HOME"] == "/h"
    binding = "OMPI_MCA_hwloc_base_binding_policy"
    assert mpi_environment(base | {binding: "core"})[binding] == "core"
    assert "PMIX_RANK" not in environment and "OMPI_COMM_WORLD_RANK" not in environment
