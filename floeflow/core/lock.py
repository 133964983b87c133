# SPDX-License-Identifier: GPL-2.0-or-later
"""One writer for each scene.

A workflow holds ``results/<scene>/.lock`` alone; its jobs share ``results/<scene>/.jobs.lock``.
Snakemake closes all file descriptors of its children, so they cannot inherit its lock; a workflow
therefore also asks whether a job of an earlier, killed workflow still holds the second lock. Locks
are ``flock`` locks: the kernel drops them with the process, however it dies, so none is ever stale.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
from collections.abc import Iterator
from pathlib import Path

from floeflow.core.errors import FloeError

RUN_LOCK, JOB_LOCK = ".lock", ".jobs.lock"


def claim_scene(folder: Path) -> int:
    """Take a scene's run lock for the life of this process; return its file descriptor.

    Raises
    ------
    FloeError
        Where another workflow, or a job that outlived one, holds the scene; names the process.
    """
    folder.mkdir(parents=True, exist_ok=True)
    run = _open(folder / RUN_LOCK)
    if not _try(run, fcntl.LOCK_EX):
        pid = _owner(run)
        os.close(run)
        raise FloeError(f"{folder}: another run holds this scene (process {pid}); nothing was done")
    jobs = _open(folder / JOB_LOCK)
    free = _try(jobs, fcntl.LOCK_EX)
    pid = _owner(jobs)
    os.close(jobs)
    if not free:
        os.close(run)
        raise FloeError(
            f"{folder}: a job of an earlier run still writes this scene (process {pid}); wait for "
            "it or end it, then run the same command again"
        )
    _sign(run)
    return run


@contextlib.contextmanager
def hold_job(folder: Path) -> Iterator[int]:
    """Share a scene's job lock; yields the descriptor, for children to inherit."""
    folder.mkdir(parents=True, exist_ok=True)
    jobs = _open(folder / JOB_LOCK)
    # Blocks only for the moment in which a workflow asks whether jobs are left.
    fcntl.flock(jobs, fcntl.LOCK_SH)
    _sign(jobs)
    try:
        yield jobs
    finally:
        os.close(jobs)


@contextlib.contextmanager
def hold_alone(path: Path, what: str) -> Iterator[int]:
    """Hold a lock file alone; yields the descriptor, for children to inherit.

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
    return True


def _sign(handle: int) -> None:
    os.ftruncate(handle, 0)
    os.pwrite(handle, f"{os.getpid()}\n".encode(), 0)


def _owner(handle: int) -> str:
    return os.pread(handle, 32, 0).decode(errors="replace").strip() or "unknown"
