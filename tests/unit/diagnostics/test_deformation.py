# SPDX-License-Identifier: GPL-2.0-or-later
"""Deformation of fields whose gradients and exponents are known."""

from __future__ import annotations

import numpy as np
import pytest

from floeflow.diagnostics.deformation import (
    ORDERS,
    Strain,
    box_sizes,
    box_strain,
    curvature,
    fit_scaling,
    moment_sums,
    triangle_strain,
    triangles,
)

SPACING = 10e3


def lattice(side: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(3)
    x, y = np.meshgrid(np.arange(side) * SPACING, np.arange(side) * SPACING)
    return tuple(each.ravel() + rng.uniform(-2e3, 2e3, side**2) for each in (x, y))


def scaled(pieces: list[Strain], intervals: int = 3) -> tuple[np.ndarray, ...]:
    sums = [moment_sums(piece) for piece in pieces]
    one = [np.array([item[k] for item in sums], dtype=float) for k in range(3)]
    return tuple(np.stack([each] * intervals) for each in one)


def test_a_linear_field_has_its_gradients_at_all_scales():
    x, y = lattice(40)
    u, v = 1e-6 * x - 3e-6 * y, 2e-6 * x + 4e-6 * y
    fine = triangle_strain(x, y, u, v, triangles(x, y, SPACING))
    np.testing.assert_allclose(fine.divergence, 5e-6, rtol=1e-9)
    np.testing.assert_allclose(fine.shear, np.hypot(3e-6, 1e-6), rtol=1e-9)
    sizes = box_sizes(SPACING, 40 * SPACING)
    boxes = [box_strain(fine, size) for size in sizes]
    for box in boxes:
        np.testing.assert_allclose(box.total, np.hypot(5e-6, np.hypot(3e-6, 1e-6)), rtol=1e-9)
    found = fit_scaling(*scaled([fine, *boxes]), SPACING)
    np.testing.assert_allclose(found.exponent, 0.0, atol=1e-9)
    assert found.low >= 2.5 * SPACING


def test_a_rigid_turn_does_not_deform():
    x, y = lattice(12)
    fine = triangle_strain(x, y, -1e-6 * y, 1e-6 * x, triangles(x, y, SPACING))
    assert fine.total.max() < 1e-18


def test_independent_signed_gradients_fall_off_with_the_scale():
    # A box of n pieces averages them away by the root of n: exponent 1 for q = 1 and q for q.
    rng = np.random.default_rng(4)
    n = 200
    x, y = (each.ravel() + 0.5e3 for each in np.meshgrid(np.arange(n) * 1e3, np.arange(n) * 1e3))
    fine = Strain(x, y, np.full(n * n, 1e6), rng.normal(size=(n * n, 4)))
    boxes = [box_strain(fine, size) for size in 1e3 * np.array([2, 4, 8, 16])]
    found = fit_scaling(*scaled([fine, *boxes]), 0.1e3)
    np.testing.assert_allclose(found.exponent, ORDERS, rtol=0.06)


def test_triangles_leave_out_what_spans_a_gap_and_slivers():
    x, y = lattice(10)
    far = np.append(x, x.max() + 10 * SPACING), np.append(y, 0.0)
    corners = triangles(*far, SPACING)
    assert (corners != 100).all()
    flat = triangles(np.array([0.0, 1.0, 2.0]), np.array([0.0, 0.0, 0.1]), 1.0)
    assert len(flat) == 0
    assert len(triangles(np.array([0.0, 1.0, 2.0]), np.zeros(3), 1.0)) == 0


def test_too_few_scales_give_no_exponent():
    counts, scales, moments = np.full((1, 2), 50.0), np.full((1, 2), 50e5), np.ones((1, 2, 6))
    found = fit_scaling(counts, scales, moments, 10e3)
    assert np.isnan(found.exponent).all() and np.isnan(found.low)


def test_boxes_that_are_half_empty_do_not_count():
    piece = Strain(np.array([500.0]), np.array([500.0]), np.array([0.4e6]), np.ones((1, 4)))
    assert box_strain(piece, 1e3).area.size == 0
    assert box_strain(piece, 0.8e3).area == pytest.approx([0.4e6])


def test_the_curvature_of_known_exponents_is_found():
    a, b = curvature(ORDERS, 0.13 * ORDERS**2 + 0.07 * ORDERS)
    assert (a, b) == (pytest.approx(0.13), pytest.approx(0.07))
    # One fractal: all moments fall with one dimension.
    assert curvature(ORDERS, 0.2 * ORDERS) == (pytest.approx(0.0, abs=1e-12), pytest.approx(0.2))
    assert np.isnan(curvature(ORDERS, np.full(ORDERS.size, np.nan))).all()
