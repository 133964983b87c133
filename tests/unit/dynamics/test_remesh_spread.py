# SPDX-License-Identifier: GPL-2.0-or-later
"""Making room: capacities, totals, bounds, basins that are too small, sparse cells and holes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import sparse

from floeflow.dynamics.remesh.spread import enclosed, join_sparse_cells, spread


def lattice(rows: int, columns: int) -> sparse.csr_matrix:
    """Sides of a grid of squares."""
    cell = np.arange(rows * columns).reshape(rows, columns)
    a = np.concatenate([cell[:, :-1].ravel(), cell[:-1].ravel()])
    b = np.concatenate([cell[:, 1:].ravel(), cell[1:].ravel()])
    half = sparse.coo_matrix((np.ones(len(a)), (a, b)), shape=(cell.size, cell.size))
    return sparse.csr_matrix(half + half.T)


@given(st.integers(0, 10**6), st.integers(2, 9), st.integers(2, 9), st.floats(0.2, 1.5))
@settings(max_examples=80)
def test_none_is_overfull_and_nothing_is_lost(seed, rows, columns, fullness) -> None:
    random = np.random.default_rng(seed)
    count = rows * columns
    area = fullness * random.exponential(1.0, count) * random.integers(0, 2, count)
    capacity = random.uniform(0.5, 1.5, count)
    move = spread(area, capacity, lattice(rows, columns))
    after = move(area)
    most = capacity * max(1.0, area.sum() / capacity.sum())
    assert (after <= most * (1 + 1e-9)).all() and (after >= 0).all()
    assert after.sum() == pytest.approx(area.sum(), rel=1e-13)
    # What sits on the area stays within the bounds of where it was, and a constant is one.
    value = random.uniform(2.0, 3.0, (count, 2))
    held = move(area[:, None] * value)
    some = after > 1e-9
    new = held[some] / after[some, None]
    there = area > 0
    if there.any():
        assert (new <= value[there].max(axis=0) * (1 + 1e-12)).all()
        assert (new >= value[there].min(axis=0) * (1 - 1e-12)).all()
    np.testing.assert_allclose(held.sum(axis=0), (area[:, None] * value).sum(axis=0), rtol=1e-13)


def test_what_has_room_stays() -> None:
    area = np.full(12, 0.9)
    move = spread(area, np.ones(12), lattice(3, 4))
    np.testing.assert_array_equal(move(area), area)


def test_excess_goes_no_further_than_it_must() -> None:
    area, beside = np.zeros(81), lattice(9, 9)
    area[40] = 3.0
    after = spread(area, np.ones(81), beside)(area)
    distance = np.abs(np.arange(81) // 9 - 4) + np.abs(np.arange(81) % 9 - 4)
    assert after[40] == pytest.approx(1.0) and (after[distance > 1] == 0).all()
    np.testing.assert_allclose(after[distance == 1], 0.5)


def test_a_basin_that_is_too_small_is_overfull_evenly() -> None:
    beside = sparse.block_diag([lattice(2, 2), lattice(2, 2)], format="csr")
    area = np.array([8.0, 0, 0, 0, 1.5, 0, 0, 0])
    after = spread(area, np.ones(8), beside)(area)
    np.testing.assert_allclose(after[:4], 2.0, rtol=1e-9)
    assert after[4:].max() <= 1.0 + 1e-12 and after[4:].sum() == pytest.approx(1.5)


def test_sparse_cells_join_a_filled_neighbour() -> None:
    beside = lattice(1, 4)
    area = np.array([0.9, 0.05, 0.0, 0.04])
    joined = join_sparse_cells(area, np.ones(4), beside)
    np.testing.assert_allclose(joined @ area, [0.99, 0.0, 0.0, 0.0])


def test_a_floe_over_sparse_cells_comes_together() -> None:
    area = np.zeros(49)
    area[[16, 17, 23, 24]] = 0.2, 0.21, 0.19, 0.2
    joined = join_sparse_cells(area, np.ones(49), lattice(7, 7))
    after = joined @ area
    assert after.sum() == pytest.approx(0.8) and (after > 0).sum() <= 2
    assert after[after > 0].min() >= 0.25
    # A cell with nothing around it stays.
    alone = np.zeros(49)
    alone[[0, 48]] = 0.1, 1.0
    joined = join_sparse_cells(alone, np.ones(49), lattice(7, 7))
    np.testing.assert_array_equal(joined @ alone, alone)


def test_holes_are_cells_with_ice_on_all_sides() -> None:
    held = np.ones(25, dtype=bool)
    held[[12, 3, 4]] = False
    hole = enclosed(held, lattice(5, 5)) & ~held
    assert np.flatnonzero(hole).tolist() == [12]
