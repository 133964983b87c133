# SPDX-License-Identifier: GPL-2.0-or-later
"""The nearest values with a given total: exact, bounded, nearest; infeasible totals are said."""

import threading

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from floeflow.core.errors import FloeError
from floeflow.transfer.bounded import Ranks, nearest_bounded


def problem(seed, n, groups=1):
    """Targets within and outside of their bounds, weights over four orders, a feasible total."""
    rng = np.random.default_rng(seed)
    target = rng.normal(size=n)
    low = target + rng.normal(-0.3, 0.5, n)
    high = low + rng.uniform(0, 2, n)
    weight = 10.0 ** rng.uniform(-2, 2, n)
    group = rng.integers(0, groups, n)
    share = rng.uniform(0, 1, groups)[group]
    total = np.bincount(group, weight * (low + share * (high - low)), groups)
    return target, low, high, weight, total, group


@pytest.mark.parametrize(("n", "groups"), [(1, 1), (7, 2), (1000, 1), (3000, 5), (5000, 400)])
def test_total_is_exact_and_bounds_hold(n, groups):
    target, low, high, weight, total, group = problem(n, n, groups)
    found = nearest_bounded(target, low, high, weight, total, group=group)
    assert (found.values >= low).all() and (found.values <= high).all()
    scale = np.bincount(group, weight * np.maximum(np.abs(low), np.abs(high)), groups)
    reached = np.bincount(group, weight * found.values, groups)
    assert (np.abs(reached - total) <= 1e-14 * np.maximum(scale, 1e-300)).all()
    assert found.feasible.all()


@pytest.mark.parametrize("own_penalty", [False, True])
def test_values_are_the_nearest(own_penalty):
    """A general solver finds nothing nearer."""
    target, low, high, weight, total, _ = problem(3, 12)
    penalty = np.random.default_rng(1).uniform(0.2, 5, 12) if own_penalty else None
    found = nearest_bounded(target, low, high, weight, total, penalty=penalty)
    q = weight if penalty is None else penalty
    other = minimize(
        lambda x: q @ (x - target) ** 2,
        0.5 * (low + high),
        jac=lambda x: 2 * q * (x - target),
        bounds=list(zip(low, high, strict=True)),
        constraints={"type": "eq", "fun": lambda x: weight @ x - total[0], "jac": lambda x: weight},
        method="SLSQP",
        options={"ftol": 1e-14, "maxiter": 1000},
    )
    assert q @ (found.values - target) ** 2 <= other.fun * (1 + 1e-9)
    np.testing.assert_allclose(found.values, other.x, atol=1e-4)
    free = (found.values > low) & (found.values < high)
    moved = (found.values - target) * q / weight
    np.testing.assert_allclose(moved[free], found.shift[0], rtol=1e-10)


def test_what_is_right_already_stays():
    target, low, high, weight, _, _ = problem(4, 50)
    target = np.clip(target, low, high)
    found = nearest_bounded(target, low, high, weight, weight @ target)
    np.testing.assert_array_equal(found.values, target)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_infeasible_totals_say_by_how_much(sign):
    target, low, high, weight, total, group = problem(5, 60, 3)
    bound = high if sign > 0 else low
    total[1] = (weight * bound)[group == 1].sum() + sign * 2.5
    found = nearest_bounded(target, low, high, weight, total, group=group)
    np.testing.assert_array_equal(found.values[group == 1], bound[group == 1])
    assert found.missing[1] == pytest.approx(sign * 2.5, rel=1e-9)
    assert found.feasible.tolist() == [True, False, True]
    assert np.isinf(found.shift[1]) and np.sign(found.shift[1]) == sign


def test_values_without_weight_are_only_cut():
    found = nearest_bounded(
        np.array([3.0, 0.5]), np.zeros(2), np.ones(2), np.array([0.0, 2.0]), 1.5
    )
    np.testing.assert_allclose(found.values, [1.0, 0.75], rtol=1e-15)


