# SPDX-License-Identifier: GPL-2.0-or-later
"""What starts the ranks of a window: mpirun on one machine, the profile's words on a cluster."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import pytest

from floeflow.core.errors import FloeError
from floeflow.workflow.job import ALONE, check_room, launcher_of


def test_on_one_machine_threads_are_ranks(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.delenv("SLURM_JOB_ID", raising=False)
    job = SimpleNamespace(threads=2, resources={"mpi": "", "tasks": 40})
    assert launcher_of(job) == (("mpirun",), 2)
    assert launcher_of(SimpleNamespace(threads=1, resources={})) == (("mpirun",), 1)


def test_one_machine_inside_of_an_allocation_asks_slurm_for_nothing(
    monkeypatch: pytest.MonkeyPatch,
):
    monkeypatch.setenv("SLURM_JOB_ID", "7")
    job = SimpleNamespace(threads=2, resources={})
    assert launcher_of(job) == (("mpirun", *ALONE), 2)


def test_on_a_cluster_tasks_are_ranks():
    job = SimpleNamespace(threads=1, resources={"mpi": "srun --mpi=pmix", "tasks": 40})
    assert launcher_of(job) == (("srun", "--mpi=pmix"), 40)


def test_a_full_disk_is_told_before_a_job_begins(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    check_room(tmp_path)
    full = SimpleNamespace(f_bavail=1000, f_frsize=4096)
    monkeypatch.setattr("os.statvfs", lambda folder: full)
    with pytest.raises(FloeError, match=f"{tmp_path}: the disk is full .4 MB are left"):
        check_room(tmp_path)
