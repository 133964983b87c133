# SPDX-License-Identifier: GPL-2.0-or-later
"""Orders of convergence in time of the element model and of the splitting into windows.

Others stand with what they test: conduction in layers and freezing (``test_bl99_exact``), steps of
the column (``test_column_zero_layer``), moving least squares (``test_remap_weights``).
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from mpi4py import MPI

from floeflow.analysis.studies.orders import observed_order
from floeflow.core.grids import scene_grid
from floeflow.coupling.coupled_windows import advance_window
from floeflow.dynamics.engine.engine import Engine
from floeflow.scene import Scene
from floeflow.scene.effects import forcing_variables
from floeflow.scene.load import build_scene
from support.full_ice import full_params
from support.rafts import bonded, discs, lattice, uniform
from support.synthetic import SPACING, WIDTH, X0, Y0, first_state, make_packing

SELF = MPI.COMM_SELF


def order_of(results: list[np.ndarray], steps: list[float]) -> float:
    """Order from results at falling steps: differences of neighbours."""
    differences = [float(np.abs(a - b).max()) for a, b in zip(results, results[1:], strict=False)]
    return observed_order(steps[::-1], differences[::-1])


def wave(log: Path, step: float, seconds: float) -> np.ndarray:
    """Places in a bonded, undamped raft through which a smooth wave runs, (2 n,)."""
    raft = lattice(12, 4)
    # A wave of velocity in an unstrained raft: no acceleration at the start, so that the stored
    # velocity, which belongs to half a step before, is the same to second order.
    raft["u"] = 1e-2 * np.sin(2.0 * math.pi * raft["x"] / np.ptp(raft["x"]))
    raft["v"] = 1e-2 * np.cos(math.pi * raft["x"] / np.ptp(raft["x"]))
    params = full_params(
        time_step=step, bonds=True, bond_damping=0.0, compressive_strength=1e7, friction=False
    )
    with Engine(SELF, params, log) as engine:
        engine.load(raft, bonded(raft))
        engine.run(round(seconds / step))
        out = engine.elements()
    moved = np.concatenate([out["x"] - raft["x"], out["y"] - raft["y"]])
    assert np.abs(moved).max() > 0.01
    return moved


def test_a_smooth_bonded_wave_is_second_order(tmp_path: Path):
    steps = [0.4 / 2**k for k in range(4)]
    results = [wave(tmp_path / "log", step, 16.0) for step in steps]
    assert order_of(results, steps) == pytest.approx(2.0, abs=0.1)


def drift(log: Path, step: float) -> np.ndarray:
    """Velocity of thin floating ice an hour after the wind rose."""
    params = full_params(time_step=step, wind=True, ocean_drag=True)
    with Engine(SELF, params, log) as engine:
        engine.load(discs(0.0, 0.0, thickness=2.0))
        engine.set_forcing(uniform(wind=(10.0, 0.0)))
        engine.run(round(1920.0 / step))
        out = engine.elements()
    return np.array([out["u"][0], out["v"][0]])


def test_implicit_drag_is_first_order(tmp_path: Path):
    steps = [120.0 / 2**k for k in range(5)]
    results = [drift(tmp_path / "log", step) for step in steps]
    assert order_of(results, steps) == pytest.approx(1.0, abs=0.1)


TOTAL = 43200.0  # s


def split_scene(windows: int, splitting: str) -> Scene:
    """Half a day in so many windows; the steps of column and element model are always the same."""
    keys = {
        "name": "split",
        "effects": ["wind", "ocean_drag", "coriolis", "thermodynamics"],
        "domain": {"x_min": X0, "x_max": X0 + WIDTH, "y_min": Y0, "y_max": Y0 + WIDTH},
        "time": {"windows": windows, "window": TOTAL / windows},
        "forcing": {"step": TOTAL / windows},
        "dynamics": {"samples": 16 // windows, "contact_modulus": 1e6},
        "column": {"step": 675.0, "splitting": splitting},
    }
    keys["domain"]["spacing"] = SPACING
    return build_scene(keys)


def split_run(folder: Path, state: xr.Dataset, windows: int, splitting: str) -> xr.Dataset:
    """Floes that drift into colder air for half a day."""
    scene = split_scene(windows, splitting)
    grid = scene_grid(scene.domain)
    across = np.broadcast_to((grid.x - X0) / WIDTH, grid.shape)
    start = float(state.attrs["time"])
    for number in range(windows):
        moments = start + np.array([number, number + 1]) * TOTAL / windows
        values = dict.fromkeys(forcing_variables(scene.effects), 0.0 * across)
        values |= {
            "wind_u": 20.0 + 0.0 * across,
            "wind_v": 5.0 * across,
            "air_temperature": 265.0 - 60.0 * across,
            "specific_humidity": 3e-4 + 0.0 * across,
            "air_pressure": 1e5 + 0.0 * across,
            "longwave_down": 170.0 + 0.0 * across,
            "coriolis": 1.4e-4 + 0.0 * across,
        }
        fields = {
            name: (("y", "x"), field) if name == "coriolis" else (("time", "y", "x"), [field] * 2)
            for name, field in values.items()
        }
        forcing = xr.Dataset(fields, coords={"time": moments, "x": grid.x, "y": grid.y})
        log = folder / f"{windows}-{number}.log"
        advanced = advance_window(SELF, scene, state, forcing, log, _silent)
        check_ice_budget(advanced.series)
        state = advanced.state
    return state


def check_ice_budget(series: xr.Dataset) -> None:
    """Dynamics keep the ice; the column's terms are all that changes it."""
    start, moved, end = (float(series[f"ice_volume_{m}"]) for m in ("start", "dynamics", "end"))
    assert moved == pytest.approx(start, rel=1e-12)
    terms = [float(series[name]) for name in series if str(name).startswith("growth_")]
    assert end - start == pytest.approx(sum(terms), rel=1e-9) and end > start


def drifting(folder: Path) -> xr.Dataset:
    """Thin floes apart that already drift: a start from rest is not smooth."""
    packed = make_packing()
    apart = np.flatnonzero(packed["type"].values == 1)[5::41]
    state = first_state(packed, split_scene(1, "after")).isel(element=apart)
    state["ice_volume"] = 0.25 * state["ice_fraction"]
    return split_run(folder, state, 1, "after")


def _silent(**_: object) -> None:
    """The progress of a run goes nowhere."""


@pytest.mark.parametrize(("splitting", "expected"), [("after", 1.0), ("around", 2.0)])
def test_order_of_splitting_into_windows(tmp_path: Path, splitting: str, expected: float):
    counts = [1, 2, 4, 8]
    start = drifting(tmp_path)
    ends = [split_run(tmp_path, start, count, splitting) for count in counts]
    for name, scale in (("ice_volume", 1.0), ("x", 1e5), ("y", 1e5)):
        results = [end[name].values.ravel() / scale for end in ends]
        assert np.abs(results[0] - results[-1]).max() > 1e-7
        order = order_of(results, [1.0 / count for count in counts])
        assert order == pytest.approx(expected, abs=0.15 * expected), name
