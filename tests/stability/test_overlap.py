# SPDX-License-Identifier: GPL-2.0-or-later
"""Hard case 3: packs that overlap from the start, discs at one place, large beside small discs.

What must hold: the pack is refused in a sentence, or it runs, and what was placed into each other
is not thrown apart.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from floeflow.core.errors import FloeError
from floeflow.dynamics.ridging.overlaps import overlapping_pairs, rest_overlaps
from floeflow.state.bonds import CONTACT_COLUMNS, empty_pairs
from support.full_ice import full_params
from support.rafts import discs, lattice, uniform
from support.stability.packs import random_pack, squeezed
from support.stability.watch import default_step, watch

LAWS = full_params(time_step=1.0, ocean_drag=True)
STILL = uniform((0.0, 0.0), (0.0, 0.0))


@pytest.mark.parametrize("share", [0.01, 0.1, 0.5])
@pytest.mark.parametrize("kind", ["lattice", "random"])
def test_overlapping_packs_stay_at_rest(log: Path, kind: str, share: float, record):
    pack = squeezed(lattice(8, 8) if kind == "lattice" else random_pack(64), share)
    contacts = rest_overlaps(pack, None, empty_pairs(CONTACT_COLUMNS))
    assert len(contacts["id_lo"]) >= 40
    params = default_step(pack, None, LAWS, 0.8)
    seen = watch(log, pack, params, 500 * params.time_step, None, contacts, STILL)
    record(contacts=len(contacts["id_lo"]), largest_speed=seen.largest_speed)
    assert seen.largest_speed < 1e-6


@pytest.mark.parametrize("share", [0.01, 0.1, 0.5])
def test_overlapping_packs_part_without_a_push(log: Path, share: float, record):
    """Discs that drift apart let go of their overlap; none gets faster than it was."""
    pack = squeezed(lattice(6, 6), share)
    x, y = (pack[name] - pack[name].mean() for name in "xy")
    pack |= {"u": 1e-4 * x, "v": 1e-4 * y}
    contacts = rest_overlaps(pack, None, empty_pairs(CONTACT_COLUMNS))
    params = default_step(pack, None, full_params(time_step=1.0), 0.8)
    seen = watch(log, pack, params, 2e4, None, contacts)
    record(largest_speed=seen.largest_speed)
    assert seen.largest_speed <= np.hypot(pack["u"], pack["v"]).max() * (1 + 1e-9)
    assert len(seen.contacts["id_lo"]) < len(contacts["id_lo"]) / 10


def test_pressed_overlaps_push_with_what_was_added(log: Path):
    """A pair at rest in an overlap meets a third that presses it together."""
    pack = discs([0.0, 1500.0, 3600.0], [0.0, 0.0, 0.0])
    pack["u"] = np.array([0.0, 0.0, -0.5])
    contacts = rest_overlaps(pack, None, empty_pairs(CONTACT_COLUMNS))
    assert contacts["rest_overlap"] == pytest.approx([500.0])
    params = default_step(pack, None, full_params(time_step=1.0, friction=False), 0.4)
    seen = watch(log, pack, params, 1500.0, None, contacts)
    assert seen.elements["u"][0] < -0.01
    total = pack["mass"] @ pack["u"]
    assert seen.momentum[0] == pytest.approx(total, rel=1e-12)
    assert seen.energy[-1] <= seen.energy[0]


def test_two_elements_at_one_place_are_refused():
    pack = discs([0.0, 3000.0, 3000.0], [0.0, 10.0, 10.0])
    with pytest.raises(
        FloeError, match="Elements 2 and 3 are at the same place, x = 3000 m, y = 10"
    ):
        overlapping_pairs(pack)


@pytest.mark.parametrize("radius", [0.0, -1.0, np.nan, np.inf])
def test_radii_that_no_disc_has_are_refused(log: Path, radius: float):
    pack = discs([0.0, 3000.0], [0.0, 0.0])
    pack["radius"] = np.array([1000.0, radius])
    with pytest.raises(FloeError, match="radius of element 2 must be above 0"):
        watch(log, pack, LAWS, 1.0, forcing=STILL)


def test_a_large_disc_among_small_ones(log: Path, record):
    """One disc a thousand times as wide as its neighbours, pushed through them."""
    angle = 2.0 * np.pi * np.arange(200) / 200
    large = discs([0.0], [0.0], 1e5, 2.0)
    small = discs(1.001e5 * np.cos(angle), 1.001e5 * np.sin(angle), 100.0, 0.5)
    pack = {name: np.concatenate([large[name], small[name]]) for name in large}
    pack["id"] = np.arange(1, 202)
    pack["u"][0] = 0.2
    params = default_step(pack, None, full_params(time_step=1.0), 0.8)
    seen = watch(log, pack, params, 3000.0)
    record(step=params.time_step, largest_overlap=seen.largest_overlap, residual=seen.residual)
    # What a heavy body hits leaves with at most twice its speed.
    assert seen.largest_speed < 0.41
    assert seen.largest_overlap < 0.5
    assert seen.residual < 0.02


@pytest.mark.parametrize("spread", [1.0, 30.0])
def test_the_search_finds_what_a_search_of_all_pairs_finds(spread: float):
    random = np.random.default_rng(8)
    radius = np.exp(random.uniform(0.0, np.log(spread * 10.0), 300))
    pack = discs(*random.uniform(0.0, 300.0, (2, 300)), radius)
    distance = np.hypot(*(pack[name][:, None] - pack[name] for name in "xy"))
    expected = np.argwhere(np.triu(distance < radius[:, None] + radius, 1))
    lo, hi, overlap = overlapping_pairs(pack)
    np.testing.assert_array_equal(np.column_stack([lo, hi]), expected)
    assert (overlap > 0).all()
