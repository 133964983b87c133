# SPDX-License-Identifier: GPL-2.0-or-later
"""The critical step: never above the true limit, close to it, and naming what sets it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI

from floeflow.core.errors import FloeError
from floeflow.dynamics.engine.engine import Engine, EngineError, EngineParams
from floeflow.dynamics.step.critical import critical_step
from support.full_ice import full_params
from support.rafts import bonded, discs, lattice

UNDAMPED = {"bond_damping": 0.0, "contact_damping": 0.0}


def shaken(elements: dict[str, np.ndarray], size: float) -> dict[str, np.ndarray]:
    random = np.random.default_rng(1)
    moving = {name: size * random.normal(size=len(elements["id"])) for name in ("u", "v")}
    return elements | moving


def energy_growth(
    elements: dict[str, np.ndarray], bonds: dict[str, np.ndarray], params: EngineParams, log: Path
) -> float:
    with Engine(MPI.COMM_SELF, params, log) as engine:
        engine.load(elements, bonds)
        first = engine.diagnostics()["kinetic"]
        engine.run(600)
        last = engine.diagnostics()
    return (last["kinetic"] + last["elastic_bond"]) / first


@pytest.mark.parametrize("damping", [0.0, 0.3])
def test_the_bound_is_stable_and_not_far_from_the_limit(tmp_path: Path, damping: float) -> None:
    raft = lattice(12, 12)
    table = bonded(raft)
    options = {
        "bonds": True,
        "bond_damping": damping,
        "contact_damping": 0.0,
        "contact_modulus": 1.0,  # bonds alone
        "compressive_strength": 1e14,
        "reach": 1.5,
    }
    critical, _ = critical_step(raft, table, full_params(time_step=1.0, **options))
    log = tmp_path / "log"
    stable = full_params(time_step=0.999 * critical, **options)
    assert energy_growth(shaken(raft, 1e-3), table, stable, log) < 2.0
    unstable = full_params(time_step=1.25 * critical, **options)
    with pytest.raises(EngineError, match="ran away|non-finite|longer reach"):
        energy_growth(shaken(raft, 1e-3), table, unstable, log)


def test_two_elements_against_the_closed_form() -> None:
    pair = discs([0.0, 2000.0], [0.0, 0.0])
    table = bonded(pair)
    params = full_params(time_step=1.0, bonds=True, contact_modulus=1.0, **UNDAMPED)
    critical, _ = critical_step(pair, table, params)
    # Rolling about the bond's centre and bending are the stiffest: w^2 = 2 (kt r^2 + kb) / I.
    length = table["length"][0]
    normal, shear = (m * length / 2000.0 for m in (params.young_modulus, params.shear_modulus))
    mass = pair["mass"][0]
    spin = 2 * (normal * length**2 / 12) / (0.5 * mass * 1000.0**2)
    slide = 2 * shear / mass + 2 * shear * 1000.0**2 / (0.5 * mass * 1000.0**2)
    limit = 2.0 / np.sqrt(max(2 * normal / mass, spin, slide))
    assert 0.85 * limit < critical <= limit


def test_it_names_the_bond_or_contact_that_sets_the_step() -> None:
    raft = lattice(5, 4)
    table = bonded(raft)
    table["thickness"][table["id_hi"] == 9] *= 50.0
    params = full_params(time_step=1.0, bonds=True)
    step, reason = critical_step(raft, table, params)
    assert "bond" in reason and "-9" in reason and "50 m" in reason
    raft["mass"][13] *= 1e-4  # element 14
    lighter, reason = critical_step(raft, None, params)
    assert reason.startswith("contacts of element 14 ")
    assert lighter < step
    all_thin = {
        name: v * (1e-3 if name in ("mass", "thickness") else 1) for name, v in raft.items()
    }
    assert critical_step(all_thin, None, params)[0] == pytest.approx(lighter)


def test_damping_shortens_the_step() -> None:
    raft = lattice(5, 4)
    table = bonded(raft)
    steps = [
        critical_step(raft, table, full_params(time_step=1.0, bonds=True, bond_damping=d))[0]
        for d in (0.0, 0.2, 1.0)
    ]
    assert steps[0] > steps[1] > steps[2]


def test_a_scene_of_coast_alone_has_no_step() -> None:
    pair = discs([0.0, 2000.0], [0.0, 0.0])
    pair["type"][:] = 2
    with pytest.raises(FloeError, match="All elements are fixed"):
        critical_step(pair, None, full_params(time_step=1.0))
