# SPDX-License-Identifier: GPL-2.0-or-later
"""What elements claim beyond the sea."""

from __future__ import annotations

import numpy as np
import pytest

from floeflow.coupling.crowding import REGION_SLACK, SLACK, crowded
from floeflow.coupling.sea.shares import Shares, build_shares
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
