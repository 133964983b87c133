# SPDX-License-Identifier: GPL-2.0-or-later
"""What elements claim beyond the sea."""

from __future__ import annotations

import numpy as np
import pytest

from floeflow.coupling.crowding import REGION_SLACK, SLACK, fitting
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
    fits = fitting(shares, GRID, area)
    closed = 1.0 - np.asarray(shares.matrix @ fits)
    # No cell alone is above its slack: the remap would push 1.5 % of the pack to the ice's edge.
    assert (shares.claimed / shares.sea).max() < 1.0 + SLACK
    inner = np.zeros(GRID.shape, dtype=bool)
    inner[:, :8] = True
    left = (shares.claimed * fits / shares.sea).reshape(GRID.shape)[inner]
    assert left.max() < 1.0 + 2 * REGION_SLACK
    assert closed.max() == pytest.approx(0.015, abs=0.002)


def test_at_the_edge_there_is_room_beside():
    area, shares = pack(1.015)
    fits = fitting(shares, GRID, area).reshape(GRID.shape)
    assert fits[:, 11:].min() == 1.0


def test_what_fits_stays_as_it_is():
    area, shares = pack(1.0)
    np.testing.assert_array_equal(fitting(shares, GRID, area), 1.0)
    none = build_shares(*(np.zeros(0),) * 3, GRID, SEA)
    np.testing.assert_array_equal(fitting(none, GRID, np.zeros(0)), 1.0)
