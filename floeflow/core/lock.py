# SPDX-License-Identifier: GPL-2.0-or-later
"""One writer for each scene.

A workflow holds ``results/<scene>/.lock`` alone; its jobs share ``results/<scene>/.jobs.lock``.
Snakemake closes all file descriptors of its children, so they cannot inherit its lock; a workflow
therefore waits until no job of an earlier, killed workflow holds the second lock. Locks are
``flock`` locks: the kernel drops them with the process, however it dies, so none is ever stale.

A job that waits in a cluster's queue can hold no lock. Each workflow therefore has an id: it is
written to ``results/<scene>/.run`` and travels in the environment of its jobs. A job compares the
two under the jobs' lock before it writes anything: one left behind in the queue ends there.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import functools
import os
import socket
import subprocess
import sys
import uuid
from collections.abc import Iterator
from pathlib import Path

from floeflow.core.atomic_write import write_text
from floeflow.core.errors import FloeError

RUN_LOCK, JOB_LOCK, RUN_ID = ".lock", ".jobs.lock", ".run"
# Carries the id of a workflow to its jobs.
RUN_VARIABLE = "FLOEFLOW_RUN"
NO_LOCKS = (errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP, errno.EINVAL)


@functools.cache
def run_id() -> str:
    """Id of this workflow, the same for all its scenes."""
    return f"{socket.gethostname()}-{os.getpid()}-{uuid.uuid4().hex}"


def claim_scene(folder: Path) -> int:
    """Take a scene's run lock for the life of this process; return its file descriptor.

    Waits, with a sentence on standard error, for jobs that outlived an earlier workflow. Those that
    have not begun end when they do, as the scene has the id of this workflow from now on.

    Parameters
    ----------
    folder : Path
        ``results/<scene>``, which is made.

    Returns
    -------
    int
        File descriptor; the lock ends with it.

    Raises
    ------
    FloeError
        Where another workflow holds the scene; names the process. Where the file system has no
        locks.
    """
    _make(folder)
    run = _open(folder / RUN_LOCK)
    if not _try(run, fcntl.LOCK_EX):
        pid = _owner(run)
        os.close(run)
        raise FloeError(f"{folder}: another run holds this scene (process {pid}); nothing was done")
    _probe(folder / RUN_LOCK)
    _sign(run)
    # Before the wait: what starts after this line is refused, what runs already is waited for.
    write_text(f"{run_id()}\n", folder / RUN_ID)
    os.environ[RUN_VARIABLE] = run_id()
    jobs = _open(folder / JOB_LOCK)
    if not _try(jobs, fcntl.LOCK_EX):
        print(
            f"floeflow: {folder}: a job of an earlier run still writes this scene (process "
            f"{_owner(jobs)}); waiting until it ends",
            file=sys.stderr,
            flush=True,
        )
        fcntl.flock(jobs, fcntl.LOCK_EX)
    os.close(jobs)
    return run


def join_run(folder: Path) -> int:
    """Share the job lock of a scene; return its file descriptor.

    Parameters
    ----------
    folder : Path
        ``results/<scene>``; a variant ``<scene>+...`` is written under the lock of its base scene.

    Returns
    -------
    int
        File descriptor; the lock ends with it.

    Raises
    ------
    FloeError
        Where the scene has gone over to another workflow than the one that this job is of.
    """
    folder = folder.with_name(folder.name.partition("+")[0])
    _make(folder)
    jobs = _open(folder / JOB_LOCK)
    # Blocks only for the moment in which a workflow asks whether jobs are left.
    fcntl.flock(jobs, fcntl.LOCK_SH)
    try:
        wanted = (folder / RUN_ID).read_text(encoding="utf-8").strip()
    except FileNotFoundError:
        wanted = ""
    mine = os.environ.get(RUN_VARIABLE, "")
    if wanted and mine != wanted:
        os.close(jobs)
        raise FloeError(
            f"{folder}: this job is of an earlier run ({mine or 'without an id'}) and the scene is "
            f"now that of {wanted}; nothing was written"
        )
    _sign(jobs)
    return jobs


@contextlib.contextmanager
def hold_job(folder: Path) -> Iterator[int]:
    """Share a scene's job lock, see `join_run`; yields the descriptor, for children to inherit.

    Parameters
    ----------
    folder : Path
        ``results/<scene>``.

    Yields
    ------
    int
        File descriptor.
    """
    jobs = join_run(folder)
    try:
        yield jobs
    finally:
        os.close(jobs)


@contextlib.contextmanager
def hold_alone(path: Path, what: str) -> Iterator[int]:
    """Hold a lock file alone; yields the descriptor, for children to inherit.

    Parameters
    ----------
    path : Path
        Lock file, made where it is missing.
    what : str
        What it guards, for the message.

    Yields
    ------
    int
        File descriptor.

    Raises
    ------
    FloeError
        Where another process holds it; names `what` and the process.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    handle = _open(path)
    if not _try(handle, fcntl.LOCK_EX):
        pid = _owner(handle)
        os.close(handle)
        raise FloeError(f"{what} is being written by process {pid}")
    _sign(handle)
    try:
        yield handle
    finally:
        os.close(handle)


