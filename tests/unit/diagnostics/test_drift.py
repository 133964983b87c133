# SPDX-License-Identifier: GPL-2.0-or-later
"""Drift statistics against motions whose statistics are known."""

import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from floeflow.core.errors import FloeError
from floeflow.diagnostics.drift import (
    drift_distance,
    mean_squared_displacement,
    relative_dispersion,
)

POLE = 3.0e6
DAY = 86400.0


def walk(frames=9, elements=50, step=2.0e3, seed=3):
    """Random walk from places up to 3000 km off the origin: time, x, y."""
    rng = np.random.default_rng(seed)
    first = rng.uniform(-POLE, POLE, (2, 1, elements))
    steps = rng.normal(0.0, step, (2, frames - 1, elements))
    steps = np.concatenate([np.zeros((2, 1, elements)), np.cumsum(steps, axis=1)], axis=1)
    x, y = first + steps
    return DAY * np.arange(frames), x, y


def test_distance_is_the_way_gone_and_not_the_way_from_the_start():
    x = np.array([[0.0, 1.0], [3.0, 1.0], [3.0, 1.0], [0.0, 1.0]])
    y = np.array([[0.0, 2.0], [4.0, 2.0], [0.0, 2.0], [0.0, 2.0]])
    np.testing.assert_array_equal(
        drift_distance(x, y), [[0.0, 0.0], [5.0, 0.0], [9.0, 0.0], [12.0, 0.0]]
    )


@given(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.integers(2, 8))
def test_uniform_drift_is_ballistic(u, v, frames):
    time = DAY * np.arange(frames)
    x = 1.0e6 + u * time[:, None] + np.zeros(4)
    y = -2.0e6 + v * time[:, None] + np.zeros(4)
    lag, msd = mean_squared_displacement(time, x, y)
    np.testing.assert_array_equal(lag, time)
    np.testing.assert_allclose(msd, (u**2 + v**2) * time**2, rtol=1e-5, atol=1e-6)
    distance = np.hypot(u, v) * time
    np.testing.assert_allclose(drift_distance(x, y)[:, 0], distance, rtol=1e-8, atol=1e-5)


def test_displacements_are_those_of_a_sum_over_all_pairs_of_boundaries():
    """Positions in single precision would be off by 0.1 m, the sum here by 1e-7 of 2 km."""
    time, x, y = walk(step=1.0)
    _, msd = mean_squared_displacement(time, x, y)
    for lag in range(1, len(time)):
        squares = (x[lag:] - x[:-lag]) ** 2 + (y[lag:] - y[:-lag]) ** 2
        assert msd[lag] == pytest.approx(squares.mean(), rel=1e-5)
    assert msd[0] == 0.0


def test_random_walk_is_diffusive():
    time, x, y = walk(frames=6, elements=4000)
    lag, msd = mean_squared_displacement(time, x, y)
    np.testing.assert_allclose(msd[1:], 2.0 * 2.0e3**2 * lag[1:] / DAY, rtol=0.05)


def test_rigid_pack_disperses_by_its_turn_alone():
    _, x, y = walk(frames=1, elements=30)
    pairs = np.array([[0, 1], [4, 9], [20, 3]])
    angle = np.array([0.0, 0.1, 0.5])[:, None]
    turned_x = np.cos(angle) * x - np.sin(angle) * y + 5.0e4
    turned_y = np.sin(angle) * x + np.cos(angle) * y
    shifted = relative_dispersion(np.tile(x, (3, 1)) + 1e4 * angle, np.tile(y, (3, 1)), pairs)
    np.testing.assert_allclose(shifted, 0.0, atol=1e-15)
    square = np.mean([(x[0, j] - x[0, i]) ** 2 + (y[0, j] - y[0, i]) ** 2 for i, j in pairs])
    # A chord of the turn: 2 sin(angle / 2) times the distance.
    expected = (2.0 * np.sin(angle[:, 0] / 2.0)) ** 2 * square
    found = relative_dispersion(turned_x, turned_y, pairs)
    np.testing.assert_allclose(found[1:], expected[1:], rtol=1e-9)


def test_pairs_that_part_disperse_by_how_far_they_part():
    x = np.array([[0.0, 1e4, 2e4], [0.0, 1e4, 2.3e4]])
    y = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 4e3]])
    pairs = np.array([[0, 1], [1, 2]])
    np.testing.assert_allclose(relative_dispersion(x, y, pairs), [0.0, 0.5 * 5e3**2])


def test_too_little_to_average_is_refused():
    time, x, y = walk(frames=3, elements=2)
    with pytest.raises(FloeError, match="1 boundaries and 2 elements are too few"):
        mean_squared_displacement(time[:1], x[:1], y[:1])
    with pytest.raises(FloeError, match="3 boundaries and 0 elements are too few"):
        mean_squared_displacement(time, x[:, :0], y[:, :0])
    with pytest.raises(FloeError, match="not of one length"):
        mean_squared_displacement(np.array([0.0, 1.0, 3.0]), x, y)
    with pytest.raises(FloeError, match="no pair"):
        relative_dispersion(x, y, np.zeros((0, 2), dtype=np.int64))


def test_the_slow_libraries_are_imported_only_where_they_are_used():
    """Rules that import these modules for their pure functions do not import the libraries."""
    code = (
        "import sys, floeflow.diagnostics.drift, floeflow.diagnostics.trajectory, "
        "floeflow.diagnostics.mesh_series; "
        "print([name for name in ('MDAnalysis', 'meshio') if name in sys.modules])"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"
