# SPDX-License-Identifier: GPL-2.0-or-later
"""Run by test_engine_mpi.py under mpirun: a raft is loaded, run, written, loaded again, run."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from mpi4py import MPI

from floeflow.dynamics.engine.engine import Engine
from floeflow.dynamics.engine.params import Force
from floeflow.state import walls
from floeflow.state.bonds import Arrays
from support.full_ice import full_params
from support.rafts import bonded, lattice, uniform
from support.ranks import read_tables, write_part


def main(out: Path, steps: int, kind: str, start: Path | None) -> None:
    """Write elements, bonds, contacts and sums after some steps, and after as many more."""
    walled = kind in ("walls", "few")
    raft = lattice(20, 15) if kind != "few" else lattice(3, 1)
    random = np.random.default_rng(11)
    raft["thickness"] = random.uniform(0.5, 2.0, len(raft["id"]))
    raft["mass"] = raft["mass"] * raft["thickness"]
    raft["type"][raft["y"] == 0] = 1 if kind == "few" else 2
    raft["u"] = np.where(raft["type"] == 2, 0.0, -3e-5 * raft["x"] + 0.4)
    if kind == "few":  # against the wall at the left
        raft["u"][:] = -0.4
    table = bonded(raft)
    coast = (raft["type"][table["id_lo"] - 1] == 2) & (raft["type"][table["id_hi"] - 1] == 2)
    state: list[Arrays | None] = [raft, {n: v[~coast] for n, v in table.items()}, None, None]
    if start is not None:
        state = read_tables(start)
    if kind == "adrift":  # so fast that all lists are made anew and elements change their ranks
        raft["u"] = 40.0 * (1.0 + 1e-3 * raft["id"])
        raft["type"][:] = 1
        state[1] = {name: values[:0] for name, values in table.items()}
    if kind == "lopsided":  # the raft fills a small part of the box
        raft = {name: np.append(values, values[-1:]) for name, values in raft.items()}
        raft["id"][-1] = len(raft["id"])
        raft["x"][-1] += 200_000.0
        state[0] = raft
    switches = dict.fromkeys(("bonds", "wind", "ocean_drag", "coriolis", "tilt"), True)
    if kind == "adrift":
        switches = {}
    # Elements of more than 1.25 m are held by a sea of 10 m.
    seabed = (Force("seabed", (), ("sea_floor_depth",)),) if kind == "grounded" else ()
    params = full_params(time_step=0.2, ridging=walled, forces=seabed, **switches)
    # One wall stands, one comes from the right, and a bent one dents the upper side.
    dent = np.array([[[1.5e4, 4e4], [2e4, 2.525e4]], [[2e4, 2.525e4], [2.5e4, 4e4]]])
    faces = walls.join(
        [
            walls.plane(-1000.0, 0.0, (1.0, 0.0)),
            walls.plane(40_000.0, 0.0, (-1.0, 0.0), (-1.5, 0.1)),
            walls.lines(dent, (0.0, -1.0)),
        ]
    )
    comm = MPI.COMM_WORLD
    with Engine(comm, params, out / f"log.{comm.size}", faces if walled else None) as engine:
        for k, part in enumerate(("first", "second"), start=start is not None):
            engine.load(*state[:3], 0.2 * steps * k, state[3])
            engine.set_forcing(uniform((10.0, 5.0), (0.1, 0.1), 1.4e-4, depth=10.0))
            engine.run(steps)
            state = write_part(out / f"{part}.npz", engine)


if __name__ == "__main__":
    folder, count, kind, *rest = sys.argv[1:]
    main(Path(folder), int(count), kind, Path(rest[0]) if rest else None)
