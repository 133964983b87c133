# SPDX-License-Identifier: GPL-2.0-or-later
"""Small seas with land around them, winds over them, and a loop of windows."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from mpi4py import MPI

from floeflow.coupling.initial import make_state
from floeflow.dynamics.motion import Motion, move
from floeflow.dynamics.remesh.remesh import remesh
from floeflow.packings.bonds import make_bonds
from floeflow.packings.fresh_cells import make_cells
from floeflow.packings.packing import make_packing
from floeflow.scene.blocks import Scene
from floeflow.state.cells import read_cells
from floeflow.state.schema import MOBILE, check_state

SIDE = 10e3  # m, of a mask cell
EFFECTS = ("wind", "ocean_drag", "coast", "friction", "bonds", "ridging")

Wind = Callable[[float], tuple[float, float]]


def a_mask(land: np.ndarray, thickness: float = 0.5, ice: np.ndarray | None = None) -> xr.Dataset:
    """Mask of cells of 10 km, ice wherever there is no land or where it is asked for."""
    cover = np.where(land, 0.0, 1.0 if ice is None else ice)
    dims, (ny, nx) = ("y", "x"), land.shape
    return xr.Dataset(
        {
            "siconc": (dims, cover),
            "sithick": (dims, thickness * cover),
            "land": (dims, land.astype(np.int8)),
            "cell_area": (dims, np.full(land.shape, SIDE**2)),
        },
        coords={"x": SIDE * (np.arange(nx) + 0.5), "y": SIDE * (np.arange(ny) + 0.5)},
        attrs={"crs": "EPSG:6931"},
    )


def a_scene(count: int, window: float, *more: str, every: int = 0, **dynamics: float) -> Scene:
    """Scene of so many elements, with more effects, a remap every so many windows, and keys."""
    return Scene.model_validate(
        {
            "name": "sea",
            "packing": {"elements": count},
            "effects": [*EFFECTS, *more],
            "time": {"window": window},
            "dynamics": {"samples": 2, **dynamics},
            "remap": {"every": every},
        }
    )


def blowing(wind: Wind, begin: float, window: float) -> xr.Dataset:
    """Forcing of a window: an even wind (m/s) by time, still water."""
    time, axis = begin + np.linspace(0.0, window, 5), np.array([-1e7, 1e7])
    along = np.array([wind(t) for t in time])
    one = np.ones((len(time), 2, 2))
    fields = {f"wind_{c}": along[:, k, None, None] * one for k, c in enumerate("uv")}
    fields |= {"ocean_u": 0 * one, "ocean_v": 0 * one}
    return xr.Dataset(
        {name: (("time", "y", "x"), values) for name, values in fields.items()},
        coords={"time": time, "x": axis, "y": axis},
    )


def on_land(state: xr.Dataset, land: np.ndarray) -> np.ndarray:
    """Ids of mobile elements whose centre lies on a land cell."""
    mobile = state["type"].values == MOBILE
    column, row = (np.floor(state[a].values[mobile] / SIDE).astype(int) for a in "xy")
    inside = (row >= 0) & (row < land.shape[0]) & (column >= 0) & (column < land.shape[1])
    ashore = np.zeros(mobile.sum(), dtype=bool)
    ashore[inside] = land[row[inside], column[inside]]
    return np.asarray(state["id"].values[mobile][ashore])


@dataclass(frozen=True)
class Window:
    """A window's motion, its remeshed state and the terms of remeshing."""

    motion: Motion
    state: xr.Dataset
    terms: dict[str, float]


def first_state(scene: Scene, mask: xr.Dataset) -> tuple[xr.Dataset, xr.Dataset]:
    """State at the start, and the packing that it is made of."""
    packing = make_packing(mask, scene.packing, 1)
    keys = scene.packing
    bonds = make_bonds(packing, keys.bond_gap, keys.bond_concentration, keys.coast_bonds)
    return make_state(scene, packing, bonds), packing


def windows(
    log: Path,
    scene: Scene,
    mask: xr.Dataset,
    forced: Callable[[float, float], xr.Dataset],
    count: int,
) -> Iterator[Window]:
    """Windows of motion and remeshing, each checked against the schema.

    ``forced`` gives the forcing of a window by its begin and length (s).
    """
    state, packing = first_state(scene, mask)
    check_state(state)
    cells = None
    if "remap" in scene.effects:
        cells = read_cells(make_cells(mask, packing, 1))
    for k in range(count):
        begin, length = k * scene.time.window, scene.time.window
        motion = move(MPI.COMM_SELF, scene, state, forced(begin, length), log, lambda **_: None)
        state = motion.state
        state.attrs |= {"time": begin + length, "window": k + 1}
        state, terms = remesh(scene, state, cells)
        check_state(state)
        yield Window(motion, state, terms)
