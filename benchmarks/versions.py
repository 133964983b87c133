# SPDX-License-Identifier: GPL-2.0-or-later
"""Versions of the element model that run in turn, each from a folder of its own.

Each runs in its own process with its own library and plugin, and is told when it is its turn.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from floeflow.core.errors import FloeError
from floeflow.core.mpi import mpi_environment

PLUGIN = Path("build") / "liggghts_models" / "libfloe.so"
# Runs in `benchmarks/` of a version: rafts by name, then steps of them as asked for.
WORKER = """
import sys, tempfile, time
from pathlib import Path
from mpi4py import MPI
from demcases import Own
sizes = eval(sys.argv[1])
with tempfile.TemporaryDirectory() as folder:
    rafts = {}
    for name, (size, bonds) in sizes.items():
        rafts[name] = Own(MPI.COMM_SELF, size, Path(folder), bonds=bonds, friction=True).__enter__()
        rafts[name].run(2)
    print("ready", flush=True)
    for line in sys.stdin:
        name, steps = line.split()
        start = time.perf_counter()
        rafts[name].run(int(steps))
        print(time.perf_counter() - start, flush=True)
"""


class Version:
    """A version of the program with some rafts, in a process of its own.

    Parameters
    ----------
    folder : Path
        Checkout, with its plugin built.
    rafts : dict
        Size and whether bonded, by name.
    """

    def __init__(self, folder: Path, rafts: dict[str, tuple[tuple[int, int], bool]]) -> None:
        folder = folder.resolve()
        if not (folder / PLUGIN).exists():
            raise FloeError(f"{folder}: there is no {PLUGIN}; run `make setup` there.")
        env = mpi_environment() | {"FLOEFLOW_PLUGIN": str(folder / PLUGIN)}
        env["PYTHONPATH"] = os.pathsep.join([str(folder / "benchmarks"), str(folder)])
        self._process = subprocess.Popen(
            [sys.executable, "-c", WORKER, repr(rafts)],
            cwd=folder,
            env=env,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        if self._answer() != "ready":
            raise FloeError(f"{folder}: its rafts did not start; its words are above.")

    def __enter__(self) -> Version:
        return self

    def __exit__(self, *_: object) -> None:
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait()

    def _answer(self) -> str:
        assert self._process.stdout is not None
        return self._process.stdout.readline().strip()

    def seconds(self, raft: str, steps: int) -> float:
        """Wall seconds of steps of a raft."""
        assert self._process.stdin is not None
        self._process.stdin.write(f"{raft} {steps}\n")
        self._process.stdin.flush()
        return float(self._answer())
