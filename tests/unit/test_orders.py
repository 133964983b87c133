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
from rafts import bonded, discs, lattice, uniform
from synthetic import SPACING, WIDTH, X0, Y0, first_state, make_packing

from floeflow.config.load import build_scene
from floeflow.dynamics.engine import Engine, EngineParams
from floeflow.dynamics.march import advance_window
from floeflow.effects import forcing_variables
from floeflow.preprocess.grids import scene_grid
from floeflow.studies.orders import observed_order

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
    params = EngineParams(
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
    params = EngineParams(time_step=step, wind=True, ocean_drag=True)
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


def split_run(folder: Path, windows: int) -> np.ndarray:
    """Ice volume and places of floes that drift into colder air, (3 n,), in units of their range.

    The steps of column and element model are the same whatever the windows.
    """
    total = 43200.0
    keys = {
        "name": "split",
        "effects": ["wind", "ocean_drag", "coriolis", "thermodynamics"],
        "domain": {"x_min": X0, "x_max": X0 + WIDTH, "y_min": Y0, "y_max": Y0 + WIDTH},
        "time": {"windows": windows, "window": total / windows},
        "forcing": {"step": total / windows},
        "dynamics": {"samples": 16 // windows, "contact_modulus": 1e6},
        "column": {"step": 675.0},
    }
    keys["domain"]["spacing"] = SPACING
    scene = build_scene(keys)
    packed = make_packing()
    apart = np.flatnonzero(packed["type"].values == 1)[5::41]
    state = first_state(packed, scene).isel(element=apart)
    state["ice_volume"] = 0.25 * state["ice_fraction"]
    grid = scene_grid(scene.domain)
    across = np.broadcast_to((grid.x - X0) / WIDTH, grid.shape)
    for number in range(windows):
        moments = np.array([number, number + 1]) * total / windows
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
        state = advance_window(SELF, scene, state, forcing, log, _silent).state
    parts = [state["ice_volume"].values[:, 0], state["x"].values / 1e5, state["y"].values / 1e5]
    return np.concatenate(parts)


def _silent(**_: object) -> None:
    """The progress of a run goes nowhere."""


def test_splitting_into_windows_is_first_order(tmp_path: Path):
    counts = [1, 2, 4, 8]
    results = [split_run(tmp_path, count) for count in counts]
    assert np.abs(results[0] - results[-1]).max() > 1e-5
    order = order_of(results, [1.0 / count for count in counts])
    assert order == pytest.approx(1.0, abs=0.1)
