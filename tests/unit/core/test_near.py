# SPDX-License-Identifier: GPL-2.0-or-later
"""Compiled searches among points against the obvious ways, which take the square of the time."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from floeflow.core import near


def powers(points: np.ndarray, marks: np.ndarray, weight: np.ndarray) -> np.ndarray:
    return ((marks[:, None] - points) ** 2).sum(axis=2) - weight


@settings(max_examples=40, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    count=st.integers(1, 60),
    stretch=st.sampled_from([0.0, 1e-6, 1.0, 300.0]),
    weighted=st.booleans(),
)
def test_each_mark_goes_to_the_point_of_least_power(
    seed: int, count: int, stretch: float, weighted: bool
) -> None:
    rng = np.random.default_rng(seed)
    points = rng.uniform(-3e6, 3e6, (count, 2)) * [1.0, stretch]
    marks = rng.uniform(-4e6, 4e6, (200, 2))
    weight = rng.uniform(0, 1e12, count) if weighted else np.zeros(count)
    found = near.owners(points, marks, weight)
    power = powers(points, marks, weight)
    assert (power[np.arange(200), found] <= power.min(axis=1) + 1e2).all()  # of 1e13 m2


def test_marks_stay_in_their_territory() -> None:
    rng = np.random.default_rng(2)
    points, marks = rng.random((40, 2)), rng.random((500, 2))
    of, of_mark = np.arange(40) % 3, np.arange(500) % 3
    found = near.owners(points, marks, None, (of, of_mark))
    distance = powers(points, marks, np.zeros(40))
    distance[of_mark[:, None] != of] = np.inf
    np.testing.assert_array_equal(found, distance.argmin(axis=1))


def test_thinning_keeps_each_points_own_distance() -> None:
    rng = np.random.default_rng(4)
    points, reach = rng.random((600, 2)), rng.uniform(0.02, 0.1, 600)
    rank = rng.permutation(600)
    kept = near.thin(points, rank, reach)
    distance = np.hypot(*(points[:, None] - points).transpose(2, 0, 1))
    clash = distance < 0.5 * (reach[:, None] + reach)
    np.fill_diagonal(clash, False)
    assert not clash[kept][:, kept].any()
    # Whoever went clashes with one that was thrown before it.
    earlier = rank[None, :] < rank[:, None]
    assert (clash & earlier & kept)[~kept].any(axis=1).all()


def test_pushes_part_each_pair_by_the_share_and_keep_the_middle() -> None:
    rng = np.random.default_rng(5)
    points, radius = rng.random((80, 2)), rng.uniform(0.02, 0.08, 80)
    moves, deepest = near.pushes(points, radius, 80, 0.25)
    apart = points - points[:, None]
    distance = np.hypot(*apart.transpose(2, 0, 1))
    np.fill_diagonal(distance, 1.0)
    overlap = np.maximum(radius[:, None] + radius - distance, 0.0)
    np.fill_diagonal(overlap, 0.0)
    wanted = -(0.25 * (overlap / distance)[:, :, None] * apart).sum(axis=1)
    np.testing.assert_allclose(moves, wanted, atol=1e-14)
    assert deepest == pytest.approx(overlap.max(), rel=1e-12)


def test_fixed_discs_push_and_stay() -> None:
    points, radius = np.array([[0.0, 0.0], [1.0, 0.0]]), np.array([0.75, 0.75])
    moves, _ = near.pushes(points, radius, 1, 0.25)
    assert moves.shape == (1, 2)
    assert moves[0] == pytest.approx([-0.25, 0.0])


def test_overlap_across_the_edge_of_a_period() -> None:
    points, radius = np.array([[0.5, 5.0], [9.7, 5.0]]), np.array([1.0, 1.0])
    assert near.deepest_overlap(points, radius, 2) == 0.0
    assert near.deepest_overlap(points, radius, 2, (0.0, 0.0, 10.0, 10.0)) == pytest.approx(0.6)
