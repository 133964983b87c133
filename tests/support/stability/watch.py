# SPDX-License-Identifier: GPL-2.0-or-later
"""Run a hard case through the engine and keep an eye on what must hold.

Every energy is accumulated where it arises; the residual is what none of the terms accounts for,
over the sum of all that moved.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from mpi4py import MPI

from floeflow.dynamics.engine.energy_check import (
    check_energy,
    external_work,
    is_external,
    lost_energy,
    stored_energy,
)
from floeflow.dynamics.engine.engine import Engine, EngineParams, Forcing
from floeflow.dynamics.step.critical import critical_step
from floeflow.state.bonds import Arrays

NUMBERS = ("x", "y", "theta", "u", "v", "omega", "mass")


@dataclass
class Watched:
    """What a watched run showed; energies in J, speeds in m/s, overlaps in radii."""

    elements: Arrays
    bonds: Arrays
    contacts: Arrays
    time_step: float
    steps: int
    sums: dict[str, float]
    energy: np.ndarray = field(repr=False)
    residual: float
    largest_speed: float
    largest_overlap: float

    @property
    def momentum(self) -> np.ndarray:
        """Of the mobile elements, kg m/s, shape (2,)."""
        return np.array([self.sums["momentum_x"], self.sums["momentum_y"]])


def default_step(
    elements: Arrays, bonds: Arrays | None, params: EngineParams, share: float
) -> EngineParams:
    """Parameters with a share of the critical time step."""
    return replace(params, time_step=share * critical_step(elements, bonds, params)[0])


def budget_residual(first: dict[str, float], last: dict[str, float]) -> float:
    """Energy that no term accounts for, as a share of all that was there or moved."""
    before, after = stored_energy(first), stored_energy(last)
    gain = after - before - (external_work(last) - lost_energy(last))
    moved = sum(abs(value) for name, value in last.items() if is_external(name)) + abs(
        lost_energy(last)
    )
    scale = max(before, after, moved)
    return abs(gain) / scale if scale > 0 else 0.0


def watch(
    log: Path,
    elements: Arrays,
    params: EngineParams,
    seconds: float,
    bonds: Arrays | None = None,
    contacts: Arrays | None = None,
    forcing: Forcing | None = None,
    samples: int = 20,
    comm: MPI.Comm = MPI.COMM_SELF,
    look: Callable[[Engine, float], None] | None = None,
) -> Watched:
    """Run for so many seconds; assert at every sample that all is finite and nothing is lost."""
    between = max(1, math.ceil(seconds / params.time_step / samples))
    start = dict(elements)
    energies, speed, overlap = [], 0.0, 0.0
    with Engine(comm, params, log) as engine:
        engine.load(elements, bonds, contacts)
        if forcing is not None:
            engine.set_forcing(forcing)
        first = last = engine.diagnostics()
        for k in range(samples + 1):
            if k:
                engine.run(between)
            last = engine.diagnostics()
            now = engine.elements()
            check_energy(first, last, now, k * between)
            assert np.array_equal(now["id"], start["id"]), "an element was lost"
            for name in NUMBERS:
                assert np.isfinite(now[name]).all(), f"{name} is not finite"
            assert np.array_equal(now["mass"], start["mass"]), "a mass changed in the dynamics"
            energies.append(stored_energy(last))
            speed = max(speed, float(np.hypot(now["u"], now["v"]).max()))
            overlap = max(overlap, last["max_overlap"] / float(now["radius"].min()))
            if look is not None:
                look(engine, last["time"])
        return Watched(
            elements=now,
            bonds=engine.bonds(),
            contacts=engine.contacts(),
            time_step=params.time_step,
            steps=between * samples,
            sums=last,
            energy=np.array(energies),
            residual=budget_residual(first, last),
            largest_speed=speed,
            largest_overlap=overlap,
        )
