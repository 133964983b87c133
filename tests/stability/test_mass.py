# SPDX-License-Identifier: GPL-2.0-or-later
"""Hard case 1: mass that all but vanishes, beside ice a billion times as heavy.

Elements of 10 m to 1e-8 m of ice lie in one lattice and touch, under a wind of 30 m/s that jumps
on and off with every step. What must hold: one time step for all, finite speeds under the drift
that the wind can give, nothing lost, energy accounted for, less of it missing at half the step.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from floeflow.dynamics.engine.engine import EngineParams, Forcing
from floeflow.state.bonds import Arrays
from support.full_ice import full_params
from support.rafts import ICE, lattice, uniform
from support.stability.packs import squeezed
from support.stability.watch import default_step, watch

WIND = 30.0
LAWS = {"wind": True, "ocean_drag": True, "coriolis": True}
THICKNESS = np.logspace(1, -8, 10)


def mixed_masses() -> Arrays:
    pack = lattice(10, 4)
    pack["thickness"] = np.tile(THICKNESS, 4)
    pack["mass"] = ICE * pack["thickness"] * np.pi * pack["radius"] ** 2
    return pack


def jumping(step: float, steps: int, period: int = 1) -> Forcing:
    """Wind that is on for a number of steps, then off for as many."""
    time = step * np.arange(steps + 2)
    on = WIND * ((np.arange(len(time)) // period) % 2)[:, None, None] * np.ones((1, 2, 2))
    still = np.zeros_like(on)
    fields = {"wind_u": on, "wind_v": still, "ocean_u": still, "ocean_v": still}
    edge = np.array([-1e6, 1e6])
    return Forcing(time, edge, edge, fields | {"coriolis": np.full((2, 2), 1.4e-4)})


def fastest_drift(params: EngineParams) -> float:
    """Speed at which the ocean's drag balances the wind's, m/s."""
    return WIND * np.sqrt(params.wind_stress_factor / params.ocean_stress_factor)


def test_masses_a_billion_apart_in_touch_under_a_jumping_wind(log: Path, record):
    pack = mixed_masses()
    params = default_step(pack, None, full_params(time_step=1.0, **LAWS), 0.8)
    assert pack["mass"].max() / pack["mass"].min() == pytest.approx(1e9)
    steps = 2000
    seen = watch(
        log, pack, params, steps * params.time_step, forcing=jumping(params.time_step, steps + 100)
    )
    record(step=params.time_step, largest_speed=seen.largest_speed, overlap=seen.largest_overlap)
    # From rest nothing pushes faster than the wind that drives it.
    assert seen.largest_speed < 1.01 * fastest_drift(params)
    assert seen.largest_overlap < 0.01


def test_one_step_serves_all_thicknesses(record):
    params = full_params(time_step=1.0, **LAWS)
    steps = []
    for h in THICKNESS:
        pack = lattice(4, 4)
        pack["thickness"][:] = h
        pack["mass"] = ICE * pack["thickness"] * np.pi * pack["radius"] ** 2
        steps.append(default_step(pack, None, params, 0.8).time_step)
    record(shortest=min(steps), longest=max(steps))
    assert max(steps) == pytest.approx(min(steps), rel=1e-6)


@pytest.mark.parametrize("overlap", [0.0, 0.002])
def test_energy_of_unlike_masses_is_accounted_for(log: Path, overlap: float, record):
    pack = squeezed(mixed_masses(), overlap)
    residuals = []
    for share in (0.8, 0.4, 0.2):
        params = default_step(pack, None, full_params(time_step=1.0, **LAWS), share)
        seen = watch(log, pack, params, 600.0, forcing=uniform((WIND, 0.0), (0.0, 0.0), 1.4e-4))
        residuals.append(seen.residual)
    record(residual=residuals[0], residual_at_a_quarter=residuals[-1])
    assert residuals[0] < 0.02
    assert residuals[-1] < 0.6 * residuals[0] or residuals[-1] < 1e-6
