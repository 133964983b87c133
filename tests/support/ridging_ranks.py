# SPDX-License-Identifier: GPL-2.0-or-later
"""Run by test_ridging_mpi.py under mpirun: a bonded pack is crushed against a coast and ridges."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from mpi4py import MPI

from floeflow.dynamics.engine.engine import Engine
from floeflow.state.bonds import Arrays
from support.full_ice import full_params
from support.rafts import bonded, lattice
from support.ranks import read_tables, write_part


def crushed(columns: int = 16, rows: int = 12) -> list[Arrays]:
    """Thin ice that runs into a coast in the west, bonded in its eastern half."""
    raft = lattice(columns, rows)
    count = len(raft["id"])
    raft["thickness"] = np.random.default_rng(3).uniform(0.1, 0.6, count)
    raft["mass"] = raft["mass"] * raft["thickness"]
    raft["type"][raft["x"] < 1100.0] = 2
    raft["u"] = np.where(raft["type"] == 2, 0.0, -0.5)
    table = bonded(raft)
    east = (raft["x"] > raft["x"].mean())[table["id_lo"] - 1]
    return [raft, {name: values[east] for name, values in table.items()}]


def main(out: Path, start: Path | None) -> None:
    """Write elements, bonds, contacts and sums after 500 steps, and after 500 more."""
    state: list[Arrays | None] = [*crushed(), None]
    if start is not None:
        state = read_tables(start)
    params = full_params(time_step=0.2, bonds=True, ridging=True, compressive_strength=1e5)
    comm = MPI.COMM_WORLD
    with Engine(comm, params, out / f"log.{comm.size}") as engine:
        for part in ("first", "second"):
            engine.load(*state[:3])
            engine.run(500)
            state = write_part(out / f"{part}.npz", engine)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]) if len(sys.argv) > 2 else None)
