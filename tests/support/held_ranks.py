# SPDX-License-Identifier: GPL-2.0-or-later
"""Ranks of a window's job that wait at a gate, so that a test finds them where it wants them.

``FLOEFLOW_MPI="python held_ranks.py FOLDER"`` starts them by srun, as the profile does without it.
They run as ever up to their second window: there the first one writes its process and job into the
pipe of the gate, and all wait until the test lets go of the gate's lock, or dies. With ``hang`` in
front of the folder no rank starts before that.
"""

from __future__ import annotations

import fcntl
import os
import select
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

HELD = 2
PIPE, LOCK, HANG = "arrived", "lock", "hang"
# Only a test that fails waits so long.
PATIENCE = 300.0  # s


class Gate:
    """The side of the test: the gate is closed until `open`."""

    def __init__(self, folder: Path) -> None:
        folder.mkdir()
        os.mkfifo(folder / PIPE)
        # For writing, too: a rank never waits for a reader.
        self._pipe = os.open(folder / PIPE, os.O_RDWR)
        self._lock = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT)
        fcntl.flock(self._lock, fcntl.LOCK_EX)
        program = f"{sys.executable} {Path(__file__).resolve()}"
        self.launcher, self.hanging = f"{program} {folder}", f"{program} {HANG} {folder}"

    def arrived(self) -> tuple[int, int]:
        """Process of the first rank and number of its job in Slurm, once it is there."""
        assert _readable(self._pipe), f"in {PATIENCE:.0f} s no rank came to the gate"
        process, job = os.read(self._pipe, 64).decode().splitlines()[0].split()
        return int(process), int(job)

    def open(self) -> None:
        """Let pass who is there and who comes."""
        fcntl.flock(self._lock, fcntl.LOCK_UN)


def wait_for_end(process: int) -> None:
    """Wait until a process that need not be a child is gone."""
    try:
        handle = os.pidfd_open(process)
    except ProcessLookupError:
        return
    assert _readable(handle), f"process {process} did not end in {PATIENCE:.0f} s"
    os.close(handle)


def _readable(handle: int) -> bool:
    poll = select.poll()
    poll.register(handle, select.POLLIN)
    return bool(poll.poll(1000.0 * PATIENCE))


def wait_at(folder: Path) -> None:
    """Wait until the gate is open."""
    with open(folder / LOCK) as lock:
        fcntl.flock(lock, fcntl.LOCK_SH)


def launch(folder: str, ranks: str) -> None:
    """Become the srun of these ranks."""
    words = ["srun", "--mpi=pmix", "-n", ranks, sys.executable, __file__, folder]
    os.execvp(words[0], words)


def run_rank(folder: Path) -> None:
    """Be a rank, which waits before window `HELD`."""
    from floeflow.coupling import coupled_windows as windows

    on_root: Callable[..., object] = windows.on_root

    def held(comm: windows.MPI.Comm, function: Callable[..., object], *given: object) -> object:
        if function is windows.window_forcing and given[1] == HELD:
            if comm.rank == 0:
                (folder / PIPE).write_text(f"{os.getpid()} {os.environ['SLURM_JOB_ID']}\n")
            wait_at(folder)
        return on_root(comm, function, *given)

    windows.on_root = held
    windows.main()


def main(words: Sequence[str]) -> None:
    """``[hang] FOLDER -n RANKS PROGRAM...`` launches, ``FOLDER`` alone is a rank."""
    if words[0] == HANG:
        words = words[1:]
        wait_at(Path(words[0]))
    if len(words) > 1:
        launch(words[0], words[2])
    else:
        run_rank(Path(words[0]))


if __name__ == "__main__":
    main(sys.argv[1:])
