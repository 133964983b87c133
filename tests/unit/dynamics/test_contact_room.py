# SPDX-License-Identifier: GPL-2.0-or-later
"""Room for contacts: no set of neighbours that do not overlap is ever stiffer than the bound."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from floeflow.dynamics.engine.params import FIXED, EngineParams
from floeflow.dynamics.step import contact_room as contactroom
from floeflow.dynamics.step.contact_room import contact_room, element_kinds
from floeflow.dynamics.step.stiffness import pack_stiffness
from floeflow.state.bonds import Arrays
from support.full_ice import full_params
from support.rafts import discs, lattice

LAWS = full_params(time_step=1.0, contact_damping=0.3)


def crowd(random: np.random.Generator, tries: int = 200) -> Arrays:
    """A disc and others that touch it and do not overlap, of unlike radii and thicknesses."""
    spread, many = random.uniform(0.0, 1.5), random.integers(1, 30)
    angles, radii = [0.0], np.array([np.exp(random.normal(0.0, spread))])
    places = np.array([(1.0 + radii[0], 0.0)])
    side_by_side = random.random() < 0.5
    for _ in range(tries):
        r = float(np.exp(random.normal(0.0, spread)))
        k = random.integers(len(angles))
        beside = 2.0 * np.arcsin(np.sqrt(r / (1.0 + r) * radii[k] / (1.0 + radii[k])))
        at = angles[k] + beside * (1.0 + 1e-9) if side_by_side else random.uniform(0.0, 2.0 * np.pi)
        place = (1.0 + r) * np.cos(at), (1.0 + r) * np.sin(at)
        if (np.hypot(*(places - place).T) >= r + radii).all():
            angles.append(at)
            radii = np.append(radii, r)
            places = np.vstack([places, place])
        if len(radii) >= many:
            break
    x, y = np.vstack([(0.0, 0.0), places]).T
    h = np.exp(random.uniform(-2.0, 2.0, len(x)) * random.integers(0, 2))
    return discs(1e3 * x, 1e3 * y, 1e3 * np.array([1.0, *radii]), h)


def block(pack: Arrays, laws: EngineParams) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What the first disc's contacts weigh on its own motion, 3 x 3.

    Stiffness, damping, and the most that damping may be in a step of 1 s.
    """
    mass, h = pack["mass"], pack["thickness"]
    ratio = laws.contact_shear_ratio if laws.friction else 0.0
    k = laws.contact_modulus * h[0] * h[1:] / (h[0] + h[1:])
    reduced = 1.0 / (1.0 / mass[0] + 1.0 / mass[1:])
    c = 2.0 * laws.contact_damping * np.sqrt(k * reduced)
    weight = pack["radius"] / mass
    share = (1.0 + weight[1:] / weight[0]) / mass[0]
    n = np.stack([pack["x"][1:], pack["y"][1:]], axis=1)
    n /= np.hypot(*n.T)[:, None]
    opening = np.column_stack([n, np.zeros(len(n))])
    sliding = np.column_stack([-n[:, 1], n[:, 0], np.full(len(n), np.sqrt(2.0))])
    out = []
    most = contactroom.DAMPING_PER_STEP * reduced
    root_ratio = np.sqrt(ratio)
    for value, part in ((k * share, ratio), (c * share, root_ratio), (most * share, root_ratio)):
        rows = np.sqrt(value)[:, None] * opening, np.sqrt(part * value)[:, None] * sliding
        out.append(sum(row.T @ row for row in rows))
    return out[0], out[1], out[2]


@pytest.fixture(scope="module")
def crowds() -> list[Arrays]:
    random = np.random.default_rng(3)
    return [crowd(random) for _ in range(250)]


@pytest.mark.parametrize("friction", [False, True])
def test_no_crowd_is_stiffer_than_the_bound(crowds: list[Arrays], friction: bool) -> None:
    laws = replace(LAWS, friction=friction)
    shares = []
    for pack in crowds:
        bound = pack_stiffness(pack, None, laws)
        mosts = bound.stiffness.diagonal()[:3], bound.contact_damping[:3], bound.damped_per_step[:3]
        for crowded, most in zip(block(pack, laws), mosts, strict=True):
            kept = most > 0.0  # without friction nothing turns
            root = 1.0 / np.sqrt(most[kept])
            shares.append(np.linalg.eigvalsh(root[:, None] * crowded[kept][:, kept] * root)[-1])
    assert max(shares) <= 1.0 + 1e-9
    assert max(shares) > 0.9  # some crowds come close to it


