# SPDX-License-Identifier: GPL-2.0-or-later
"""One writer a scene: who holds it is named, and a lock dies with its process."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest

from floeflow.core.errors import FloeError
from floeflow.core.lock import claim_scene, clear_stale_locks, hold_alone, hold_job, join_run

HOLDER = """
import sys
from pathlib import Path
from floeflow.core import lock
folder = Path(sys.argv[2])
held = lock.join_run(folder) if sys.argv[1] == "job" else lock.claim_scene(folder)
print("held", flush=True)
sys.stdin.read()
"""


@pytest.fixture(autouse=True)
def no_run(monkeypatch: pytest.MonkeyPatch) -> None:
    """Claiming a scene sets the id of the run in the environment: it goes with the test."""
    monkeypatch.setenv("FLOEFLOW_RUN", "")


@pytest.fixture
def holder():
    """Start processes that hold a lock until they are ended."""
    started = []

    def start(kind: str, folder: Path) -> subprocess.Popen[str]:
        command = [sys.executable, "-c", HOLDER, kind, str(folder)]
        process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        started.append(process)
        assert process.stdout is not None and process.stdout.readline() == "held\n"
        return process

    yield start
    for process in started:
        process.kill()
        process.communicate()


def test_a_second_run_is_told_who_holds_the_scene(tmp_path: Path, holder):
    process = holder("run", tmp_path)
    with pytest.raises(FloeError, match=f"another run holds this scene .process {process.pid}"):
        claim_scene(tmp_path)


def test_a_job_that_outlived_its_run_is_waited_for(tmp_path: Path, holder):
    job = holder("job", tmp_path)
    command = [sys.executable, "-c", HOLDER, "run", str(tmp_path)]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as run:
        assert run.stderr is not None and run.stdout is not None
        told = f"a job of an earlier run still writes this scene (process {job.pid}); waiting"
        assert told in run.stderr.readline()
        job.kill()
        assert run.stdout.readline() == "held\n"
        run.kill()


def test_a_job_that_was_left_behind_in_a_queue_writes_nothing(tmp_path: Path, monkeypatch):
    os.close(claim_scene(tmp_path))
    with hold_job(tmp_path):
        pass
    for mine, told in (("host-1-abc", "host-1-abc"), ("", "without an id")):
        monkeypatch.setenv("FLOEFLOW_RUN", mine)
        with pytest.raises(FloeError, match=rf"this job is of an earlier run \({told}\)"):
            join_run(tmp_path)


def test_the_owner_of_a_lock_is_told_with_its_host_and_its_job(tmp_path: Path, holder):
    process = holder("run", tmp_path)
    (tmp_path / ".lock").write_text("77 node7 4711\n")
    with pytest.raises(FloeError, match="process 77 on node7, Slurm job 4711"):
        claim_scene(tmp_path)
    process.kill()


def test_a_file_system_without_locks_is_told(tmp_path: Path, monkeypatch):
    def refuse(handle: int, mode: int) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr("fcntl.flock", refuse)
    with pytest.raises(FloeError, match=f"file system of {tmp_path}/.lock has no locks"):
        claim_scene(tmp_path)


def test_locks_that_other_processes_do_not_see_are_told(tmp_path: Path, monkeypatch):
    monkeypatch.setattr("fcntl.flock", lambda handle, mode: None)
    with pytest.raises(FloeError, match="not seen by other processes"):
        claim_scene(tmp_path)


def test_a_lock_dies_with_its_process(tmp_path: Path, holder):
    process = holder("run", tmp_path)
    process.kill()
    process.wait()
    os.close(claim_scene(tmp_path))


def test_jobs_of_one_run_work_side_by_side(tmp_path: Path, holder):
    run = claim_scene(tmp_path)
    holder("job", tmp_path)
    with hold_job(tmp_path):
        pass
    os.close(run)


def test_a_window_is_written_by_one_job(tmp_path: Path):
    with (
        hold_alone(tmp_path / "w.lock", "window 0001"),
        pytest.raises(FloeError, match=f"window 0001 is being written by process {os.getpid()}"),
        hold_alone(tmp_path / "w.lock", "window 0001"),
    ):
        pass
    with hold_alone(tmp_path / "w.lock", "window 0001"):
        pass


def test_only_the_scene_s_stale_locks_are_cleared(tmp_path: Path):
    locks = tmp_path / "locks"
    locks.mkdir()
    (locks / "0.output.lock").write_text("results/a/state/0001.nc\n")
    (locks / "1.output.lock").write_text("results/ab/state/0001.nc\n")
    assert clear_stale_locks(Path("results/a"), tmp_path) == 1
    assert [path.name for path in locks.iterdir()] == ["1.output.lock"]


def test_a_place_that_cannot_be_locked_is_named(tmp_path: Path):
    (tmp_path / ".lock").mkdir()
    with pytest.raises(FloeError, match="cannot be locked: Is a directory"):
        claim_scene(tmp_path)


def test_results_that_cannot_be_written_are_named(tmp_path: Path, monkeypatch):
    def refuse(self: Path, **options: bool) -> None:
        raise OSError(errno.EROFS, "Read-only file system")

    monkeypatch.setattr(Path, "mkdir", refuse)
    with pytest.raises(FloeError, match=f"{tmp_path}: cannot be written: Read-only file system"):
        claim_scene(tmp_path)
