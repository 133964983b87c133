# SPDX-License-Identifier: GPL-2.0-or-later
"""Hard case 5: bonds that break all at once, from both ends, or must not break at all."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from floeflow.core.errors import FloeError
from support.full_ice import full_params
from support.rafts import bonded, discs, lattice
from support.stability.packs import neighbours
from support.stability.watch import default_step, watch

LAWS = full_params(time_step=1.0, bonds=True, compressive_strength=1e6, tensile_share=0.1)


@pytest.mark.parametrize("side", [20, pytest.param(60, marks=pytest.mark.slow)])
def test_all_bonds_break_in_one_step(log: Path, side: int, record):
    """A sheet flies apart so fast that no bond survives the first step."""
    pack = lattice(side, side)
    bonds = neighbours(pack)
    x, y = (pack[name] - pack[name].mean() for name in "xy")
    pack |= {"u": 0.002 * x, "v": 0.002 * y}
    params = default_step(pack, bonds, LAWS, 0.8)
    broken = []
    seen = watch(
        log, pack, params, 20 * params.time_step, bonds, samples=20,
        look=lambda engine, _: broken.append(engine.diagnostics()["bonds_broken"]),
    )  # fmt: skip
    count = len(bonds["id_lo"])
    assert broken[1] == count and len(seen.bonds["id_lo"]) == 0
    mass = pack["mass"] @ np.hypot(pack["u"], pack["v"])
    assert np.abs(seen.momentum).max() < 1e-12 * mass
    record(bonds=count, residual=seen.residual)
    assert seen.residual < 0.02


def test_a_bond_cracks_from_both_ends_at_once(log: Path, record):
    """Two discs turn against each other: one end opens, the other is crushed."""
    pair = discs([0.0, 2000.0], [0.0, 0.0])
    pair["omega"] = np.array([2e-3, -2e-3])
    bonds = bonded(pair)
    laws = replace(LAWS, tensile_share=1.0, bond_damping=0.0)
    params = default_step(pair, bonds, laws, 0.05)
    cracks = []

    def look(engine, _):  # noqa: ANN001
        table = engine.bonds()
        if len(table["id_lo"]):
            cracks.append((table["crack_a"][0], table["crack_b"][0]))

    seen = watch(log, pair, params, 40.0, bonds, samples=100, look=look)
    both = [a > 0.0 and b > 0.0 for a, b in cracks]
    record(cracked_at_both_ends=sum(both), residual=seen.residual)
    # As strong against pulling as against pushing, it cracks alike at either end.
    assert any(both)
    assert all(a == pytest.approx(b, rel=0.06, abs=1e-6) for a, b in cracks[:20])
    assert seen.residual < 0.02


def test_a_sheet_that_only_turns_does_not_crack(log: Path, record):
    """A raft turns by many times its own width as one body."""
    pack = lattice(8, 8)
    bonds = neighbours(pack)
    spin = 2e-4
    x, y = (pack[name] - pack[name].mean() for name in "xy")
    pack |= {"u": -spin * y, "v": spin * x, "omega": np.full(len(x), spin)}
    params = default_step(pack, bonds, LAWS, 0.8)
    seen = watch(log, pack, params, 2.0 * np.pi / spin, bonds, samples=50)
    record(turns=1.0, residual=seen.residual, energy_kept=seen.energy[-1] / seen.energy[0])
    assert seen.sums["bonds_cracked"] == 0 and seen.sums["bonds_broken"] == 0
    assert seen.energy[-1] == pytest.approx(seen.energy[0], rel=0.02)
    assert seen.residual < 0.02


def test_bonds_of_a_metre_beside_bonds_of_a_hundred_kilometres(log: Path, record):
    """The smallest discs set the step; the largest hold together all the same."""
    big = discs([0.0, 2e5], [0.0, 0.0], 1e5, 1.0)
    small = discs([1e5, 1e5], [1e5, 1e5 + 1.0], 0.5, 1.0)
    pack = {name: np.concatenate([big[name], small[name]]) for name in big}
    pack["id"] = np.arange(1, 5)
    bonds = {
        name: np.concatenate(
            [bonded(big)[name], bonded(small | {"id": np.array([3, 4])}, gap=0.01)[name]]
        )
        for name in bonded(big)
    }
    assert sorted(np.round(bonds["length"], 3)) == pytest.approx([0.577, 115470.054], rel=1e-3)
    pack["u"] = np.array([0.01, -0.01, 0.0, 0.0])
    params = default_step(pack, bonds, replace(LAWS, compressive_strength=1e8), 0.8)
    seen = watch(log, pack, params, 2000 * params.time_step, bonds)
    record(step=params.time_step, residual=seen.residual)
    assert len(seen.bonds["id_lo"]) == 2
    assert seen.residual < 0.02


@pytest.mark.parametrize(
    ("strength", "sentence"),
    [
        (0.0, "compressive_strength must be above 0"),
        (-1.0, "compressive_strength must be above 0"),
        (np.inf, "compressive_strength must be finite"),
        (np.nan, "compressive_strength must be finite"),
    ],
)
def test_no_strength_and_endless_strength_are_refused(strength: float, sentence: str):
    with pytest.raises(FloeError, match=sentence):
        full_params(time_step=1.0, bonds=True, compressive_strength=strength)


def test_ice_that_nothing_breaks_is_refused_where_neighbours_cannot_follow(log: Path):
    pack = lattice(4, 4)
    with pytest.raises(FloeError, match="The bond between elements .* survives until its centres"):
        watch(log, pack, replace(LAWS, compressive_strength=1e30), 1.0, neighbours(pack))


def test_ice_of_next_to_no_strength_falls_apart_quietly(log: Path, record):
    pack = lattice(8, 8)
    bonds = neighbours(pack)
    pack["u"] = np.random.default_rng(3).normal(scale=1e-3, size=64)
    params = default_step(pack, bonds, replace(LAWS, compressive_strength=1e-9), 0.8)
    seen = watch(log, pack, params, 2000.0, bonds)
    record(broken=seen.sums["bonds_broken"], largest_speed=seen.largest_speed)
    assert len(seen.bonds["id_lo"]) == 0
    assert seen.largest_speed <= 1.01 * np.abs(pack["u"]).max()
