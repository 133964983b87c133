# SPDX-License-Identifier: GPL-2.0-or-later
"""Forcing as means over elements' discs, and winds that keep their stress, in a window."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from mpi4py import MPI

from floeflow.column.forcing import sample_series
from floeflow.core.discs import disc_places
from floeflow.core.grids import Grid
from floeflow.coupling.fluxes import spread
from floeflow.dynamics.engine.engine import Engine
from floeflow.dynamics.motion import engine_forcing
from floeflow.scene import Scene
from support.full_ice import full_params
from tests.support.rafts import discs

AXIS = 2000.0 * (np.arange(12) + 0.5)
GRID = Grid(AXIS, AXIS, 2000.0, 0.0, 0.0)
WIND = ("wind_u", "wind_v")


def gusts() -> xr.Dataset:
    """Wind that differs from node to node and from time to time."""
    random, dims = np.random.default_rng(4), ("time", "y", "x")
    fields = {name: (dims, 10 * random.normal(size=(2, 12, 12))) for name in WIND}
    return xr.Dataset(fields, {"time": [0.0, 400.0], "y": AXIS, "x": AXIS})


def test_places_of_a_disc_are_exact_for_polynomials() -> None:
    """Means over the disc of radius 1: 1/4 of x2, 1/8 of x4, 1/24 of x2 y2, 5/64 of x6."""
    x, y = disc_places()
    powers = {(2, 0): 1 / 4, (4, 0): 1 / 8, (2, 2): 1 / 24, (6, 0): 5 / 64, (1, 0): 0, (3, 2): 0}
    for (p, q), mean in powers.items():
        assert float((x**p * y**q).mean()) == pytest.approx(mean, abs=1e-15)


@pytest.mark.parametrize("at", ["centre", "cell"])
@pytest.mark.parametrize("wind_mean", ["velocity", "stress"])
def test_dynamics_column_and_the_way_back_agree(tmp_path: Path, at: str, wind_mean: str) -> None:
    """The impulse of one step tells the wind that the element model met."""
    keys = {"name": "s", "forcing": {"at": at, "wind_mean": wind_mean}}
    random = np.random.default_rng(1)
    places = 4500 + 7500 * np.arange(3)[:, None] + random.uniform(-600, 600, (2, 3, 3))
    x, y = places[0].ravel(), places[1].transpose().ravel()
    # Some are larger than the grid's cells, some lie within one.
    radius = np.resize([1400.0, 3000.0, 300.0], 9)
    elements, forcing = discs(x, y, radius), gusts()
    params = full_params(time_step=100.0, wind=True)
    with Engine(MPI.COMM_SELF, params, tmp_path / "log") as engine:
        engine.load(elements)
        engine.set_forcing(engine_forcing(Scene.model_validate(keys), forcing, params.external))
        engine.run(1)
        after = engine.elements()
    over = radius if at == "cell" else None
    stress = wind_mean == "stress"
    wind = sample_series(forcing, WIND, x, y, radius=over, wind_stress=stress)(50.0)
    speed, area = np.hypot(*wind.values()), np.pi * radius**2
    got = {}
    for name, axis in zip(WIND, "xy", strict=True):
        got[name] = after[f"wind_impulse_{axis}"] / (100.0 * params.wind_stress_factor)
        np.testing.assert_allclose(got[name], area * speed * wind[name], rtol=1e-9, atol=1e-3)
    # A stress that is met over discs is the grid's: what the elements got, their nodes gave.
    shares, outside = spread(GRID, x, y, area, area[None])
    assert outside[0] == 0.0
    given = np.hypot(*(forcing[name] for name in WIND)) * forcing["wind_u"]
    total = float((shares[0] * given.interp(time=50.0).values).sum())
    kept = total == pytest.approx(float(got["wind_u"].sum()), rel=1e-9)
    assert kept == (at == "cell" and stress)
