# SPDX-License-Identifier: GPL-2.0-or-later
"""The rafts that the DEM benchmark runs, and the programs that run them.

A raft is a triangular lattice of equal discs that overlap a little, under simple shear and
compression. FloeFlow's engine and stock LIGGGHTS get the same discs, step, skin and contact
stiffness, through the same library in the same process.
"""

from __future__ import annotations

import ctypes
import math
import os
from pathlib import Path
from typing import Literal

import numpy as np
from mpi4py import MPI

from floeflow.core.errors import FloeError
from floeflow.dynamics.engine.engine import Engine, EngineParams
from floeflow.dynamics.engine.params import Forcing
from floeflow.dynamics.engine.plugin import load_plugin, open_liggghts
from floeflow.dynamics.engine.setup import EVEN, PLANE
from floeflow.state.bonds import Arrays, new_bonds

RADIUS, THICKNESS, DENSITY = 1000.0, 1.0, 917.0  # m, m, kg/m3
SPACING = 0.9995  # distance of neighbours over the diameter
# 1/s, compression in both directions, for a raft of this many columns; a wider one is deformed more
# slowly, so that its rim is as fast and its neighbour lists last as long.
SHEAR, COMPRESSION, COLUMNS = 2.0e-6, 5.0e-6, 125
STEP, SKIN = 0.2, 100.0  # s, m
# Pa, and tensile over compressive strength. Strong enough to stay whole, weak enough that the
# neighbour lists hold the bonded pairs alone.
LAWS = {
    "young_modulus": 1.0e9,
    "contact_modulus": 1.0e8,
    "compressive_strength": 1.0e7,
    "tensile_share": 0.1,
}
# Bonded ice is deformed more slowly: it stays whole.
BONDED_RATE = 0.02
# Cells of the forcing (m): most discs meet a line of its nodes.
FORCING_SPACING = 2500.0


def raft(columns: int, rows: int, rate: float = 1.0) -> Arrays:
    """Discs in a lattice, sheared and compressed at `rate` times the usual speeds.

    Returns
    -------
    dict of ndarray, shape (columns * rows,)
        Elements as `Engine.load` takes them.
    """
    i, j = np.meshgrid(np.arange(columns), np.arange(rows))
    n = columns * rows
    spacing = 2.0 * RADIUS * SPACING
    x = spacing * (i + 0.5 * (j % 2)).ravel()
    y = spacing * math.sqrt(0.75) * j.ravel()
    rate *= COLUMNS / columns
    across, height = x - x.mean(), y - y.mean()
    area = math.pi * RADIUS**2
    return {
        "id": np.arange(1, n + 1),
        "type": np.ones(n, np.int8),
        "x": x,
        "y": y,
        "theta": np.zeros(n),
        "u": rate * (SHEAR * height - COMPRESSION * across),
        "v": -rate * COMPRESSION * height,
        "omega": np.zeros(n),
        "radius": np.full(n, RADIUS),
        "mass": np.full(n, DENSITY * THICKNESS * area),
        "thickness": np.full(n, THICKNESS),
        "ice_area": np.full(n, area),
    }


def lattice_bonds(columns: int, elements: Arrays) -> Arrays:
    """Bonds between all neighbours of a `raft`: three an element, but at its rim."""
    ids = elements["id"].reshape(-1, columns)
    odd = (np.arange(len(ids)) % 2 == 1)[:-1, None]
    lo = [ids[:, :-1].ravel(), ids[:-1].ravel()]
    hi = [ids[:, 1:].ravel(), ids[1:].ravel()]
    # The second neighbour above lies to the right of odd rows and to the left of even ones.
    right, left = np.broadcast_to(odd, ids[:-1].shape)[:, :-1], ~odd
    lo += [ids[:-1, :-1][right], ids[:-1, 1:][np.broadcast_to(left, ids[:-1, 1:].shape)]]
    hi += [ids[1:, 1:][right], ids[1:, :-1][np.broadcast_to(left, ids[1:, :-1].shape)]]
    a, b = np.concatenate(lo) - 1, np.concatenate(hi) - 1
    x, y = elements["x"], elements["y"]
    mx, my, dx, dy = 0.5 * (x[a] + x[b]), 0.5 * (y[a] + y[b]), x[b] - x[a], y[b] - y[a]
    half = RADIUS / math.sqrt(3.0) / np.hypot(dx, dy)
    ends = (mx + half * dy, my - half * dx, mx - half * dy, my + half * dx)
    return new_bonds(elements, a + 1, b + 1, *ends, np.full(len(a), THICKNESS))


