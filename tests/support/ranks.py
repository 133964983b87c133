# SPDX-License-Identifier: GPL-2.0-or-later
"""Scripts under mpirun, LIGGGHTS with the models built in, and the tables that go in and out."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from floeflow.core.mpi import mpi_environment
from floeflow.core.plugin import plugin_path
from floeflow.dynamics.engine.engine import Engine
from floeflow.state.bonds import Arrays

KINDS = ("element", "bond", "contact", "wall")

# Helpers are imported as ``support.x``.
TESTS = str(Path(__file__).resolve().parents[1])


def mpirun(ranks: int, command: Sequence[object], folder: Path) -> subprocess.CompletedProcess[str]:
    """A program on some ranks, in a folder."""
    return subprocess.run(
        ["mpirun", "-n", str(ranks), *map(str, command)],
        cwd=folder,
        env=mpi_environment() | {"PYTHONPATH": TESTS},
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
    )


def run_liggghts(folder: Path, script: object, ranks: int) -> subprocess.CompletedProcess[str]:
    """LIGGGHTS with the models built in, in a folder."""
    return mpirun(ranks, [plugin_path().with_name("liggghts-floe"), "-in", script], folder)


def run_parts(script: str, folder: Path, ranks: int, *words: object) -> tuple[Arrays, Arrays]:
    """What a script beside this file writes as its first and second part, see `write_part`."""
    folder.mkdir(parents=True, exist_ok=True)
    path = Path(__file__).with_name(script)
    done = mpirun(ranks, [sys.executable, path, folder, *words], folder)
    assert done.returncode == 0, done.stderr
    first, second = (read_part(folder / f"{part}.npz") for part in ("first", "second"))
    return first, second


def read_part(path: Path) -> Arrays:
    """Columns by kind and name, such as ``bond.span``."""
    with np.load(path) as data:
        return {name: data[name] for name in data.files}


def read_tables(path: Path) -> list[Arrays]:
    """Tables of all kinds, as `Engine.load` takes them."""
    data = read_part(path)
    return [
        {
            name.removeprefix(f"{kind}."): values
            for name, values in data.items()
            if name.startswith(f"{kind}.")
        }
        for kind in KINDS
    ]


def write_part(path: Path, engine: Engine) -> list[Arrays]:
    """Write an engine's tables and sums on the first rank; the tables, as `read_tables`."""
    tables = [engine.elements(), engine.bonds(), engine.contacts(), engine.wall_contacts()]
    sums = {f"sum.{name}": value for name, value in engine.diagnostics().items()}
    named = {
        f"{kind}.{name}": values
        for kind, table in zip(KINDS, tables, strict=True)
        for name, values in table.items()
    }
    named |= {f"internal.{name}": values for name, values in engine.internal_forces().items()}
    if engine.comm.rank == 0:
        np.savez(path, **named, **sums)
    return tables
