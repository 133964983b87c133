# SPDX-License-Identifier: GPL-2.0-or-later
"""Energy and momentum: impacts with every dissipation counted, and a free cluster without any."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI

from floeflow.dynamics.engine.engine import Engine
from floeflow.dynamics.step.critical import critical_step
from floeflow.state.bonds import Arrays
from support.contact import figures
from support.full_ice import full_params
from support.rafts import angular_momentum, bonded, discs, lattice

SELF = MPI.COMM_SELF
LOSSES = ("bond", "contact", "friction", "fracture")


def joined(*groups: Arrays) -> Arrays:
    """Groups of elements as one, with ids in a row."""
    out = {name: np.concatenate([g[name] for g in groups]) for name in groups[0]}
    return out | {"id": np.arange(1, len(out["id"]) + 1)}


def floe_on_fixed() -> Arrays:
    floe, rock = lattice(6, 5), discs(-1700.0, 1100.0)
    floe["u"] -= 0.4
    rock["type"][:] = 2
    return joined(floe, rock)


def floe_on_floe() -> Arrays:
    one, two = lattice(5, 4), lattice(4, 5, thickness=2.0)
    two["x"] += 10_020.0
    two["y"] -= 2_300.0
    one["u"] += 0.3
    two["u"] -= 0.2
    return joined(one, two)


def two_bodies() -> Arrays:
    pair = discs([0.0, 2000.2], [0.0, 20.0])
    pair["u"][:], pair["v"][:] = (0.3, -0.3), (0.1, 0.0)
    return pair


def budget(
    log: Path, elements: Arrays, share: float, seconds: float, exact: bool = True
) -> dict[str, float]:
    """Initial energy, each loss, and the residual, all in J but the counts."""
    table = bonded(elements, gap=0.1)
    params = full_params(time_step=1.0, bonds=True, bond_damping=0.1, exact_losses=exact)
    step = share * critical_step(elements, table, params)[0]
    steps = round(seconds / step)
    params = replace(params, time_step=seconds / steps)
    with Engine(SELF, params, log) as engine:
        engine.load(elements, table)
        first = engine.diagnostics()
        engine.run(steps)
        last = engine.diagnostics()
    parts = ("kinetic_now", "rotational_now", "elastic_bond", "elastic_contact")
    before, after = (sum(d[name] for name in parts) for d in (first, last))
    losses = {name: last[f"dissipation_{name}"] for name in LOSSES}
    counts = {name: last[name] for name in ("bonds_broken", "bonds_cracked")}
    residual = before - after - sum(losses.values())
    return {"before": before, "residual": residual} | losses | counts


CASES = {"floe on fixed": (floe_on_fixed, 400.0), "floe on floe": (floe_on_floe, 400.0)}


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("name", CASES)
def test_energy_of_an_impact_is_where_the_ledger_says(log: Path, name: str, exact: bool) -> None:
    make, seconds = CASES[name]
    runs = [budget(log, make(), 0.0625 / 2**k, seconds, exact) for k in range(4)]
    assert all(run["bonds_broken"] > 5 for run in runs)
    for loss in LOSSES:
        assert runs[0][loss] > 0.01 * runs[0]["before"]
    residuals = [abs(run["residual"]) / run["before"] for run in runs]
    assert residuals[0] < (1e-6 if exact else 0.02)
    if exact:
        assert np.log2(residuals[0] / residuals[-1]) / 3 >= 1.0


def test_energy_of_two_bodies_that_collide(log: Path, show) -> None:
    shares = np.append(0.0625 / 2.0 ** np.arange(7), 0.0006)
    lines, points = {}, {}
    for exact, order, label in ((False, 1, "plain"), (True, 2, "exact_losses")):
        runs = [budget(log, two_bodies(), share, 100.0, exact) for share in shares]
        residuals = np.array([abs(run["residual"]) / run["before"] for run in runs])
        assert residuals[0] < 0.02
        # Each depends on where in a step the bodies meet: the order is that of all.
        fitted = np.polyfit(np.log(shares[:7]), np.log(residuals[:7]), 1)[0]
        assert fitted >= 0.95 * order
        lines[f"order {order}"] = (shares, residuals[0] * (shares / shares[0]) ** order)
        points[f"two bodies, {label}"] = (shares, residuals)
    assert residuals[-1] < 1e-6
    for name, (make, seconds) in CASES.items():
        few = [budget(log, make(), share, seconds) for share in shares[:4]]
        residuals = np.array([abs(r["residual"]) / r["before"] for r in few])
        points[f"{name}, exact_losses"] = (shares[:4], residuals)
    show(
        "energy_budget", figures.curves, lines, points, "step / critical step",
        "energy not accounted for / initial energy", "log",
    )  # fmt: skip


def free_cluster(log: Path, steps: int) -> tuple[np.ndarray, np.ndarray, Arrays, Arrays]:
    """Times, energies every 100 steps, first and last elements of an undamped bonded cluster."""
    raft, random = lattice(6, 5), np.random.default_rng(3)
    for name, size in (("u", 0.01), ("v", 0.01), ("omega", 1e-5)):
        raft[name] = size * random.normal(size=len(raft["id"]))
    table = bonded(raft)
    laws = {"bonds": True, "bond_damping": 0.0, "compressive_strength": 1e9, "friction": False}
    step = 0.1 * critical_step(raft, table, full_params(time_step=1.0, **laws))[0]
    energies = []
    with Engine(SELF, full_params(time_step=step, **laws), log) as engine:
        engine.load(raft, table)
        for _ in range(steps // 100):
            sums = engine.diagnostics()
            energies.append(sums["kinetic_now"] + sums["rotational_now"] + sums["elastic_bond"])
            engine.run(100)
        assert sums["elastic_bond"] > 0.1 * energies[0]
        assert sums["bonds_cracked"] == 0
        return step * 100 * np.arange(len(energies)), np.array(energies), raft, engine.elements()


@pytest.mark.parametrize("steps", [20_000, pytest.param(100_000, marks=pytest.mark.slow)])
def test_a_free_cluster_keeps_energy_and_momentum(log: Path, steps: int, show) -> None:
    times, energies, before, after = free_cluster(log, steps)
    half = len(energies) // 2
    assert energies[half:].mean() == pytest.approx(energies[:half].mean(), rel=1e-4)
    mass = before["mass"]
    for name in ("u", "v"):
        change = mass @ after[name] - mass @ before[name]
        assert abs(change) < 1e-12 * (mass @ np.abs(after[name]))
    (first, _), (last, parts) = angular_momentum(before), angular_momentum(after)
    assert abs(last - first) < 1e-10 * parts
    line = {"FloeFlow": (times, energies / energies[0])}
    show("free_cluster", figures.curves, line, {}, "time (s)", "energy / initial energy")
