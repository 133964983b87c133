# SPDX-License-Identifier: GPL-2.0-or-later
"""Bonded floes that meet walls, standing and moving: energy, momentum, the moving frame."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI

from floeflow.dynamics.engine.engine import Engine
from floeflow.dynamics.step.critical import critical_step
from floeflow.state import walls
from floeflow.state.bonds import Arrays
from support.contact import figures
from support.full_ice import full_params
from support.rafts import bonded, lattice

SPEED, SECONDS = 1.0, 400.0
LOSSES = ("bond", "contact", "friction", "fracture")


def wedge(speed: float) -> Arrays:
    """An oblique plane and, above it, an edge of two lines, both moving to the right."""
    slope = walls.plane(-1050.0, 0.0, (math.cos(0.3), math.sin(0.3)), (speed, 0.0))
    edge = [[[-3000.0, 4000.0], [-1300.0, 6928.0]], [[-1300.0, 6928.0], [-3000.0, 8000.0]]]
    return walls.join([slope, walls.lines(np.array(edge), (speed, 0.0))])


def impact(
    log: Path, share: float, floe_speed: float = -SPEED, wall_speed: float = 0.0
) -> tuple[Arrays, dict[str, float], dict[str, float], dict[str, float]]:
    """Floe after it met the wedge; sums before and after; and the energy that is missing.

    The last holds, in J: before (kinetic energy as seen from the wall), each loss, the wall's
    work, and what of the energy's change they do not explain.
    """
    floe = lattice(6, 5)
    floe["u"] += floe_speed
    table, laws = bonded(floe, gap=0.1), {"bonds": True, "bond_damping": 0.1}
    step = share * critical_step(floe, table, full_params(time_step=1.0, **laws))[0]
    steps = round(SECONDS / step)
    params = full_params(time_step=SECONDS / steps, **laws)
    with Engine(MPI.COMM_SELF, params, log, wedge(wall_speed)) as engine:
        engine.load(floe, table)
        first = engine.diagnostics()
        engine.run(steps)
        last, out = engine.diagnostics(), engine.elements()
    parts = ("kinetic_now", "rotational_now", "elastic_bond", "elastic_contact", "elastic_wall")
    before, after = (sum(d[name] for name in parts) for d in (first, last))
    terms = {name: last[f"dissipation_{name}"] for name in LOSSES}
    residual = before + last["work_wall"] - after - sum(terms.values())
    fall = 0.5 * floe["mass"].sum() * (wall_speed - floe_speed) ** 2
    return out, first, last, terms | {"before": fall, "residual": residual}


def test_energy_of_a_floe_that_hits_walls(log: Path, show) -> None:
    shares = 0.1 / 2.0 ** np.arange(4)
    runs = [impact(log, share) for share in shares]
    for _, first, last, terms in runs:
        assert last["bonds_broken"] > 5 and last["work_wall"] == 0.0
        for loss in LOSSES:
            assert terms[loss] > 0.01 * terms["before"]
        # The walls give exactly the momentum that the floe gains.
        for axis in "xy":
            gained = last[f"momentum_{axis}"] - first[f"momentum_{axis}"]
            assert gained == pytest.approx(last[f"impulse_wall_{axis}"], rel=1e-12)
    residuals = np.array([abs(run[3]["residual"]) / run[3]["before"] for run in runs])
    assert residuals[0] < 0.02
    assert np.polyfit(np.log(shares), np.log(residuals), 1)[0] >= 1.0
    lines = {"first order": (shares, residuals[0] * shares / shares[0])}
    points = {"floe on walls": (shares, residuals)}
    show(
        "energy_walls", figures.curves, lines, points, "step / critical step",
        "energy not accounted for / initial energy", "log",
    )  # fmt: skip


def test_a_moving_wall_is_a_standing_one_in_another_frame(log: Path) -> None:
    still, first, _, terms = impact(log, 0.1)
    for floe_speed in (0.0, 0.3):
        wall_speed = floe_speed + SPEED
        moved, start, end, moving = impact(log, 0.1, floe_speed, wall_speed)
        shift = wall_speed * SECONDS
        np.testing.assert_allclose(moved["x"] - shift, still["x"], rtol=0, atol=1e-4)
        np.testing.assert_allclose(moved["u"] - wall_speed, still["u"], rtol=0, atol=1e-6)
        np.testing.assert_allclose(moved["omega"], still["omega"], rtol=0, atol=1e-9)
        for loss in LOSSES:
            assert moving[loss] == pytest.approx(terms[loss], rel=1e-6)
        # All that the floe has and all that is lost came from the wall.
        assert end["work_wall"] > 0.5 * terms["before"]
        assert abs(moving["residual"]) < 0.02 * terms["before"]
        gained = end["momentum_x"] - start["momentum_x"]
        assert gained == pytest.approx(end["impulse_wall_x"], rel=1e-12)
    assert first["elastic_wall"] == 0.0