def breeze(elements: Arrays, over_discs: bool) -> Forcing:
    """A wind that turns over still water, under a whole raft."""
    axes = [
        np.arange(elements[k].min() - RADIUS, elements[k].max() + FORCING_SPACING, FORCING_SPACING)
        for k in ("x", "y")
    ]
    x, y = np.meshgrid(*(axis / 1e4 for axis in axes))
    still = np.zeros((1, *x.shape))
    fields = {"wind_u": still + np.sin(y), "wind_v": still + np.cos(x)}
    fields |= {"ocean_u": still, "ocean_v": still}
    return Forcing(np.zeros(1), *axes, fields, over_discs)


class Own:
    """FloeFlow's engine with a raft, driven or not. A context manager, as `Stock`.

    ``driven`` gives it wind and water, at the centres of its discs or as means over them.
    """

    def __init__(
        self,
        comm: MPI.Comm,
        size: tuple[int, int],
        folder: Path,
        bonds: bool,
        friction: bool,
        driven: Literal["", "centre", "cell"] = "",
        **more: bool,
    ) -> None:
        self._elements = raft(*size, rate=BONDED_RATE if bonds else 1.0)
        self._bonds = lattice_bonds(size[0], self._elements) if bonds else None
        more |= dict.fromkeys(("wind", "ocean_drag"), bool(driven))
        params = EngineParams(STEP, bonds=bonds, friction=friction, skin=SKIN, **LAWS, **more)
        self._engine = Engine(comm, params, folder / "log.own")
        self._forcing = breeze(self._elements, driven == "cell") if driven else None

    def __enter__(self) -> Own:
        self._engine.load(self._elements, self._bonds)
        if self._forcing is not None:
            self._engine.set_forcing(self._forcing)
        return self

    def __exit__(self, *_: object) -> None:
        self._engine.close()

    def run(self, steps: int) -> None:
        """Advance."""
        self._engine.run(steps)

    def state(self) -> Arrays:
        """Elements in the order of their ids."""
        return self._engine.elements()

    def pairs(self) -> tuple[int, int]:
        """Bonds and contacts."""
        sums = self._engine.diagnostics()
        return round(sums["bonds"]), round(sums["contacts"])

    def read_out(self) -> None:
        """All that a window hands over: elements, bonds and contacts."""
        self._engine.elements()
        self._engine.bonds()
        self._engine.contacts()

    def new_lists(self, every: bool) -> None:
        """Neighbour lists at each step, or where they are due."""
        self._engine._command(f"neigh_modify every 1 check {'no' if every else 'yes'}")


