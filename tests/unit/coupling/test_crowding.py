# SPDX-License-Identifier: GPL-2.0-or-later
"""What elements claim beyond the sea."""

from __future__ import annotations

import numpy as np
import pytest

from floeflow.coupling.crowding import REGION_SLACK, SLACK, crowded
from floeflow.coupling.sea.shares import Shares, balanced_pull, build_shares
from floeflow.transfer import Grid

GRID = Grid(np.arange(0.5, 24) * 1e5, np.arange(0.5, 12) * 1e5)
SEA = np.full(GRID.shape, 1e10)


def pack(crowd: float) -> tuple[np.ndarray, Shares]:
    """Elements of 50 km on the western half of the sea, which claim so many times what is there."""
    x, y = (v.ravel() for v in np.meshgrid(np.arange(25e3, 12e5, 5e4), np.arange(25e3, 12e5, 5e4)))
    area = np.full(x.size, crowd * 25e8)
    return area, build_shares(x, y, area, GRID, SEA)


def test_a_wide_pack_keeps_no_more_than_its_sea():
    area, shares = pack(1.015)
    closed = crowded(shares, GRID, area, np.full(area.size, 2.0))
    # No cell alone is above its slack: the remap would push 1.5 % of the pack to the ice's edge.
    assert (shares.claimed / shares.sea).max() < 1.0 + SLACK
    inner = np.zeros(GRID.shape, dtype=bool)
    inner[:, :8] = True
    left = (shares.give(area - closed) / shares.sea).reshape(GRID.shape)[inner]
    assert left.max() < 1.0 + 2 * REGION_SLACK
    assert (closed / area).max() == pytest.approx(0.015, abs=0.002)


def test_at_the_edge_there_is_room_beside():
    area, shares = pack(1.015)
    closed = crowded(shares, GRID, area, np.full(area.size, 2.0))
    x = np.tile(np.arange(25e3, 12e5, 5e4), 24)
    assert (closed[x > 1.15e6] / area[0]).max() < 0.002


def test_weak_ice_gives_way():
    area, shares = pack(1.015)
    thickness = np.where(np.arange(area.size) % 2 == 0, 1.0, 4.0)  # columns of thin and thick
    closed = crowded(shares, GRID, area, thickness)
    even = crowded(shares, GRID, area, np.full(area.size, 2.0))
    assert closed.sum() == pytest.approx(even.sum(), rel=0.1)
    assert closed[::2].sum() == pytest.approx(16 * closed[1::2].sum(), rel=0.1)


def test_small_elements_are_not_used_up():
    """A speck of thin ice gives nothing to what is too much about it, and others give the rest."""
    area, shares = pack(1.08)
    thickness = np.full(area.size, 2.0)
    even = crowded(shares, GRID, area, thickness)
    assert even[300] > 0.0
    area[300] *= 0.15
    thickness[300] = 0.05
    closed = crowded(shares, GRID, area, thickness)
    assert closed[300] == 0.0 and closed.sum() > 0.9 * even.sum()


def test_a_bay_keeps_no_more_than_its_slack():
    # Two elements in the only cell with sea, which claim twice what is there.
    sea = np.zeros(GRID.shape)
    sea[6, 6] = 1e10
    place, area = np.full(2, 6.5e5), np.full(2, 1e10)
    shares = build_shares(place, place, area, GRID, sea)
    closed = crowded(shares, GRID, area, np.ones(2))
    assert shares.claimed.max() == pytest.approx(2e10)
    assert (area - closed).sum() < (1.0 + SLACK) * 1e10


def test_what_fits_stays_as_it_is():
    area, shares = pack(1.0)
    np.testing.assert_array_equal(crowded(shares, GRID, area, np.ones(area.size)), 0.0)
    none = build_shares(*(np.zeros(0),) * 3, GRID, SEA)
    assert crowded(none, GRID, np.zeros(0), np.zeros(0)).size == 0


def ragged_basin() -> tuple[np.ndarray, ...]:
    """Centres (m) of the mask cells of 25 km of a sea whose coast has bays, and elements on it.

    An element is what sea there is in a square of 50 km.
    """
    axis = np.arange(12.5e3, 24e5, 25e3)
    x, y = np.meshgrid(axis, axis)
    away = np.hypot(x - 12e5, y - 12e5)
    angle = np.arctan2(y - 12e5, x - 12e5)
    wet = away < 9e5 + 1e5 * np.sin(9 * angle) + 8e4 * np.sin(23 * angle)
    x, y = x[wet], y[wet]
    _, block = np.unique((y // 5e4) * 1000 + x // 5e4, return_inverse=True)
    count = np.bincount(block)
    places = (np.bincount(block, values) / count for values in (x, y))
    return x, y, *places, 6.25e8 * count


def test_a_full_basin_with_bays_is_crowded_nowhere():
    wet_x, wet_y, x, y, area = ragged_basin()
    axis = np.arange(0.5, 24) * 1e5
    grid = Grid(axis, axis)
    pull = balanced_pull(wet_x, wet_y, np.full(wet_x.size, 6.25e8), grid)
    sea = np.bincount(grid.cell_of(wet_x, wet_y), minlength=24 * 24) * 6.25e8
    sea = sea.reshape(grid.shape)
    thickness = np.full(area.size, 2.0)
    shares = build_shares(x, y, area, grid, sea, pull)
    closed = crowded(shares, grid, area, thickness)
    assert area.sum() == pytest.approx(sea.sum(), rel=1e-12)
    assert closed.sum() < 1e-5 * area.sum()
    assert shares.open_area.sum() < 1e-3 * area.sum()
    # With pulls in proportion to the sea the bays stay open, and all else is crowded.
    plain = build_shares(x, y, area, grid, sea)
    assert crowded(plain, grid, area, thickness).sum() > 2e-3 * area.sum()
    assert plain.open_area.sum() > 3e-3 * area.sum()


def test_balanced_cells_are_full_where_all_sea_is_ice():
    wet_x, wet_y, *_ = ragged_basin()
    axis = np.arange(0.5, 24) * 1e5
    grid, area = Grid(axis, axis), np.full(wet_x.size, 6.25e8)
    pull = balanced_pull(wet_x, wet_y, area, grid)
    sea = np.bincount(grid.cell_of(wet_x, wet_y), area, minlength=24 * 24)
    assert ((pull > 0.0) == (sea > 0.0)).all()
    hats = build_shares(wet_x, wet_y, area, grid, sea.reshape(grid.shape), pull)
    assert np.abs(hats.claimed - sea).sum() < 1e-3 * sea.sum()
    assert balanced_pull(*(np.zeros(0),) * 3, grid).shape == (24 * 24,)
