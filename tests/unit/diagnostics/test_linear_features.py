# SPDX-License-Identifier: GPL-2.0-or-later
"""Linear features of deformation whose place, size and direction are known."""

from __future__ import annotations

import numpy as np
import pytest

from floeflow.diagnostics.deformation import triangle_strain, triangles
from floeflow.diagnostics.linear_features import Features, linear_features

SPACING = 1.0e4


def moved(u, v, side: int = 40) -> Features:
    """Features of a square of elements whose velocities are functions of the places."""
    rng = np.random.default_rng(0)
    x, y = (each.ravel() * SPACING for each in np.meshgrid(np.arange(side), np.arange(side)))
    x, y = (each + rng.uniform(-0.2, 0.2, x.size) * SPACING for each in (x, y))
    corners = triangles(x, y, SPACING)
    return linear_features(triangle_strain(x, y, u(x, y), v(x, y), corners), corners, (x, y))


@pytest.mark.parametrize("angle", [0.0, 30.0, 90.0, 135.0])
def test_a_slip_line_is_one_feature_of_its_direction(angle: float) -> None:
    """Two rigid halves slide past each other along a line through the middle."""
    along = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])

    def side(x, y):
        middle = 19.5 * SPACING
        return np.sign(-(x - middle) * along[1] + (y - middle) * along[0])

    found = moved(
        lambda x, y: 0.05 * along[0] * side(x, y), lambda x, y: 0.05 * along[1] * side(x, y)
    )
    # All deformation lies in the elements beside the line: two spacings of forty.
    assert found.share < 0.06
    assert len(found.length) == 1
    off = np.degrees(found.angle[0]) - angle
    assert abs((off + 90.0) % 180.0 - 90.0) < 3.0
    full = 39.0 * SPACING / max(abs(along))
    assert 0.8 * full < found.length[0] < 1.1 * full
    assert found.width[0] < 3.0 * SPACING


def test_even_deformation_has_no_features() -> None:
    """Where all deforms alike, half of it lies in half of the ice, and nothing is fast."""
    found = moved(lambda x, y: 1e-7 * y, lambda x, y: 0.0 * x)
    assert found.share == pytest.approx(0.5, abs=0.02)
    assert not found.length.size


def test_ice_at_rest_has_none() -> None:
    found = moved(lambda x, y: 0.0 * x, lambda x, y: 0.0 * x)
    assert np.isnan(found.share) and not found.length.size and found.area > 0.0