class Stock:
    """Stock LIGGGHTS: hooke/stiffness with tangential history, nve/sphere, enforce2d."""

    def __init__(self, comm: MPI.Comm, size: tuple[int, int], folder: Path) -> None:
        self._comm, self._folder = comm, folder
        self._elements = raft(*size)
        self._library, self._instance = load_plugin(), ctypes.c_void_p()

    def __enter__(self) -> Stock:
        data = self._folder / "raft.data"
        if self._comm.rank == 0:
            _write_data(data, self._elements)
        self._comm.barrier()
        log = self._folder / "log.stock"
        self._check(open_liggghts(self._library, self._instance, self._comm, log))
        for line in _stock_commands(data, self._elements):
            self._command(line)
        return self

    def __exit__(self, *_: object) -> None:
        self._library.floe_close(self._instance)
        self._instance = ctypes.c_void_p()

    def run(self, steps: int) -> None:
        """Advance."""
        self._command(f"run {steps} pre no post no")

    def state(self) -> Arrays:
        """Positions and velocities in the order of the ids (one rank)."""
        n = len(self._elements["id"])
        extract = ctypes.CDLL(None).lammps_extract_atom
        extract.restype = ctypes.c_void_p

        def rows(name: bytes, kind: type) -> np.ndarray:
            address = extract(self._instance, name)
            return np.ctypeslib.as_array(ctypes.cast(address, ctypes.POINTER(kind)), (n,))

        order = np.argsort(rows(b"id", ctypes.c_int))
        out = {name: self._elements[name] for name in ("id", "mass", "radius")}
        for names, source in ((("x", "y"), b"x"), (("u", "v"), b"v")):
            first = rows(source, ctypes.c_size_t)[0]
            flat = np.ctypeslib.as_array(
                ctypes.cast(int(first), ctypes.POINTER(ctypes.c_double)), (n, 3)
            )
            for k, name in enumerate(names):
                out[name] = flat[order, k].copy()
        return out

    def _command(self, line: str) -> None:
        self._check(self._library.floe_command(self._instance, line.encode()))

    def _check(self, failed: int) -> None:
        if failed:
            raise FloeError(f"Stock LIGGGHTS: {self._library.floe_error().decode()}")


def _write_data(path: Path, e: Arrays) -> None:
    """Discs as LIGGGHTS reads them; in two dimensions its density is kg/m2."""
    margin = 3.0 * RADIUS + SKIN
    edges = [(float(e[k].min()) - margin, float(e[k].max()) + margin, k) for k in ("x", "y")]
    edges.append((-margin, margin, "z"))
    lines = ["raft", "", f"{len(e['id'])} atoms", "1 atom types", ""]
    lines += [f"{low!r} {high!r} {k}lo {k}hi" for low, high, k in edges]
    lines += ["", "Atoms", ""]
    columns = [e[k].tolist() for k in ("id", "x", "y", "u", "v")]
    areal = DENSITY * THICKNESS
    rows = list(zip(*columns, strict=True))
    lines += [f"{i} 1 {2 * RADIUS!r} {areal!r} {x!r} {y!r} 0" for i, x, y, _, _ in rows]
    lines += ["", "Velocities", ""]
    lines += [f"{i} {u!r} {v!r} 0 0 0 0" for i, _, _, u, v in rows]
    path.write_text("\n".join(lines) + "\n")


def _stock_commands(data: Path, elements: Arrays) -> list[str]:
    """Stock set-up; stiffness, damping and friction are those of the engine's contacts."""
    p = EngineParams(STEP, **LAWS)
    stiffness = p.contact_modulus * THICKNESS / 2.0
    reduced = float(elements["mass"][0]) / 2.0
    damping = 2.0 * p.contact_damping * math.sqrt(stiffness / reduced)
    ratio = p.contact_shear_ratio
    constants = {
        "kn": stiffness,
        "kt": ratio * stiffness,
        "gamman": damping,
        "gammat": math.sqrt(ratio) * damping,
        "coefficientFriction": p.friction_coefficient,
    }
    return [
        *PLANE,
        EVEN,
        f"read_data {data}",
        f"neighbor {SKIN!r} bin",
        "neigh_modify delay 0 every 1 check yes",
        *(f"fix {k} all property/global {k} peratomtypepair 1 {v!r}" for k, v in constants.items()),
        "pair_style gran model hooke/stiffness tangential history",
        "pair_coeff * *",
        f"timestep {STEP!r}",
        "fix motion all nve/sphere",
        "fix plane all enforce2d",
        "thermo_style custom step atoms",
        "thermo_modify lost ignore norm no",
        "thermo 1000000000",
        "run 0 post no",
    ]


def kinetic_energy(state: Arrays) -> float:
    """Of the centres, J."""
    return float(0.5 * np.sum(state["mass"] * (state["u"] ** 2 + state["v"] ** 2)))


def resident_bytes() -> int:
    """Memory of this process, without what the C library keeps for later."""
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
