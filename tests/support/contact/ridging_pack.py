# SPDX-License-Identifier: GPL-2.0-or-later
"""Packs that ridge over several windows: the state, and the loop of motion and closing of areas."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import xarray as xr
from mpi4py import MPI

from floeflow.dynamics.engine.engine import Engine, EngineParams, Forcing
from floeflow.dynamics.ridging.ridging import close_areas
from floeflow.state.bonds import Arrays
from floeflow.state.elements import element_arrays, moved_state, pair_arrays
from floeflow.state.schema import check_state
from unit.state.test_state import a_state

LEAST = 1e-3  # m, of ice that is given a mass
EFFECTS = ("friction", "ridging", "thermodynamics", "snow")
CELL = 2 * math.sqrt(3)  # area of a hexagon over the squared radius of the circle inside it

Watch = Callable[[xr.Dataset, dict[str, float]], None]


def pack_state(elements: Arrays, water: float = 0.0) -> xr.Dataset:
    """State of elements (as `rafts.discs` makes them) that fill hexagons, without pairs or snow."""
    n = len(elements["id"])
    state = a_state(EFFECTS, n=n).isel(contact=slice(0, 0))
    for name in ("type", "x", "y", "theta", "u", "v", "omega", "radius"):
        state[name] = ("element", elements[name].copy())
    coast = elements["type"] == 2
    state["area"] = ("element", np.where(coast, 0.0, CELL * elements["radius"] ** 2))
    for name, value in (("ice_fraction", 1.0), ("ice_volume", elements["thickness"])):
        state[name].values[:, 0] = np.where(coast, 0.0, value)
    state["snow_volume"].values[:] = 0.0
    owned = float(state["area"].sum())
    state.attrs |= {"ocean_area": owned + water, "unclaimed_water": water}
    return state


def ice_volume(state: xr.Dataset) -> float:
    """Volume of all ice, m3."""
    return float((state["area"] * state["ice_volume"].sum("category")).sum())


def advance(
    state: xr.Dataset,
    params: EngineParams,
    steps: int,
    log: Path,
    forcing: Forcing | None = None,
    heavy: np.ndarray | None = None,
) -> tuple[xr.Dataset, dict[str, float]]:
    """State after a window, closed and checked, and the window's sums.

    `heavy`: elements (n,) that keep their velocity whatever pushes them.
    """
    elements = element_arrays(state, LEAST)
    if heavy is not None:
        elements["mass"] = np.where(heavy, 1e27, elements["mass"])
    time = float(state.attrs["time"])
    with Engine(MPI.COMM_SELF, params, log) as engine:
        engine.load(elements, None, pair_arrays(state, "contact"), time)
        if forcing is not None:
            engine.set_forcing(forcing)
        first = engine.diagnostics()
        engine.run(steps)
        sums, moved = engine.diagnostics(), engine.elements()
        after = moved_state(state, moved, None, engine.contacts())
    sums |= {f"first_{name}": value for name, value in first.items()}
    held = {"contact": pair_arrays(state, "contact")}
    closed = close_areas(after, moved["ridged_area"], LEAST, held)
    closed.attrs["time"] = sums["time"]
    check_state(closed)
    return closed, sums


def assert_balance(start: xr.Dataset, end: xr.Dataset) -> None:
    """No ice lost or made (1e-12), and area plus open water is the ocean (round-off)."""
    assert abs(ice_volume(end) - ice_volume(start)) < 1e-12 * ice_volume(start)
    owned = float(end["area"].sum()) + end.attrs["unclaimed_water"]
    ocean = start.attrs["ocean_area"]
    assert end.attrs["ocean_area"] == ocean and abs(owned - ocean) < 1e-13 * ocean
