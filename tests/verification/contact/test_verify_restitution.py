# SPDX-License-Identifier: GPL-2.0-or-later
"""Two unbonded elements that hit each other: restitution of the damped contact without tension.

Closed form of Schwager & Poeschel (2007), doi 10.1007/s10035-007-0065-z: the linear dashpot, where
the collision ends when the force would become attractive. With the share of critical damping z it
reads exp(-2 z arccos(z) / sqrt(1 - z^2)), with arcosh and z^2 - 1 above 1.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI

from floeflow.dynamics.engine.engine import Engine
from support.contact import figures
from support.full_ice import full_params
from support.rafts import discs

SELF = MPI.COMM_SELF


def restitution(share: float) -> float:
    """Separating over approaching speed."""
    if share == 1.0:
        return math.exp(-2.0)
    root = math.sqrt(abs(1.0 - share * share))
    angle = math.acos(share) if share < 1 else math.acosh(share)
    return math.exp(-2.0 * share * angle / root)


def rebound(
    log: Path, share: float, refine: int, radius: tuple[float, float] = (1000.0, 1000.0),
    thickness: tuple[float, float] = (1.0, 1.0), fixed: bool = False,
) -> float:  # fmt: skip
    """Ratio of relative speeds after and before, with 200 `refine` steps in a half period."""
    pair = discs([0.0, sum(radius) + 0.01], [0.0, 0.0], radius, thickness)
    pair["u"][:] = (0.0, -0.2) if fixed else (0.1, -0.1)
    pair["type"][0] = 2 if fixed else 1
    modulus = 1e8
    stiffness = modulus * thickness[0] * thickness[1] / sum(thickness)
    inverse = 1 / pair["mass"]
    reduced = 1 / (inverse[1] if fixed else inverse.sum())
    half_period = math.pi * math.sqrt(reduced / stiffness)
    params = full_params(
        time_step=half_period / (200 * refine), friction=False, contact_modulus=modulus,
        contact_damping=share,
    )  # fmt: skip
    with Engine(SELF, params, log) as engine:
        engine.load(pair)
        engine.run(2000 * refine)
        out, sums = engine.elements(), engine.diagnostics()
    assert sums["contacts"] == 0
    return float((out["u"][1] - out["u"][0]) / 0.2)


SHARES = (0.02, 0.1, 0.3, 0.6, 0.75, 1.0, 1.5)


@pytest.mark.parametrize("share", SHARES)
def test_restitution_of_the_damped_contact(log: Path, share: float) -> None:
    exact = restitution(share)
    for refine in (1, 4, 16):
        # First order; where in its step the contact closes and opens makes the error uneven.
        assert rebound(log, share, refine) == pytest.approx(exact, abs=0.01 / refine)


@pytest.mark.parametrize(
    ("radius", "thickness", "fixed"),
    [
        ((500.0, 2000.0), (0.2, 3.0), False),
        ((1000.0, 1000.0), (1e-4, 1e-4), False),
        ((2000.0, 700.0), (1.0, 0.5), True),
    ],
)
def test_it_is_that_of_the_pair_whatever_it_is_made_of(
    log: Path, radius: tuple[float, float], thickness: tuple[float, float], fixed: bool
) -> None:
    measured = rebound(log, 0.3, 16, radius, thickness, fixed)
    assert measured == pytest.approx(restitution(0.3), rel=2e-3)


def test_no_damping_loses_nothing(log: Path, show) -> None:
    assert rebound(log, 0.0, 1) == pytest.approx(1.0, abs=1e-4)
    fine = np.linspace(0.0, 1.6, 100)
    law = {"Schwager & Pöschel (2007)": (fine, np.array([restitution(z) for z in fine]))}
    shares = (0.0, *SHARES)
    ours = np.array([rebound(log, z, 4) for z in shares])
    show(
        "restitution", figures.curves, law, {"FloeFlow": (np.array(shares), ours)},
        "share of critical damping", "coefficient of restitution",
    )  # fmt: skip