def test_a_full_lattice_meets_the_bound_whatever_its_thicknesses() -> None:
    pack = lattice(3, 3)
    pack["thickness"] = np.linspace(0.2, 3.0, 9)
    pack["mass"] *= pack["thickness"]
    ring = np.argsort(np.hypot(pack["x"] - pack["x"][4], pack["y"] - pack["y"][4]), kind="stable")
    seven = {name: values[ring[:7]] for name, values in pack.items()}
    for name in ("x", "y"):
        seven[name] = seven[name] - seven[name][0]
    crowded, *_ = block(seven, LAWS)
    most = pack_stiffness(seven, None, LAWS).stiffness.diagonal()[:3]
    assert crowded[2, 2] == pytest.approx(most[2], rel=1e-9)


def test_many_kinds_are_put_together_on_the_safe_side(monkeypatch: pytest.MonkeyPatch) -> None:
    random = np.random.default_rng(2)
    pack = discs(*random.uniform(0, 1e5, (2, 300)), random.uniform(500, 1500, 300), 1.0)
    pack["thickness"] = random.uniform(0.2, 3.0, 300)
    pack["mass"] *= pack["thickness"]
    pack["type"][:5] = FIXED
    monkeypatch.setattr(contactroom, "MOST", 100)
    kinds, room = element_kinds(pack), contact_room(pack, LAWS)
    assert 20 < len(kinds.radius) <= 100
    inverse = np.where(pack["type"] == FIXED, 0.0, 1.0 / pack["mass"])
    weight, r, h, m = kinds.weight[kinds.of], pack["radius"], pack["thickness"], pack["mass"]
    assert (room.stiffness[:5] == 0.0).all()
    closest = []
    for i in range(5, 300):
        k = LAWS.contact_modulus * h[i] * h / (h[i] + h)
        c = 2.0 * LAWS.contact_damping * np.sqrt(k / (1.0 / m[i] + inverse))
        share = (1.0 + weight / weight[i]) / m[i]
        # As many of the same as find room.
        count = np.pi / np.arcsin(r / (r[i] + r))
        closest.append((count * k * share).max() / room.stiffness[i])
        assert closest[-1] <= 1.0 + 1e-12
        assert (count * c * share).max() <= room.damping[i] * (1.0 + 1e-12)
    assert min(closest) > 0.6


def test_only_neighbours_that_can_come_count() -> None:
    # A big disc with one small neighbour near it, and forty tiny ones far off.
    x = np.concatenate([[0.0, 2500.0], 1e6 + 100.0 * np.arange(40)])
    radius = np.concatenate([[1000.0, 500.0], np.full(40, 40.0)])
    pack = discs(x, 0 * x, radius, 1.0)
    near, far = contact_room(pack, LAWS, 2000.0), contact_room(pack, LAWS)
    alone = contact_room({name: values[:2] for name, values in pack.items()}, LAWS)
    assert near.stiffness[0] < 0.2 * far.stiffness[0]
    # Small and big are all that can meet each other, as if the others were not there; no disc of
    # its own kind is near either.
    assert near.stiffness[0] <= alone.stiffness[0] * (1 + 1e-12)
    assert near.stiffness[0] > 0.0
    assert contact_room(pack, LAWS, 900.0).stiffness[0] == 0.0


def test_discs_that_overlap_count_each() -> None:
    # More discs around one than find room side by side: all touch it now.
    angle = 2.0 * np.pi * np.arange(12) / 12
    x, y = np.append(0.0, 1500.0 * np.cos(angle)), np.append(0.0, 1500.0 * np.sin(angle))
    pack = discs(x, y, np.full(13, 1000.0), 1.0)
    room = contact_room(pack, LAWS, 10.0)
    one = 2.0 * LAWS.contact_modulus * 0.5 / pack["mass"][0]
    assert room.stiffness[0] == pytest.approx(12 * one, rel=1e-12)
    assert room.stiffest[0] == pytest.approx(one, rel=1e-12)


