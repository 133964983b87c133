# SPDX-License-Identifier: GPL-2.0-or-later
"""The watch of the pack: overlaps, claims and ice on land of elements that were moved by hand."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest
import xarray as xr

from floeflow.core.grids import Grid
from floeflow.state.snapshots import snapshot
from support.coasts import SIDE, a_mask, a_scene, first_state

SEA, LAND = 20, 4  # cells of 10 km along each side, and how many of them are land in the west


@pytest.fixture
def watching(project: object, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(f"{project}/benchmarks")
    import packwatch

    return packwatch


@pytest.fixture(scope="module")
def start() -> tuple[xr.Dataset, xr.Dataset]:
    land = np.zeros((SEA, SEA), dtype=bool)
    land[:, :LAND] = True
    scene, mask = a_scene(60, 86400.0, "remap"), a_mask(land)
    state, _ = first_state(scene, mask)
    return snapshot(state), mask


def test_a_packing_claims_its_sea_and_nothing_else(
    watching: ModuleType, start: tuple[xr.Dataset, xr.Dataset]
) -> None:
    state, mask = start
    five = SIDE * (5.0 * np.arange(4) + 2.5)
    seen = watching.watch(state, watching.sea_of(mask, Grid(five, five, 5 * SIDE, 0.0, 0.0)))
    assert seen.elements == 60 and seen.ashore == 0 and seen.day == 0.0
    assert seen.outline_error < 1e-12 and seen.sum_error < 1e-12 and abs(seen.water) < 1e-12
    assert seen.cells_overlap < 1e-9 and seen.crowded < 1e-9 and seen.outlines_on_land < 1e-9
    assert seen.ice_area == pytest.approx(SEA * (SEA - LAND) * SIDE**2)
    # Bonds hold the sides between elements whose discs are near, not the rim.
    assert 0.3 < seen.bonded / seen.perimeter < 1.0


def test_ice_that_was_moved_is_found_on_land_and_over_others(
    watching: ModuleType, start: tuple[xr.Dataset, xr.Dataset]
) -> None:
    state, mask = start
    five = SIDE * (5.0 * np.arange(4) + 2.5)
    sea = watching.sea_of(mask, Grid(five, five, 5 * SIDE, 0.0, 0.0))
    mobile = np.flatnonzero(state["type"].values == 1)
    row = mobile[np.argmin(np.hypot(*(state[a].values[mobile] - SIDE * 10 for a in "xy")))]
    moved = state.copy(deep=True)
    moved["x"].values[row] = 1.8 * SIDE  # in the middle of the land
    seen = watching.watch(moved, sea)
    share = float(state["area"].values[row] / state["area"].values[mobile].sum())
    assert seen.ashore == 1 and seen.cells_overlap < 1e-9
    assert seen.outlines_on_land == pytest.approx(share, rel=1e-6)
    assert seen.crowded == pytest.approx(share, rel=1e-6)  # the sea of that cell is full without it
    assert 0.8 * share < seen.discs_on_land <= share * (1 + 1e-6)
    # Onto its neighbour: what both share.
    other = mobile[np.argsort(np.hypot(*(state[a].values[mobile] - state[a].values[row]
                                         for a in "xy")))[1]]  # fmt: skip
    moved = state.copy(deep=True)
    for axis in "xy":
        moved[axis].values[row] = state[axis].values[other]
    one, two = watching.shapes(moved, np.array([row, other]))
    seen = watching.watch(moved, sea)
    assert seen.cells_overlap >= one.intersection(two).area / float(state["area"].sum()) - 1e-9
    assert seen.ashore == 0


def test_contacts_all_around_are_as_long_as_the_outline(watching: ModuleType) -> None:
    """Hexagons of 2 m across whose discs just touch: six neighbours, the whole outline."""
    row, column = np.divmod(np.arange(49), 7)
    place = np.stack([2.0 * column + row % 2, np.sqrt(3.0) * row], axis=1)
    size = np.full(49, 1.0 + 1e-9)
    count, share = watching.contacts_of(place, size, np.full(49, 2.0 * np.sqrt(3.0)))
    inner = (row > 0) & (row < 6) & (column > 0) & (column < 6)
    assert (count[inner] == 6).all() and (count[~inner] < 6).all()
    np.testing.assert_allclose(share[inner], 1.0, rtol=1e-8)
    np.testing.assert_allclose(share, count / 6.0, rtol=1e-8)
