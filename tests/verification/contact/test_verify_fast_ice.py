# SPDX-License-Identifier: GPL-2.0-or-later
"""Fast ice: a strip of ice along a straight coast, and a wind that blows off the land.

The strip is WIDE wide; a wind stress t pulls at its bonds to the coast with the tension t WIDE per
length of coast, so t WIDE / h is the nominal stress there. The scene goes through the stages
packing, bonds and initial, and through the dynamics of windows.
"""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from mpi4py import MPI
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from floeflow.core.constants import AIR_DENSITY
from floeflow.coupling.initial import make_state
from floeflow.dynamics.motion import Motion, move
from floeflow.packings.bonds import make_bonds
from floeflow.packings.packing import make_packing
from floeflow.scene import Scene
from floeflow.state.schema import COAST, check_state
from support.contact import figures

SIDE, WIDE, THICKNESS = 10e3, 100e3, 1.0
WINDOW = 21600.0


def scene_of(coast: bool) -> Scene:
    return Scene.model_validate(
        {
            "name": "fast-ice",
            "packing": {"elements": 300, "coast_bonds": coast},
            "effects": ["wind", "ocean_drag", "coast", "friction", "bonds"],
            "time": {"window": WINDOW},
            # Full moduli: what holds hardly gives.
            "dynamics": {"samples": 1, "stiffness": "full"},
        }
    )


@cache
def strip(coast: bool) -> tuple[Scene, xr.Dataset]:
    """Land in the south, 100 km of ice, and open sea."""
    rows = np.arange(20)
    land = np.repeat((rows < 2)[:, None], 40, axis=1)
    ice = np.repeat(((rows >= 2) & (rows < 12))[:, None], 40, axis=1).astype(float)
    dims = ("y", "x")
    mask = xr.Dataset(
        {"siconc": (dims, ice), "sithick": (dims, THICKNESS * ice),
         "land": (dims, land.astype(np.int8)), "cell_area": (dims, np.full(ice.shape, SIDE**2))},
        coords={"x": SIDE * (np.arange(40) + 0.5), "y": SIDE * (rows + 0.5)},
        attrs={"crs": "EPSG:6931"},
    )  # fmt: skip
    scene = scene_of(coast)
    packed = make_packing(mask, scene.packing, 1)
    keys = scene.packing
    table = make_bonds(packed, keys.bond_gap, keys.bond_concentration, keys.coast_bonds)
    state = make_state(scene, packed, table)
    check_state(state)
    return scene, state


def offshore(scene: Scene, stress: float, begin: float) -> xr.Dataset:
    """Wind off the land whose stress (Pa) grows over the first window, and stays."""
    time = begin + np.linspace(0.0, WINDOW, 25)
    share = np.sin(0.5 * math.pi * np.minimum(time / WINDOW, 1.0))
    speed = math.sqrt(stress / (AIR_DENSITY * scene.dynamics.air_drag))
    axis = np.array([-1e6, 1e6])
    wind = np.broadcast_to((speed * share)[:, None, None], (25, 2, 2))
    fields = {"wind_u": 0 * wind, "wind_v": wind, "ocean_u": 0 * wind, "ocean_v": 0 * wind}
    return xr.Dataset(
        {name: (("time", "y", "x"), values) for name, values in fields.items()},
        coords={"time": time, "x": axis, "y": axis},
    )


def blown(
    log: Path, coast: bool, share: float, windows: int = 2
) -> tuple[xr.Dataset, list[Motion]]:
    """State and motions under a wind whose nominal stress is this share of the tensile strength."""
    scene, state = strip(coast)
    d = scene.dynamics
    stress = share * d.tensile_share * d.compressive_strength * THICKNESS / WIDE
    motions = []
    for k in range(windows):
        forcing = offshore(scene, stress, k * WINDOW)
        motion = move(MPI.COMM_SELF, scene, state, forcing, log, lambda **_: None)
        state = motion.state
        state.attrs = {**state.attrs, "time": (k + 1) * WINDOW}
        check_state(state)
        motions.append(motion)
    return state, motions