def test_a_target_far_outside_leaves_no_round_off():
    low, high, total = np.zeros(2), np.full(2, 2e-9), 1e-9
    found = nearest_bounded(np.array([4097.0, 4097.0]), low, high, np.ones(2), total)
    assert abs(found.values.sum() - total) < 1e-22
    assert found.feasible.all()


rows = st.lists(
    st.tuples(
        st.floats(-1e6, 1e6),
        st.floats(-1e6, 1e6),
        st.floats(0, 1e6) | st.just(0.0),
        st.floats(1e-9, 1e9) | st.just(0.0),
        st.integers(0, 2),
    ),
    max_size=20,
)


@settings(deadline=None, derandomize=True, max_examples=400)
@given(rows, st.lists(st.floats(0, 1), min_size=3, max_size=3), st.booleans())
def test_any_problem(rows, shares, own_penalty):
    target, low, width, weight, group = np.array(rows).reshape(-1, 5).T
    high, group = low + width, group.astype(np.int64)
    share = np.array(shares)[group]
    scale = np.bincount(group, weight * np.maximum(np.abs(low), np.abs(high)), 3)
    total = np.bincount(group, weight * (low + share * (high - low)), 3)
    penalty = 1.0 + weight**0.5 if own_penalty else None
    found = nearest_bounded(target, low, high, weight, total, group=group, penalty=penalty)
    assert (found.values >= low).all() and (found.values <= high).all()
    assert (np.abs(np.bincount(group, weight * found.values, 3) - total) <= 1e-13 * scale).all()
    assert found.feasible.all()


def test_slices_on_ranks_give_the_same():
    target, low, high, weight, total, group = problem(6, 3000, 2)
    whole = nearest_bounded(target, low, high, weight, total, group=group)
    parts = np.array_split(np.arange(3000), 3)
    board, barrier, found = [None] * 3, threading.Barrier(3), [None] * 3

    def reduce(rank, combine):
        def call(part):
            board[rank] = part
            barrier.wait()
            result = combine(np.stack(board))
            barrier.wait()
            return result

        return call

    def work(rank):
        rows = parts[rank]
        ranks = Ranks(reduce(rank, lambda a: a.sum(axis=0)), reduce(rank, lambda a: a.max(axis=0)))
        found[rank] = nearest_bounded(
            *(a[rows] for a in (target, low, high, weight)), total, group=group[rows], ranks=ranks
        )

    threads = [threading.Thread(target=work, args=(rank,)) for rank in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(timeout=60)
    values = np.concatenate([part.values for part in found])
    np.testing.assert_allclose(values, whole.values, rtol=1e-12, atol=1e-12)


def test_few_passes_over_many_values():
    """The cost does not hide in the number of passes: every pass has two sums."""
    target, low, high, weight, total, _ = problem(7, 200_000)
    calls = []

    def add(part):
        calls.append(1)
        return part

    nearest_bounded(target, low, high, weight, total, ranks=Ranks(add=add))
    assert len(calls) < 80


def test_wrong_input_is_named():
    one, two = np.ones(1), np.ones(2)
    for given_, match in (
        ((two, one, two, two, 1.0), "'low' has shape"),
        ((two, two, np.array([1.0, np.nan]), two, 1.0), "'high' is nan at value 1"),
        ((two, np.array([1.0, 2.0]), two, two, 1.0), "value 1: its low bound is above"),
        ((two, two, two, np.array([1.0, -1.0]), 1.0), "value 1: its weight is negative"),
        ((two, two, two, two, np.nan), "a total is nan"),
        ((two, two, two, two, two), "2 totals, but no groups"),
    ):
        with pytest.raises(FloeError, match=match):
            nearest_bounded(*given_)
    with pytest.raises(FloeError, match="needs a group from 0 to 0"):
        nearest_bounded(two, two, two, two, 1.0, group=np.array([0, 1]))
    with pytest.raises(FloeError, match="value 1: its penalty is not above 0"):
        nearest_bounded(two, two, two, two, 1.0, penalty=np.array([1.0, 0.0]))
