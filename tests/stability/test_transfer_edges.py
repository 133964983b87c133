# SPDX-License-Identifier: GPL-2.0-or-later
"""Hard case 7: elements where a transfer to the grid has next to nothing to go by.

A plane through three points asks for three that are not in one line: cells with one element, with
all of them, with many in one place or on one line have none. Mass matrices are singular there, and
codes divide by them. What must hold: finite where there is ice, NaN where there is none; totals to
round-off, with what lies outside said; no value beyond those of the elements; ice area within the
sea of each cell where there is room for it. Scenes of one element and of none run through the
whole workflow in tests/workflow/test_absent.py.
"""

from __future__ import annotations

import numpy as np
import pytest

from floeflow.transfer import (
    ROOM,
    SHEPARD,
    Field,
    Grid,
    build_remapper,
    build_room,
    conservative_transfer,
    open_room,
)
from floeflow.transfer.bins import Room
from floeflow.transfer.conservative import Carried

FIELDS = (
    Field("area", "extensive", ROOM),
    Field("ice", "extensive", "area"),
    Field("volume", "extensive", "ice"),
    Field("temperature", "intensive", "volume"),
)
GRID = Grid(np.arange(6.0), np.arange(5.0))
SEED = 6


def transfer(x, y, room: Room | None = None, filled: float = 0.3) -> tuple[Carried, dict]:  # noqa: ANN001
    """Bring elements of mixed ice to the grid and look at what must hold of it."""
    random = np.random.default_rng(SEED)
    x, y = np.atleast_1d(np.asarray(x, float)), np.atleast_1d(np.asarray(y, float))
    room, n = room or open_room(GRID, reach=1), len(x)
    area = np.full(n, filled / max(n, 1))
    ice = area * random.uniform(0.1, 1.0, n)
    values = {
        "area": area,
        "ice": ice,
        "volume": ice * random.uniform(0.1, 4.0, n),
        "temperature": random.uniform(-40.0, 0.0, n),
    }
    parents = {name: values[name] for name in ("area", "ice", "volume")}
    remapper = build_remapper(x, y, parents, room)
    found = conservative_transfer(FIELDS, values, remapper)
    on = remapper.bins.placed()
    for name in parents:
        size = max(values[name].sum(), 1e-300)
        assert np.isfinite(found.values[name]).all() and (found.values[name] >= 0.0).all()
        assert abs(found.values[name].sum() - values[name][on].sum()) <= 1e-13 * size
        assert abs(found.outside[name] - values[name][~on].sum()) <= 1e-13 * size
    assert found.infeasible == []
    assert (found.values["area"] <= room.area * (1 + 1e-14)).all()
    assert (found.values["ice"] <= found.values["area"] * (1 + 1e-14)).all()
    warm = found.values["temperature"]
    there = found.values["volume"] > 0.0
    assert np.isfinite(warm[there]).all() and np.isnan(warm[~there]).all()
    if on.any():
        # Elements just beyond the edge belong to no cell, but are seen by the nodes.
        low, high = values["temperature"].min(), values["temperature"].max()
        slack = 1e-12 * abs(low)
        assert (warm[there] >= low - slack).all() and (warm[there] <= high + slack).all()
    return found, values | {"status": remapper.weights["area"].status}


def test_no_element_at_all():
    found, _ = transfer([], [])
    assert (found.values["area"] == 0.0).all() and np.isnan(found.values["temperature"]).all()


@pytest.mark.parametrize("place", [(2.0, 2.0), (2.3, 1.7), (-0.5, -0.5), (5.5, 4.5), (0.0, 0.0)])
def test_a_single_element(place: tuple[float, float]):
    """On a node, between nodes, in the corners: all of it arrives, and as it is."""
    found, values = transfer(*place)
    assert found.values["ice"].sum() == pytest.approx(values["ice"][0], rel=1e-14)
    assert (values["status"] <= SHEPARD).all()
    there = found.values["volume"] > 0.0
    np.testing.assert_allclose(found.values["temperature"][there], values["temperature"][0])


def test_all_elements_in_one_cell(record):
    random = np.random.default_rng(SEED)
    found, _ = transfer(*(2.0 + random.uniform(-0.5, 0.5, (2, 3000))), filled=0.9)
    record(cells_with_ice=int((found.values["ice"] > 0.0).sum()))
    # Their hats reach no farther than to the neighbours.
    far = np.maximum(*np.abs(np.meshgrid(GRID.x - 2.0, GRID.y - 2.0))) > 1.0
    assert (found.values["ice"][far] == 0.0).all()


