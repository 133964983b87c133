# SPDX-License-Identifier: GPL-2.0-or-later
"""What a window's job says: events of the ranks, progress, the sentence of a fault."""

from __future__ import annotations

import io
import logging
import os
from pathlib import Path

import pytest

from floeflow.core.errors import FloeError
from floeflow.coupling import launch as window
from floeflow.coupling import progress
from floeflow.coupling.job import Job
from floeflow.scene import parse_scene

EVENT = {"window": "0002", "step": 25, "steps": 100, "elements": 40, "dynamics_seconds": 2.0}


@pytest.fixture
def job(tmp_path: Path) -> Job:
    """A job whose state does not exist."""
    scene = parse_scene(b"", "a").model_dump(mode="json")
    none = str(tmp_path / "none.nc")
    return Job(scene, none, ["0001"], 0, ["hash"], str(tmp_path), {})


def test_events_are_told_apart_on_one_line(caplog: pytest.LogCaptureFixture):
    with caplog.at_level(logging.INFO):
        assert list(window._events('{"error": "a"}{"error": "b"}\n')) == [
            {"error": "a"},
            {"error": "b"},
        ]
        assert list(window._events("mpirun says something\n")) == []
    assert "mpirun says something" in caplog.text


def test_progress_tells_speed_and_time_left():
    assert progress.line(EVENT) == (
        "window 0002: step 25 of 100 (25%), 500 element-steps/s, 6 s left"
    )


def test_progress_outlives_its_terminal(monkeypatch: pytest.MonkeyPatch):
    class Gone(io.StringIO):
        def write(self, _: str) -> int:
            raise BrokenPipeError

    monkeypatch.setattr("sys.stderr", Gone())
    with progress.show_progress(4) as show:
        show(EVENT)


def test_a_job_survives_its_way_to_the_ranks(job: Job):
    again = Job.from_json(job.to_json())
    assert again == job
    assert again.read_scene() == parse_scene(b"", "a")


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [1, 2])
def test_a_fault_of_the_ranks_is_one_sentence(job: Job, tmp_path: Path, ranks: int):
    with pytest.raises(FloeError, match=r"none\.nc: there is no such file$"):
        window.run_ranks(job, ranks, tmp_path / "ranks.log")


def test_ranks_that_say_nothing_are_quoted_from_their_log(job: Job, tmp_path: Path):
    log = tmp_path / "ranks.log"
    log.write_text("noise\nERROR: Out of range atoms (../x.cpp:3)\nnoise\n")
    assert "ERROR: Out of range atoms" in window._last_words(job, log, 1)
    log.write_text("LIGGGHTS: a bond is lost\nMPI_ABORT was invoked\n[vm:1] Set MCA parameter\n")
    assert "LIGGGHTS: a bond is lost" in window._last_words(job, log, 1)
    log.write_text("noise\n")
    assert "ended with code 7: noise (see " in window._last_words(job, log, 7)


def test_the_box_of_mpi_is_a_sentence(job: Job, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    log, line = tmp_path / "ranks.log", "-" * 74
    for name in [name for name in os.environ if name.startswith("OMPI_MCA_")]:
        monkeypatch.delenv(name)
    monkeypatch.setenv("OMPI_MCA_btl", "nonsense")
    log.write_text(
        f"{line}\nPrimary job  terminated normally, but 1 process returned\na non-zero exit code.\n"
        f"{line}\n{line}\nmpirun noticed that process rank 1 with PID 7 on node a exited on\n"
        f"signal 9 (Killed).\n{line}\n[a:7] more help\n"
    )
    assert window._last_words(job, log, 137) == (
        "the ranks ended with code 137, and MPI says: mpirun noticed that process rank 1 with PID "
        "7 on node a exited on signal 9 (Killed); set in the environment: OMPI_MCA_btl=nonsense "
        f"(see {log})"
    )


def test_a_launcher_that_is_not_there_is_named(job: Job, tmp_path: Path):
    with pytest.raises(FloeError, match="no-srun cannot be started: No such file"):
        window.run_ranks(job, 2, tmp_path / "ranks.log", ("no-srun", "--mpi=pmix"))


def test_a_launcher_is_given_its_ranks(job: Job, tmp_path: Path):
    words = tmp_path / "words"
    launcher = tmp_path / "srun"
    launcher.write_text(f'#!/bin/sh\necho "$*" > {words}\ncat > /dev/null\n')
    launcher.chmod(0o755)
    window.run_ranks(job, 3, tmp_path / "ranks.log", (str(launcher), "--mpi=pmix"))
    assert words.read_text().startswith("--mpi=pmix -n 3 ")
    assert words.read_text().endswith(" -m floeflow.coupling.coupled_windows\n")
