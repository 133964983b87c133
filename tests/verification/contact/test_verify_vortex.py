# SPDX-License-Identifier: GPL-2.0-or-later
"""Unbonded ice under a turning wind beside DEMSI's run, and with ice of other thicknesses."""

from __future__ import annotations

from pathlib import Path

import figures
import numpy as np
import pytest
import vortex
import xarray as xr
from mpi4py import MPI

from floeflow.dynamics.engine import Engine
from floeflow.dynamics.timestep import critical_step

STEP, HOUR, MEMBERS = 4.0, 3600.0, 6

Moved = tuple[np.ndarray, np.ndarray, float]


@pytest.fixture(scope="module")
def demsi(shared: Path) -> dict[str, np.ndarray]:
    """Time (s), place (m) and velocity (m/s) of the uniform vortex."""
    path = shared / "reference" / "demsi" / "vortex_uniform.nc"
    with xr.open_dataset(path, decode_times=False) as data:
        return {name: data[name].values for name in ("time", "x", "v")}


def lattice() -> np.ndarray:
    """The start of the reference run: 100 x 50 places (m) in the upper half of the box."""
    across, up = np.arange(2500.0, 500e3, 5000.0), np.arange(252_500.0, 500e3, 5000.0)
    x, y = np.meshgrid(across, up, indexing="ij")
    return np.column_stack([x.ravel(), y.ravel()])


def run(log: Path, thickness: float | np.ndarray, seed: int, hours: float) -> Moved:
    """Places and velocities (n, 2) of the ice after some hours, the largest overlap until then."""
    start = lattice()
    elements, params = vortex.box(start, thickness, seed), vortex.parameters(STEP)
    n, largest = len(start), 0.0
    with Engine(MPI.COMM_SELF, params, log) as engine:
        engine.load(elements)
        engine.set_forcing(vortex.turning_wind())
        for _ in range(round(hours * 4)):
            engine.run(round(HOUR / 4 / STEP))
            largest = max(largest, engine.diagnostics()["max_overlap"])
        out = engine.elements()
    place = np.column_stack([out["x"], out["y"]])[:n]
    assert (place > 0).all() and (place < vortex.BOX).all()  # nothing is lost
    return place, np.column_stack([out["u"], out["v"]])[:n], largest


def test_the_lattice_is_that_of_the_reference(demsi: dict[str, np.ndarray]) -> None:
    np.testing.assert_array_equal(np.sort(lattice(), 0), np.sort(demsi["x"][0], 0))


def test_three_hours_beside_demsi(log: Path, demsi: dict[str, np.ndarray]) -> None:
    place, velocity, overlap = run(log, 1.0, 1, 3.0)
    start = lattice()
    order = np.lexsort(demsi["x"][0].T[::-1])
    ours = vortex.quadrants(place, velocity, start)
    theirs = vortex.quadrants(demsi["x"][1][order], demsi["v"][1][order], start)
    assert np.abs(ours - theirs)[:, :2].max() < 100.0  # of 0.7 to 2.4 km
    assert np.abs(ours - theirs)[:, 2:].max() < 0.01
    assert overlap < 0.01 * vortex.RADIUS


@pytest.mark.slow
def test_a_day_beside_demsi(log: Path, demsi: dict[str, np.ndarray], show) -> None:
    start, day = lattice(), 8
    order = np.lexsort(demsi["x"][0].T[::-1])
    place, velocity = demsi["x"][day][order], demsi["v"][day][order]
    theirs = vortex.quadrants(place, velocity, start)
    runs = [run(log, 1.0, seed, 24.0) for seed in range(MEMBERS)]
    members = np.array([vortex.quadrants(x, v, start) for x, v, _ in runs])
    mean, spread = members.mean(0), members.std(0, ddof=1)
    with np.printoptions(precision=4, suppress=True, linewidth=120):
        print("FloeFlow - DEMSI\n", mean - theirs, "\nstandard deviation of members\n", spread)
        print("share within 2 deviations", (np.abs(mean - theirs) < 2 * spread).mean())
    path = np.hypot(*(theirs[:, :2] - vortex.quadrants(start, velocity, start)[:, :2]).T)
    gap = np.hypot(*(mean - theirs)[:, :2].T)
    assert (gap < 0.03 * path).all()
    assert np.abs(mean - theirs)[:, 2:].max() < 0.01
    show("vortex", figures.vortex, place, runs[0][0])


@pytest.mark.slow
@pytest.mark.parametrize(
    "thinnest",
    [
        0.8,
        pytest.param(
            0.0,
            marks=pytest.mark.xfail(
                strict=True, reason="springs alone squeeze the thinnest ice by 0.15 R: no ridging"
            ),
        ),
    ],
)
def test_other_thicknesses_at_the_same_step(log: Path, thinnest: float) -> None:
    random = np.random.default_rng(2)
    thickness = np.maximum(random.uniform(thinnest, 1.0, 5000), 1e-6)
    elements = vortex.box(lattice(), thickness, 0)
    assert critical_step(elements, None, vortex.parameters(STEP))[0] > STEP
    _, _, overlap = run(log, thickness, 0, 24.0)
    assert overlap < 0.1 * vortex.RADIUS
