# SPDX-License-Identifier: GPL-2.0-or-later
"""Fragments of bonded elements, and fits to sizes that were drawn from known laws."""

from __future__ import annotations

import numpy as np
import pytest

from floeflow.diagnostics.floe_sizes import FLOES, fit_sizes, fragments


def test_fragments_are_what_bonds_hold_together():
    ids = np.array([3, 5, 8, 9, 12])
    pairs = np.array([[3, 8], [8, 12], [9, 77]])
    label = fragments(ids, pairs)
    assert label[0] == label[2] == label[4]
    assert len(set(label.tolist())) == 3


def test_a_power_law_is_found_and_held_for_one():
    rng = np.random.default_rng(8)
    sizes = 200.0 * rng.random(800) ** (-1.0 / 1.5)
    fit = fit_sizes(sizes)
    assert fit is not None
    assert fit.exponent == pytest.approx(2.5, abs=3.0 * fit.error)
    assert fit.goodness > 0.1


def test_a_lognormal_is_not_taken_for_a_power_law():
    sizes = np.random.default_rng(6).lognormal(6.0, 0.4, 800)
    fit = fit_sizes(sizes, smallest=float(sizes.min()))
    assert fit is not None
    assert fit.goodness < 0.1 and fit.ratio < -2.0
    assert (fit.mean, fit.spread) == (pytest.approx(6.0, abs=0.05), pytest.approx(0.4, abs=0.05))


def test_few_floes_or_equal_ones_have_no_distribution():
    assert fit_sizes(np.linspace(1.0, 2.0, FLOES - 1)) is None
    assert fit_sizes(np.full(50, 3.0)) is None