def ring(count: int, small: float, gap: float = 0.0) -> Arrays:
    """A disc of 1 km and so many smaller ones (m) side by side around it, at a gap (m)."""
    beside = 2.0 * np.arcsin(small / (1000.0 + small)) * np.arange(count)
    away = 1000.0 + small + gap
    x, y = away * np.cos(beside), away * np.sin(beside)
    return discs(
        np.append(0.0, x), np.append(0.0, y), np.append(1000.0, np.full(count, small)), 1.0
    )


def test_each_neighbour_counts_once() -> None:
    # Few small discs near a large one do not fill the turn about it; as many as find room do.
    room = {count: contact_room(ring(count, 100.0, 1.0), LAWS, 10.0) for count in (1, 8, 34)}
    least, eight, all_round = (room[count].stiffness[0] for count in room)
    one = room[1].stiffest[0]
    assert least == pytest.approx(contactroom.FEWEST * one, rel=1e-12)
    assert eight == pytest.approx(8 * one, rel=1e-12)
    assert all_round == pytest.approx(34 * one, rel=1e-12)
    # A second ring behind the first can come as near, but finds no room.
    two = {
        name: np.concatenate([values, ring(34, 100.0, 205.0)[name][1:]])
        for name, values in ring(34, 100.0, 1.0).items()
    }
    full = contact_room(two, LAWS, 210.0).stiffness[0]
    assert full == pytest.approx(np.pi / np.arcsin(100.0 / 1100.0) * one, rel=1e-12)
    assert room[8].damped_per_step[0] < 0.3 * room[34].damped_per_step[0]


def test_walls_take_the_room_that_neighbours_leave() -> None:
    laws = replace(LAWS, walls=True)
    few, wide = (
        contact_room(ring(8, 100.0, 1.0), each, 10.0).stiffness[0] for each in (LAWS, laws)
    )
    # A wall is as stiff as the ice itself, a neighbour of one thickness half of it.
    turn = 2.0 * np.pi - 8 * 2.0 * np.arcsin(100.0 / 1100.0)
    beside = 2.0 * np.arcsin(np.sqrt(0.5 * 100.0 / 1100.0))
    wall = LAWS.contact_modulus / discs(0.0, 0.0, 1000.0, 1.0)["mass"]
    assert wide == pytest.approx(few + turn / beside * float(np.squeeze(wall)), rel=1e-9)


def test_a_crowd_within_reach_is_never_stiffer_than_the_bound(crowds: list[Arrays]) -> None:
    # As above, but each of the crowd is known and counts once; a tenth of their radius away.
    shares = []
    for pack in crowds:
        off = {**pack, "x": 1.01 * pack["x"], "y": 1.01 * pack["y"]}
        room = contact_room(off, LAWS, 0.2 * float(pack["radius"].max() + pack["radius"][0]))
        mass, h, inverse = pack["mass"], pack["thickness"], pack["radius"] / pack["mass"]
        k = LAWS.contact_modulus * h[0] * h[1:] / (h[0] + h[1:])
        total = float((k * (1.0 + inverse[1:] / inverse[0])).sum()) / mass[0]
        shares.append(total / room.stiffness[0])
    assert max(shares) <= 1.0 + 1e-9
    assert max(shares) > 0.9


def test_damping_in_a_step_does_not_grow_with_the_crowd() -> None:
    # Ever smaller discs around one: their damping adds up, what it takes in a step does not.
    per_step, damped = [], []
    for small in (500.0, 100.0, 20.0, 4.0):
        pack = ring(int(np.pi / np.arcsin(small / (1000.0 + small))), small)
        room = contact_room(pack, LAWS, 10.0)
        per_step.append(room.damped_per_step[0])
        damped.append(room.damping[0])
    assert max(per_step) < 6 * contactroom.DAMPING_PER_STEP
    assert damped[-1] > 3 * damped[0]