def to_coast(state: xr.Dataset) -> np.ndarray:
    """Which bonds join ice to the coast."""
    coast = state["type"].values == COAST
    lo, hi = (coast[state[f"bond_id_{end}"].values - 1] for end in ("lo", "hi"))
    assert not (lo & hi).any()
    return np.asarray(lo | hi)


def held_by_coast(state: xr.Dataset) -> float:
    """Share of the mobile elements that bonds join to the coast, over other elements too."""
    n = state.sizes["element"]
    lo, hi = (state[f"bond_id_{end}"].values - 1 for end in ("lo", "hi"))
    coast = np.flatnonzero(state["type"].values == COAST)
    # The land is one piece.
    lo, hi = np.append(lo, coast[:-1]), np.append(hi, coast[1:])
    graph = coo_matrix((np.ones(len(lo)), (lo, hi)), shape=(n, n))
    number = connected_components(graph, directed=False)[1]
    return float((number == number[coast[0]])[state["type"].values != COAST].mean())


def offshore_way(state: xr.Dataset) -> np.ndarray:
    """How far the mobile elements went from the coast, m."""
    first = strip(True)[1]
    mobile = first["type"].values != COAST
    return (state["y"].values - first["y"].values)[mobile]


def assert_momentum(motions: list[Motion]) -> None:
    """Change of momentum is what wind, water and coast gave."""
    for motion in motions:
        b = motion.budget
        size = sum(abs(b[f"impulse_{name}_y"]) for name in ("wind", "ocean", "coast"))
        for axis in "xy":
            given = sum(b[f"impulse_{name}_{axis}"] for name in ("wind", "ocean", "coast"))
            change = b[f"momentum_{axis}_end"] - b[f"momentum_{axis}_start"]
            assert abs(change - given) < 1e-8 * size


def test_the_glue_lines_follow_the_coast() -> None:
    _, state = strip(True)
    length = state["bond_length"].values[to_coast(state)]
    # 400 km of coast, but for gaps wider than bond_gap.
    assert 0.85 * 400e3 < length.sum() < 1.1 * 400e3
    assert state["bond_thickness"].values[to_coast(state)] == pytest.approx(THICKNESS)
    assert not to_coast(strip(False)[1]).any()


def test_fast_ice_holds_below_its_strength(log: Path) -> None:
    state, motions = blown(log, True, 0.25)
    before = strip(True)[1]
    assert state.sizes["bond"] == before.sizes["bond"]
    assert np.abs(offshore_way(state)).max() < 20.0
    assert_momentum(motions)
    # At rest the coast takes all of the wind.
    wind, coast = (motions[-1].budget[f"impulse_{name}_y"] for name in ("wind", "coast"))
    assert coast == pytest.approx(-wind, rel=0.02)


def test_fast_ice_breaks_off_above_its_strength(log: Path, show) -> None:
    state, motions = blown(log, True, 2.0)
    assert_momentum(motions)
    # A fringe may stay where the ice itself broke nearer to the coast than the bonds to it.
    assert held_by_coast(strip(True)[1]) == 1.0 > 0.25 > held_by_coast(state)
    assert np.median(offshore_way(state)) > 1e3
    # It goes as large pieces: most bonds within the ice hold.
    before = strip(True)[1]
    assert (~to_coast(state)).sum() > 0.6 * (~to_coast(before)).sum()
    cases = {"before": before, "12 h of twice its strength": state}
    show("fast_ice", figures.bonded, cases)


def test_without_bonds_to_the_coast_the_same_wind_takes_it_along(log: Path) -> None:
    state, motions = blown(log, False, 0.25, windows=1)
    assert np.median(offshore_way(state)) > 200.0
    assert_momentum(motions)
