# SPDX-License-Identifier: GPL-2.0-or-later
"""Nearest lines, beside the distance to each of them."""

import numpy as np
import pytest
import shapely

from floeflow.core.near_lines import near_lines


@pytest.mark.parametrize("reach", [0.02, 0.3, 5.0])
def test_nearest_of_many_lines(reach: float) -> None:
    rng = np.random.default_rng(4)
    start = rng.uniform(-1, 1, (60, 2))
    ends = np.stack([start, start + rng.normal(0, 0.3, (60, 2))], axis=1)
    ends[7, 1] = ends[7, 0]
    points = rng.uniform(-1.5, 1.5, (400, 2))
    away, foot = near_lines(ends, reach).nearest(points)
    all_lines = shapely.multilinestrings(list(shapely.linestrings(ends)))
    far = shapely.distance(all_lines, shapely.points(points))
    near = far <= reach
    assert near.any()
    assert np.isinf(away[~near]).all()
    np.testing.assert_allclose(away[near], far[near], rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(np.hypot(*(points - foot)[near].T), far[near], rtol=1e-12)


def test_no_lines_are_out_of_reach() -> None:
    away, foot = near_lines(np.empty((0, 2, 2)), 1.0).nearest(np.zeros((3, 2)))
    assert np.isinf(away).all()
    assert np.isnan(foot).all()
