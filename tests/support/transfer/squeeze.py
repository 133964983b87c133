# SPDX-License-Identifier: GPL-2.0-or-later
"""A pack that a converging current squeezes to half of its width, window after window."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from mpi4py import MPI

from floeflow.core.errors import FloeError
from floeflow.coupling import initial
from floeflow.coupling.coupled_windows import advance_window
from floeflow.packings import bonds, packing
from floeflow.packings import fresh_cells as cells
from floeflow.scene import Scene
from floeflow.state.cells import read_cells
from support.transfer.sheets import SIDE, scene, square_sea

# The pack covers this part of the sea, and ends when it is half as wide.
WIDTH, HEIGHT, THICKNESS = 0.8 * SIDE, 0.5 * SIDE, 0.5
# Weak ice, so that the current closes it: m thick ice is crushed at this many N/m.
STRENGTH = 2.0e3
SPEED, REACH = 0.4, 0.05 * SIDE  # of the current (m/s), and over which it turns (m)
KEYS = (
    "dynamics: {{compressive_strength: {strength}, samples: 2}}\n"
    "time: {{window: {window!r}}}\nforcing: {{step: {window!r}}}\nremap: {{every: 1}}\n"
    "merge: {{radius: 0.7}}\n"
)


@dataclass(frozen=True)
class Squeeze:
    """What a squeeze left, one entry a window.

    Parameters
    ----------
    width : list of float
        Width of the pack over that at the start: spread of the ice along x.
    step, steps, elements, volume, sea : list
        Time step (s) and number of steps, elements, ice volume (m3), and areas and unclaimed
        water over the ocean's area.
    fault : str
        Why it ended early; empty if it did not.
    """

    width: list[float]
    step: list[float]
    steps: list[int]
    elements: list[int]
    volume: list[float]
    sea: list[float]
    fault: str


def setting(remesh: str, elements: int, windows: int) -> Scene:
    """Scene of the squeeze: half the width after so many windows, if ice follows the current."""
    window = 0.25 * WIDTH / SPEED / windows
    effects = "ocean_drag, friction, bonds, ridging" + (f", {remesh}" if remesh else "")
    return scene(elements, effects, KEYS.format(strength=STRENGTH, window=window))


def current(seconds: float) -> xr.Dataset:
    """Current that flows together along the middle line, from both sides."""
    axis = np.linspace(-0.75 * SIDE, 0.75 * SIDE, 61)
    u = np.broadcast_to(-SPEED * np.tanh(axis / REACH), (1, 61, 61))
    fields = {"ocean_u": u, "ocean_v": np.zeros((1, 61, 61))}
    return xr.Dataset(
        {name: (("time", "y", "x"), np.ascontiguousarray(f)) for name, f in fields.items()},
        coords={"time": [seconds], "x": axis, "y": axis},
    )


def width_of(state: xr.Dataset) -> float:
    """Spread of the ice along x: its volume's standard deviation (m)."""
    volume = state["area"].values * state["ice_volume"].values.sum(axis=1)
    x = state["x"].values
    mean = float(volume @ x) / volume.sum()
    return float(np.sqrt(volume @ (x - mean) ** 2 / volume.sum()))


def squeeze(remesh: str, elements: int, windows: int, folder: Path) -> Squeeze:
    """Squeeze a pack with remapping, merging or no remeshing (empty)."""
    settings = setting(remesh, elements, windows)
    mask = square_sea(lambda x, y: (np.abs(x) < 0.5 * WIDTH) & (np.abs(y) < 0.5 * HEIGHT))
    mask["sithick"] = THICKNESS / 2.0 * mask["sithick"]
    packed = packing.make_packing(mask, settings.packing, settings.seed)
    state = initial.make_state(settings, packed, bonds.make_bonds(packed, 0.2, 0.8))
    fresh = read_cells(cells.make_cells(mask, packed, settings.seed)) if remesh == "remap" else None
    out = Squeeze([], [], [], [], [], [], "")
    first = width_of(state)
    for _ in range(windows):
        try:
            done = advance_window(
                *(MPI.COMM_SELF, settings, state, current(float(state.attrs["time"]))),
                *(folder / "log", lambda **_: None, fresh),
            )
        except FloeError as error:
            return Squeeze(*(getattr(out, n) for n in list(vars(out))[:-1]), str(error))
        state = done.state
        area = state["area"].values
        record = next(r for r in done.cost if r.name == "dynamics")
        out.width.append(width_of(state) / first)
        out.step.append(record.extra["time_step"])
        out.steps.append(record.extra["steps"])
        out.elements.append(int(state.sizes["element"]))
        out.volume.append(float(area @ state["ice_volume"].values.sum(axis=1)))
        total = float(area.sum()) + float(state.attrs["unclaimed_water"])
        out.sea.append(total / float(state.attrs["ocean_area"]))
    return out