def clear_stale_locks(folder: Path, snakemake_folder: Path = Path(".snakemake")) -> int:
    """Remove Snakemake's own locks on files of a scene; only the scene's holder may call this.

    Snakemake keeps the names of locked files in ``.snakemake/locks``; after ``kill -9`` they stay.

    Parameters
    ----------
    folder : Path
        Results of the scene, relative to Snakemake's working folder.
    snakemake_folder : Path, optional
        Where Snakemake keeps its records.

    Returns
    -------
    int
        Number of lock files removed.
    """
    prefix = f"{folder.as_posix()}/"
    stale = []
    for path in sorted((snakemake_folder / "locks").glob("*.lock")):
        with contextlib.suppress(OSError):
            if any(line.startswith(prefix) for line in path.read_text().splitlines()):
                stale.append(path)
    for path in stale:
        path.unlink(missing_ok=True)
    return len(stale)


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FloeError(f"{folder}: cannot be written: {error.strerror}") from None


def _open(path: Path) -> int:
    try:
        return os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
    except OSError as error:
        raise FloeError(f"{path}: cannot be locked: {error.strerror}") from None


def _try(handle: int, mode: int) -> bool:
    try:
        fcntl.flock(handle, mode | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError as error:
        if error.errno not in NO_LOCKS:
            raise
        raise FloeError(
            f"the file system of {os.readlink(f'/proc/self/fd/{handle}')} has no locks (flock: "
            f"{error.strerror}): run where it has, or mount it with them (docs/how-to/cluster.md)"
        ) from None
    return True


def _probe(path: Path) -> None:
    """Refuse a file system on which another process does not see this one's lock."""
    try:
        done = subprocess.run(["flock", "--nonblock", str(path), "true"], check=False)
    except OSError:
        return
    if done.returncode == 0:
        raise FloeError(
            f"{path}: locks of this file system are not seen by other processes: run where they "
            "are, or mount it with them (docs/how-to/cluster.md)"
        )


def _sign(handle: int) -> None:
    os.ftruncate(handle, 0)
    job = os.environ.get("SLURM_JOB_ID", "")
    text = f"{os.getpid()} {socket.gethostname()} {job}".strip()
    os.pwrite(handle, f"{text}\n".encode(), 0)


def _owner(handle: int) -> str:
    """The process that signed a lock file, with its host and its job in the queue where it has."""
    words = os.pread(handle, 512, 0).decode(errors="replace").split()
    if not words:
        return "unknown"
    pid, host, job = [*words, "", ""][:3]
    where = f" on {host}" if host and host != socket.gethostname() else ""
    return f"{pid}{where}{f', Slurm job {job}' if job else ''}"
