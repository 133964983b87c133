# SPDX-License-Identifier: GPL-2.0-or-later
"""Elements to grids: order of convergence, planes, degenerate nodes, totals, bounds, constants."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from floeflow.transfer import (
    EMPTY,
    MLS,
    ROOM,
    SHEPARD,
    Field,
    Grid,
    build_remapper,
    build_weights,
    conservative_transfer,
    open_room,
)
from support.transfer.gridpacks import convergence, convergence_figure, displaced, unit_grid

FINE = [8, 16, 32, 64, 128, 256, 512]


def test_second_order_short():
    errors = convergence([8, 16, 32, 64], 3, 0.8)
    for error in errors.values():
        assert error.halvings().min() >= 1.95
        assert error.slopes("mean_square").min() >= 1.95


@pytest.mark.slow
def test_second_order(show):
    """Ten seeds; four fifths of the sea under elements, so that no cell is full."""
    errors = convergence(FINE, 10, 0.8)
    for error in errors.values():
        assert error.halvings().min() >= 1.95
        assert error.slopes("mean_square").min() >= 1.95
        assert np.median(error.slopes("largest", 64)) >= 1.85
    show("remap_grid_convergence", convergence_figure, errors)


@pytest.mark.slow
def test_second_order_of_a_full_pack():
    """Where every cell is full, its weight is its area, and the elements' own total is noisy.

    Their places are random, so the sum of their values is the integral but for a random error of
    second order; the correction hands it on. Slopes are therefore fitted over all grids.
    """
    for error in convergence(FINE, 10, 1.0).values():
        assert error.slopes("mean_square").min() >= 1.95
        assert np.median(error.slopes("largest", 64)) >= 1.85


@pytest.mark.parametrize("cells", [8, 64])
@pytest.mark.parametrize("displacement", [0.0, 0.25, 1.0])
def test_linear_fields(cells, displacement):
    grid = unit_grid(cells)
    node_x, node_y = np.meshgrid(grid.x, grid.y)
    for seed in range(3):
        x, y = displaced(cells, seed, displacement)
        weight = np.random.default_rng(seed).uniform(0.1, 3.0, x.size)
        weights = build_weights(x, y, weight, grid)
        mls = weights.status == MLS
        assert mls.mean() > 0.9
        for a, b, c in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.3, -0.7, 0.2)):
            error = weights.apply(a + b * x + c * y) - (a + b * node_x + c * node_y)
            assert np.abs(error[mls]).max() <= 1e-12


GRID = Grid(np.arange(5.0), np.arange(4.0))
FIELDS = (
    Field("area", "extensive", ROOM),
    Field("volume", "extensive", "area"),
    Field("temperature", "intensive", "volume"),
)
place = st.floats(-1.5, 5.5) | st.sampled_from([-0.5, 0.0, 0.5, 1.0, 2.0, 3.0, 3.5, 4.0])


@st.composite
def degenerate(draw):
    """Elements on a line or nearly so, twins, on nodes and edges, outside, or none at all."""
    n = draw(st.integers(0, 6))
    x0, y0 = draw(place), draw(place)
    along = draw(st.floats(0, np.pi) | st.sampled_from([0.0, np.pi / 4, np.pi / 2]))
    steps = np.array([draw(st.floats(-1, 1) | st.just(0.0)) for _ in range(n)])
    off = draw(st.sampled_from([0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3]))
    side = off * np.array([draw(st.floats(-1, 1)) for _ in range(n)])
    x = x0 + steps * np.cos(along) - side * np.sin(along)
    y = y0 + steps * np.sin(along) + side * np.cos(along)
    if n and draw(st.booleans()):
        x, y = np.append(x, x[0]), np.append(y, y[0])
    return x, y


@settings(deadline=None, derandomize=True, max_examples=300)
@given(degenerate(), st.integers(0, 1000), st.sampled_from([1, 2]))
def test_degenerate_nodes(where, seed, reach):
    """Nothing that is not finite; the fallback follows the condition number; totals hold."""
    x, y = where
    rng = np.random.default_rng(seed)
    area = rng.uniform(0.01, 0.2, len(x))
    values = {
        "area": area,
        "volume": area * rng.uniform(0, 3, len(x)),
        "temperature": rng.uniform(-30, 0, len(x)),
    }
    parents = {name: values[name] for name in ("area", "volume")}
    remapper = build_remapper(x, y, parents, open_room(GRID, reach=reach))
    weights = remapper.weights["area"]
    assert np.isfinite(weights.matrix.data).all()
    filled = weights.status != EMPTY
    assert ((weights.status == MLS) == (filled & (weights.condition <= 1e3))).all()
    assert ((weights.status == SHEPARD) == (filled & ~(weights.condition <= 1e3))).all()
    out = weights.apply(values["temperature"])
    assert np.isfinite(out[filled]).all() and np.isnan(out[~filled]).all()
    rows = np.asarray(weights.matrix.sum(axis=1)).reshape(GRID.shape)
    np.testing.assert_allclose(rows[filled], 1.0, rtol=0, atol=1e-12)

    carried = conservative_transfer(FIELDS, values, remapper)
    grid, on = carried.values, remapper.bins.placed()
    amounts = {**values, "temperature": values["temperature"] * values["volume"]}
    sums = {**grid, "temperature": np.nan_to_num(grid["temperature"]) * grid["volume"]}
    for name, sum_ in sums.items():
        assert np.isfinite(sum_).all()
        if name not in carried.infeasible:
            size = np.abs(amounts[name][on]).sum()
            assert abs(sum_.sum() - amounts[name][on].sum()) <= 1e-13 * size
    has = np.isfinite(grid["temperature"])
    low, high = remapper.weights["volume"].bounds(values["temperature"])
    assert (grid["temperature"][has] >= low[has]).all()
    assert (grid["temperature"][has] <= high[has]).all()
    values["temperature"] = np.full(len(x), -1.8)
    again = conservative_transfer(FIELDS, values, remapper).values["temperature"]
    np.testing.assert_allclose(again[np.isfinite(again)], -1.8, rtol=1e-14)
