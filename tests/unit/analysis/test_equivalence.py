# SPDX-License-Identifier: GPL-2.0-or-later
"""Intervals of differences hold as often as they say, and verdicts need the whole interval."""

from __future__ import annotations

import math

import numpy as np
import pytest

from floeflow.analysis.studies.equivalence import (
    BEYOND,
    UNKNOWN,
    WITHIN,
    Interval,
    difference,
    pool,
    together,
    verdict,
)


def test_an_interval_is_students_where_the_samples_are_alike():
    """Two samples of three: the textbook's pooled t interval."""
    one, two = np.array([1.0, 2.0, 3.0]), np.array([2.0, 4.0, 6.0])
    spread = pool([one, two])
    assert spread.freedom == 4 and spread.variance == pytest.approx(2.5)
    found = difference(one, two, spread, 0.95)
    half = 2.776445 * math.sqrt(2.5 * (1 / 3 + 1 / 3))
    assert found.mean == pytest.approx(-2.0)
    assert (found.low, found.high) == pytest.approx((-2.0 - half, -2.0 + half), rel=1e-6)


@pytest.mark.parametrize("wide", [1.0, 6.0])
def test_intervals_hold_the_truth_as_often_as_they_say(wide: float):
    """Also where one setting spreads more than the others, which pooling alone would not see."""
    random, held, rounds = np.random.default_rng(7), 0, 2000
    for _ in range(rounds):
        base = random.normal(0.0, 1.0, 8)
        others = [random.normal(0.0, 1.0, 3) for _ in range(12)]
        own = random.normal(5.0, wide, 8)
        found = difference(own, base, pool([base, *others, own]), 0.95)
        held += found.low <= 5.0 <= found.high
    assert 0.93 <= held / rounds <= 0.985


def test_no_spread_known_means_nothing_known():
    alone = np.array([1.0])
    found = difference(alone, alone, pool([alone]), 0.95)
    assert found.bound == math.inf
    assert verdict(found, 0.2) == UNKNOWN


def test_verdicts_ask_for_the_whole_interval():
    assert verdict(Interval(0.0, -0.04, 0.04), 0.05) == WITHIN
    # A mean of nothing with a wide interval shows nothing.
    assert verdict(Interval(0.0, -0.3, 0.3), 0.05) == UNKNOWN
    assert verdict(Interval(0.1, 0.06, 0.14), 0.05) == BEYOND
    assert verdict(Interval(-0.1, -0.14, -0.06), 0.05) == BEYOND
    assert together([WITHIN, UNKNOWN]) == UNKNOWN
    assert together([WITHIN, UNKNOWN, BEYOND]) == BEYOND
    assert together([WITHIN, WITHIN]) == WITHIN