@pytest.mark.parametrize(
    "line",
    ["along x", "along y", "diagonal", "along x, a hair off", "on the nodes", "on a cell's edge"],
)
def test_elements_in_one_line(line: str):
    """A plane has no slope across a line: nodes beside it take averages."""
    t = np.linspace(-0.4, 4.4, 40)
    random = np.random.default_rng(SEED)
    places = {
        "along x": (t, 0.0 * t + 1.3),
        "along y": (0.0 * t + 1.3, t),
        "diagonal": (t, t),
        "along x, a hair off": (t, 1.3 + 1e-9 * random.normal(size=40)),
        "on the nodes": (np.round(t), np.round(t)),
        "on a cell's edge": (t, 0.0 * t + 1.5),
    }
    transfer(*places[line])


@pytest.mark.parametrize("spread", [0.0, 1e-300, 1e-12, 1e-6])
def test_coincident_elements(spread: float):
    random = np.random.default_rng(SEED)
    transfer(*(2.3 + spread * random.normal(size=(2, 50))))


@pytest.mark.parametrize("many", [1, 4, 200])
def test_elements_leave_through_every_boundary(many: int, record):
    """Pushed out over sides and corners: what is outside is named, the rest stays whole."""
    random = np.random.default_rng(SEED)
    outside = []
    for dx, dy in [(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, 1), (1, -1), (-1, -1)]:
        x, y = 2.5 + random.uniform(-0.4, 0.4, many), 2.0 + random.uniform(-0.4, 0.4, many)
        for far in (0.0, 1.5, 2.5, 3.0, 3.5, 100.0):
            found, values = transfer(x + dx * far, y + dy * far)
        # At the end nothing is left on the grid.
        assert found.outside["ice"] == pytest.approx(values["ice"].sum(), rel=1e-14)
        assert (found.values["ice"] == 0.0).all()
        outside.append(found.outside["ice"])
    record(boundaries=len(outside))


def masked(sea: np.ndarray) -> Room:
    """Room whose sea is what a mask of three by three parts a cell leaves."""
    part = (np.arange(3) - 1.0) / 3.0
    x, y = (axis[:, None] + part for axis in (GRID.x, GRID.y))
    px, py = np.meshgrid(x.ravel(), y.ravel())
    return build_room(px[sea], py[sea], np.full(sea.sum(), 1.0 / 9.0), GRID, reach=1)


@pytest.mark.parametrize("kind", ["row", "column", "bend", "one part"])
def test_channels_of_one_cell(kind: str, record):
    """Sea one mask cell wide between land on both sides: no ice on the land."""
    sea = np.zeros((15, 18), bool)
    if kind in ("row", "bend"):
        sea[7, : 18 if kind == "row" else 10] = True
    if kind in ("column", "bend"):
        sea[7 if kind == "bend" else 0 :, 9] = True
    if kind == "one part":
        sea[7, 9] = True
    room = masked(sea)
    rows, columns = np.nonzero(sea)
    x, y = GRID.x[0] + (columns - 1.0) / 3.0, GRID.y[0] + (rows - 1.0) / 3.0
    found, _ = transfer(x, y, room, filled=0.8 * sea.sum() / 9.0)
    assert (found.values["ice"][room.area == 0.0] == 0.0).all()
    record(cells_of_sea=int((room.area > 0.0).sum()))


def test_elements_on_land_have_no_room_and_are_named():
    room = masked(np.arange(18)[None, :] * np.ones((15, 1)) < 3)
    found, values = transfer([4.0, 5.0, 0.0], [2.0, 3.0, 2.0], room)
    assert found.outside["ice"] == pytest.approx(values["ice"][:2].sum(), rel=1e-14)


@pytest.mark.parametrize("isles", [1, 5])
def test_islands_of_a_single_element(isles: int):
    """Far apart, each in a cell of its own: each keeps its temperature."""
    x = np.array([0.0, 2.0, 4.0, 0.0, 4.0])[:isles]
    y = np.array([0.0, 2.0, 4.0, 4.0, 0.0])[:isles]
    found, values = transfer(x, y)
    own = found.values["temperature"][y.astype(int), x.astype(int)]
    np.testing.assert_allclose(own, values["temperature"], rtol=1e-12)
