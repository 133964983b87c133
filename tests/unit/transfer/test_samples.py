# SPDX-License-Identifier: GPL-2.0-or-later
"""From a grid to elements and back: planes, means over cells, masks, stress, exact totals."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from floeflow.core.errors import FloeError
from floeflow.transfer import (
    Grid,
    build_sampler,
    curvilinear,
    disc_points,
    mean_wind,
    polygon_points,
    vector_at,
    vector_back,
)

GRID = Grid(1e5 * np.arange(7.0), 1e5 * np.arange(5.0))
NX, NY = np.meshgrid(GRID.x, GRID.y)
MESH = curvilinear(1e5 * np.array([0.0, 1.0, 2.5, 3.0, 4.5, 6.0]), 1e5 * np.arange(5.0))


def places(n, seed=0):
    rng = np.random.default_rng(seed)
    return rng.uniform(0, 6e5, n), rng.uniform(0, 4e5, n)


@pytest.mark.parametrize("target", [GRID, MESH])
def test_planes_at_centres_and_as_means(target):
    x, y = places(100)
    x, y = np.clip(x, 1.1e5, 4.9e5), np.clip(y, 1.1e5, 2.9e5)
    node_x, node_y = (axis.reshape(target.shape) for axis in target.places())
    plane = 3.0 + 2e-5 * node_x - 1e-5 * node_y
    discs = disc_points(x, y, np.full(100, 1e5), 1e5)
    for points in (None, discs):
        found = build_sampler(x, y, target, points=points).at(np.stack([plane, 2 * plane]))
        exact = 3.0 + 2e-5 * x - 1e-5 * y
        np.testing.assert_allclose(found, [exact, 2 * exact], rtol=1e-13)


def test_means_over_polygons_are_those_of_a_fine_sum():
    """A square of two grid spacings and a triangle, against sums over a fine lattice."""
    x = np.array([1.3e5, 3.3e5, 3.3e5, 1.3e5, 4e5, 5.5e5, 4.2e5])
    y = np.array([0.6e5, 0.6e5, 2.6e5, 2.6e5, 1e5, 1.5e5, 3.4e5])
    points = polygon_points(np.array([0, 4, 7]), x, y, 2.5e4)
    np.testing.assert_allclose(points.mean.sum(axis=1), 1.0, rtol=1e-14)
    centre = np.array([2.3e5, 4.6e5]), np.array([1.6e5, 2e5])
    field = np.sin(NX / 1e5) * np.cos(NY / 2e5)
    found = build_sampler(*centre, GRID, points=points).at(field)
    m = 400
    s = (np.arange(m) + 0.5) / m
    fine_x, fine_y = np.meshgrid(1.3e5 + 2e5 * s, 0.6e5 + 2e5 * s)
    square = build_sampler(fine_x.ravel(), fine_y.ravel(), GRID).at(field).mean()
    a, b = (grid.ravel() for grid in np.meshgrid(s, s))
    a, b = np.where(a + b > 1, 1 - a, a), np.where(a + b > 1, 1 - b, b)
    tri_x, tri_y = 4e5 + 1.5e5 * a + 0.2e5 * b, 1e5 + 0.5e5 * a + 2.4e5 * b
    triangle = build_sampler(tri_x, tri_y, GRID).at(field).mean()
    np.testing.assert_allclose(found, [square, triangle], atol=2e-3)


def test_masked_nodes_count_for_nothing():
    x, y = places(200, 1)
    valid = NX >= 2e5
    field = np.where(valid, 7.0, 9.96921e36)
    sampler = build_sampler(x, y, GRID, valid=valid)
    found = sampler.at(field, "ocean_u")
    reached = x > 1e5
    np.testing.assert_allclose(found[reached], 7.0, rtol=1e-14)
    assert np.isnan(found[~reached]).all() and (~reached).any()
    field[~valid] = np.nan
    np.testing.assert_array_equal(sampler.at(field), found)
    filled = build_sampler(x, y, GRID, valid=valid, fill=1.5e5)
    np.testing.assert_allclose(filled.at(field)[x > 0.5e5], 7.0, rtol=1e-14)
    back = sampler.give_back(np.ones(200))
    assert (back[~valid] == 0).all()
    assert back.sum() == pytest.approx(reached.sum(), rel=1e-14)


element = st.tuples(st.floats(-0.9, 6.9), st.floats(-0.9, 4.9), st.floats(-1e12, 1e12))


@settings(deadline=None, derandomize=True, max_examples=150)
@given(st.lists(element, max_size=10), st.booleans())
def test_what_is_given_back_is_what_the_elements_have(rows, means):
    x, y, force = np.array(rows).reshape(-1, 3).T
    x, y = 1e5 * x, 1e5 * y
    points = disc_points(x, y, np.full(len(x), 7e4), 1e5) if means else None
    sampler = build_sampler(x, y, GRID, points=points)
    back = sampler.give_back(force)
    size = np.abs(force).sum()
    assert abs(back.sum() - force.sum()) <= 1e-13 * size
    # The work of a stress is the same on both sides.
    drift = np.sin(NX / 1e5) + 0.1 * NY / 1e5
    assert (back * drift).sum() == pytest.approx(
        (force * sampler.at(drift)).sum(), abs=1e-12 * size
    )
    constant = sampler.at(np.full(GRID.shape, 271.0))
    np.testing.assert_allclose(constant, 271.0, rtol=1e-14)


def test_slices_give_back_the_same():
    x, y = places(300, 2)
    force = np.cos(x)
    whole = build_sampler(x, y, GRID).give_back(force)
    parts = [slice(0, 100), slice(100, 300)]
    added = sum(build_sampler(x[p], y[p], GRID).give_back(force[p]) for p in parts)
    np.testing.assert_allclose(added, whole, rtol=1e-12, atol=1e-13)


def test_wind_keeps_the_stress_of_the_grid():
    """Wind that turns round within a cell still has a stress where its mean has none."""
    x, y = places(50, 3)
    u, v = 8.0 * np.cos(NX / 1e5), 5.0 * np.sin(NY / 1e5)
    points = disc_points(x, y, np.full(50, 8e4), 1e5)
    sampler = build_sampler(x, y, GRID, points=points)
    wu, wv = mean_wind(sampler, u, v)
    area = np.full(50, np.pi * 8e4**2)
    speed = np.hypot(u, v)
    for own, nodes in ((np.hypot(wu, wv) * wu, speed * u), (np.hypot(wu, wv) * wv, speed * v)):
        shares = sampler.give_back(area)
        assert (area * own).sum() == pytest.approx((shares * nodes).sum(), rel=1e-12)
    calm = mean_wind(sampler, 0 * u, 0 * v)
    assert (np.array(calm) == 0).all()


def test_vectors_are_turned_at_the_nodes_and_back():
    """A uniform flow, given along axes that turn from node to node, comes out uniform."""
    x, y = places(60, 4)
    sampler = build_sampler(x, y, GRID)
    turn = np.arctan2(NY - 2e5, NX - 3.1e5)
    u, v = 3.0 * np.cos(turn) + 1.0 * np.sin(turn), -3.0 * np.sin(turn) + 1.0 * np.cos(turn)
    found = vector_at(sampler, u, v, turn)
    np.testing.assert_allclose(found, [np.full(60, 3.0), np.full(60, 1.0)], rtol=1e-13)
    force = np.cos(x), np.sin(y)
    bu, bv = vector_back(sampler, *force, turn)
    along = bu * np.cos(turn) - bv * np.sin(turn), bu * np.sin(turn) + bv * np.cos(turn)
    for total, own in zip(along, force, strict=True):
        assert total.sum() == pytest.approx(own.sum(), rel=1e-12)
    assert (bu * u + bv * v).sum() == pytest.approx(
        force[0].sum() * 3.0 + force[1].sum() * 1.0, rel=1e-12
    )
    plain = vector_back(sampler, *force)
    np.testing.assert_array_equal(plain[0], sampler.give_back(force[0]))


def test_wrong_input_is_named():
    x, y = places(4)
    sampler = build_sampler(x, y, GRID)
    bad = np.ones(GRID.shape)
    bad[np.unravel_index(sampler.matrix.indices[0], GRID.shape)] = np.nan
    with pytest.raises(FloeError, match=r"wind_u: it is not finite at x = \d+ m, y = \d+ m"):
        sampler.at(bad, "wind_u")
    with pytest.raises(FloeError, match=r"wind_u: it has shape \(5, 6\), the grid \(5, 7\)"):
        sampler.at(bad[:, 1:], "wind_u")
    with pytest.raises(FloeError, match=r"heat: it has shape \(3,\), but there are 4 elements"):
        sampler.give_back(np.ones(3), "heat")
    with pytest.raises(FloeError, match="heat: it is inf at element 2"):
        sampler.give_back(np.array([1.0, 1.0, np.inf, 1.0]), "heat")
    with pytest.raises(FloeError, match="element 1 at x = 900000 m, y = 0 m lies outside"):
        build_sampler(np.array([0.0, 9e5]), np.zeros(2), GRID)
    with pytest.raises(FloeError, match="the mask has shape"):
        build_sampler(x, y, GRID, valid=np.ones(3, bool))
    with pytest.raises(FloeError, match="above 0 m"):
        disc_points(x, y, np.zeros(4), 1.0)
    with pytest.raises(FloeError, match="cell of element 1 is not a polygon"):
        polygon_points(np.array([0, 3, 5]), np.arange(5.0), np.arange(5.0), 1.0)
