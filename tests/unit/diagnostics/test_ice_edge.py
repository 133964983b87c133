# SPDX-License-Identifier: GPL-2.0-or-later
"""Extent and distances of edges that can be told by hand."""

from __future__ import annotations

import numpy as np
import pytest

from floeflow.diagnostics.ice_edge import edge_error, edge_length, extent, marginal

AREA = np.full((20, 30), 4.0)


def ice_up_to(column: int) -> np.ndarray:
    return np.where(np.arange(30) < column, 0.9, 0.0) * np.ones((20, 1))


def test_extent_and_marginal_zone():
    share = ice_up_to(10)
    share[:, 10] = 0.5
    share[0, 0] = np.nan
    assert extent(share, AREA) == 4.0 * (11 * 20 - 1)
    assert marginal(share, AREA) == 4.0 * 20


def test_straight_edges_lie_as_far_apart_as_they_do():
    found = edge_error(ice_up_to(14), ice_up_to(11), AREA, 2.0)
    assert (found.over, found.under) == (3 * 20 * 4.0, 0.0)
    assert found.length == pytest.approx(19 * 2.0)
    assert found.displacement == pytest.approx(found.integrated / 38.0)
    assert edge_error(ice_up_to(9), ice_up_to(11), AREA, 2.0).under == 2 * 20 * 4.0


def test_a_diagonal_edge_has_its_length_and_a_coast_none():
    share = np.tri(40)
    assert edge_length(share, np.ones((40, 40), bool), 1.0) == pytest.approx(
        39 * np.sqrt(2), rel=0.06
    )
    sea = np.ones((20, 30), bool)
    sea[:, 10:] = False
    assert edge_length(ice_up_to(10), sea, 1.0) == 0.0


def test_what_is_unknown_is_no_error():
    unknown = np.full((20, 30), np.nan)
    found = edge_error(ice_up_to(9), unknown, AREA, 2.0)
    assert found.integrated == 0.0 and np.isnan(found.displacement)
