# SPDX-License-Identifier: GPL-2.0-or-later
"""Ways in which a run dies in the middle of a window."""

from __future__ import annotations

import fcntl
import os
import shutil
import signal
from pathlib import Path

from support.runner import Place, drain, kill_all, kill_alone, make_place, paused, read_until

MODES = ("group", "snakemake", "rank", "job", "power")


def start_over(place: Place) -> None:
    """Undo the windows of a finished run."""
    for folder in ("state", "series", "elements", "cost", "fields", ".windows"):
        for path in (place.results() / folder).glob("*"):
            if path.name != "0000.nc":
                shutil.rmtree(path) if path.is_dir() else path.unlink()


def kill_inside(place: Place, scene: Path, target: str, mode: str, line: str) -> Place:
    """Start a run and kill it when its windows have said a line; where to go on.

    Parameters
    ----------
    place : Place
        Where it runs.
    scene, target
        What it runs.
    mode : str
        ``group``: all processes at once; ``snakemake`` alone, whose jobs live on; ``rank``: the
        first rank; ``job``: the window's script; ``power``: all stop, and what the disk has then is
        all that there is.
    line : str
        Part of a line of the windows' progress.
    """
    run = place.start(scene, target)
    read_until(run, line)
    if mode == "group":
        kill_all(run)
    elif mode == "snakemake":
        kill_alone(run)
    elif mode == "power":
        with paused(run):
            rest = make_place(place.folder.with_name("rest"), like=place)
        kill_all(run)
        return rest
    else:
        words = {"rank": b"coupled_windows", "job": b"windows.py"}[mode]
        # The first one: the launcher mpirun has the rank's words, too.
        found = [pid for pid in members(run.pid) if words in command(pid) and not launches(pid)]
        os.kill(found[0], signal.SIGKILL)
        said = drain(run)
        assert run.returncode == 1, said
    return place


def wait_for_jobs(place: Place) -> None:
    """Wait until no job or rank of the scene is left: until the jobs' lock can be had."""
    with open(place.results() / ".jobs.lock") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)


def members(session: int) -> list[int]:
    """Processes of a session, oldest first."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                if os.getsid(int(entry.name)) == session:
                    found.append(int(entry.name))
            except ProcessLookupError:
                continue
    return sorted(found)


def command(pid: int) -> bytes:
    """Command line of a process; empty where it is gone."""
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:
        return b""


def launches(pid: int) -> bool:
    """Whether a process is mpirun."""
    return command(pid).split(b"\0")[0].endswith(b"mpirun")
