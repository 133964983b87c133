# SPDX-License-Identifier: GPL-2.0-or-later
"""A rectangle that repeats itself, against nine or three copies laid out in full."""

from __future__ import annotations

import numpy as np
import pytest

from floeflow.core import period

BOTH = (-3.0, 2.0, 7.0, 6.0)
UP = (-np.inf, 2.0, np.inf, 6.0)


def copies(places: np.ndarray, bounds: period.Period) -> np.ndarray:
    """All copies around, the places themselves first, (9 or 3, n, 2)."""
    wide, high = period.sides(bounds)
    right = (0, -1, 1) if np.isfinite(wide) else (0,)
    moves = [(i * wide if i else 0.0, j * high) for i in right for j in (0, -1, 1)]
    return np.stack([places + np.array(move) for move in moves])


@pytest.fixture
def places() -> np.ndarray:
    return np.random.default_rng(1).uniform((-3.0, 2.0), (7.0, 6.0), (40, 2))


@pytest.mark.parametrize("bounds", [BOTH, UP])
def test_distances_are_those_to_the_nearest_copy(places: np.ndarray, bounds: period.Period) -> None:
    first, second = np.triu_indices(len(places), 1)
    every = np.hypot(*(copies(places, bounds)[:, second] - places[first]).transpose(2, 0, 1))
    found = period.apart(places, first, second, bounds)
    np.testing.assert_allclose(found, every.min(axis=0), rtol=1e-12)
    elements = {"x": places[:, 0], "y": places[:, 1]}
    again = period.distances_of(elements, first, second, bounds)
    np.testing.assert_array_equal(found, again)
    tree = period.tree_of(places, bounds)
    pairs = {tuple(pair) for pair in np.sort(tree.query_pairs(1.0, output_type="ndarray"))}
    assert pairs == set(zip(first[found <= 1.0], second[found <= 1.0], strict=True))
    assert len(pairs) > np.count_nonzero(every[0] <= 1.0) > 0


@pytest.mark.parametrize("bounds", [BOTH, UP])
def test_copies_within_reach(places: np.ndarray, bounds: period.Period) -> None:
    made, of = period.images(places, 0.8, bounds)
    low, high = np.array(bounds[:2]) - 0.8, np.array(bounds[2:]) + 0.8
    all_around = copies(places, bounds)[1:].reshape(-1, 2)
    wanted = all_around[((all_around > low) & (all_around < high)).all(axis=1)]
    assert len(made) == len(wanted) > 0
    np.testing.assert_allclose(np.sort(made, axis=0), np.sort(wanted, axis=0))
    np.testing.assert_allclose(period.wrapped(made, bounds), places[of], atol=1e-12)


def test_places_come_back_into_the_rectangle() -> None:
    off = np.array([[-3.0 - 1e-17, 6.0], [7.0 - 1e-16, 1.0], [17.5, 2.0 - 1e-17]])
    back = period.wrapped(off, BOTH)
    assert ((back >= BOTH[:2]) & (back < BOTH[2:])).all()
    np.testing.assert_allclose(back[2], [-2.5, 2.0])
    np.testing.assert_array_equal(period.wrapped(off, UP)[:, 0], off[:, 0])


def test_what_does_not_repeat_stays_as_it_is(places: np.ndarray) -> None:
    made, of = period.images(places, 1.0, None)
    assert len(made) == len(of) == 0
    assert period.wrapped(places, None) is places
    assert period.period_of({}) is None and period.period_of({"period": list(UP)}) == UP
