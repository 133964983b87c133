# SPDX-License-Identifier: GPL-2.0-or-later
"""Invariants of the averaging weights: constants, planes, order, fallbacks, files."""

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

from floeflow.core.errors import FloeError
from floeflow.state import write_dataset
from floeflow.transfer import (
    EMPTY,
    FILLED,
    MLS,
    SHEPARD,
    Grid,
    Ranks,
    build_weights,
    load_weights,
    save_weights,
)
from floeflow.transfer.weights import node_moments


def unit_grid(cells):
    centres = (np.arange(cells) + 0.5) / cells
    return Grid(centres, centres)


def displaced_lattice(n, displacement, seed):
    """A lattice of elements in the unit square, each moved by a share of their spacing."""
    rng = np.random.default_rng(seed)
    centres = (np.arange(n) + 0.5) / n
    x, y = np.meshgrid(centres, centres)
    move = rng.uniform(-displacement, displacement, (2, n, n)) / n
    return (x + move[0]).ravel(), (y + move[1]).ravel()


def scene(seed=1, n=400):
    """A grid of 100 km cells with elements and weights at random."""
    rng = np.random.default_rng(seed)
    grid = Grid(-4e5 + 1e5 * np.arange(9), 2e5 + 8e4 * np.arange(8))
    x, y = rng.uniform(-4.5e5, 4.5e5, n), rng.uniform(1.6e5, 8e5, n)
    return grid, x, y, rng.uniform(0.1, 3.0, n) * 1e9


@pytest.mark.parametrize("reach", [1, 2])
def test_rows_add_to_one_and_constants_stay(reach):
    grid, x, y, area = scene()
    weights = build_weights(x, y, area, grid, reach=reach)
    assert (weights.status == MLS).sum() > 50
    rows = np.asarray(weights.matrix.sum(axis=1)).reshape(grid.shape)
    np.testing.assert_allclose(rows[weights.status != EMPTY], 1.0, rtol=0, atol=1e-13)
    field = weights.apply(np.full(len(x), 273.15))
    np.testing.assert_allclose(field, 273.15, rtol=1e-13)


@pytest.mark.parametrize("reach", [1, 2])
def test_planes_are_exact_where_mls(reach):
    grid, x, y, area = scene(seed=2, n=150)
    weights = build_weights(x, y, area, grid, reach=reach)
    mls = weights.status == MLS
    assert mls.sum() > 40
    nx, ny = np.meshgrid(grid.x, grid.y)
    for a, b, c in ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (7.0, -2.0, 5.0)):
        plane = a + b * x / 1e5 + c * y / 1e5
        exact = a + b * nx / 1e5 + c * ny / 1e5
        error = np.abs(weights.apply(plane) - exact)[mls]
        assert error.max() <= 1e-12 * np.abs(plane).max()


def test_second_order():
    errors = []
    for cells in (8, 16, 32, 64):
        grid = unit_grid(cells)
        nx, ny = np.meshgrid(grid.x, grid.y)
        squares = []
        for seed in range(3):
            x, y = displaced_lattice(2 * cells, 0.25, seed)
            weights = build_weights(x, y, np.ones_like(x), grid)
            field = weights.apply(np.sin(np.pi * x) * np.sin(np.pi * y))
            error = field - np.sin(np.pi * nx) * np.sin(np.pi * ny)
            squares.append((error[1:-1, 1:-1] ** 2).mean())
        errors.append(np.sqrt(np.mean(squares)))
    slope = -np.polyfit(np.log2([8, 16, 32, 64]), np.log2(errors), 1)[0]
    assert slope >= 1.9


GRID = Grid(np.arange(5.0), np.arange(4.0))


@pytest.mark.parametrize(
    ("places", "status"),
    [
        ([], EMPTY),
        ([(2.3, 1.2)], SHEPARD),
        ([(2.0, 1.0)], SHEPARD),
        ([(2.3, 1.2), (1.9, 1.4)], SHEPARD),
        ([(2.3, 1.2), (2.0, 1.0), (1.7, 0.8)], SHEPARD),
        ([(2.3, 1.2), (2.0, 1.0), (1.7, 0.8 + 1e-9)], SHEPARD),
        ([(2.3, 1.2), (2.3, 1.2), (2.3, 1.2), (1.7, 0.8)], SHEPARD),
        ([(2.3, 1.2), (1.8, 1.4), (1.9, 0.7)], MLS),
    ],
)
def test_fallbacks(places, status):
    """The node (2, 1) with none, one, two, collinear, nearly collinear, twin and three elements."""
    x, y = np.array(places).reshape(-1, 2).T
    weights = build_weights(x, y, np.ones(len(x)), GRID)
    assert weights.status[1, 2] == status
    field = weights.apply(np.arange(len(x)) + 1.0)
    assert np.isfinite(field).all(where=weights.status != EMPTY)
    assert np.isnan(field).all(where=weights.status == EMPTY)
    if status == SHEPARD:
        hat = (1 - np.abs(x - 2)) * (1 - np.abs(y - 1))
        mean = (hat * (np.arange(len(x)) + 1)).sum() / hat.sum()
        assert field[1, 2] == pytest.approx(mean, rel=1e-13)


coordinates = st.floats(-2, 6) | st.sampled_from([0.0, 1.0, 1.5, 2.0, 3.0])
elements = st.tuples(coordinates, coordinates, st.floats(0, 10), st.floats(-5, 5))


@settings(deadline=None, derandomize=True, max_examples=300)
@given(st.lists(elements, max_size=12), st.integers(1, 3))
def test_any_elements(rows, reach):
    x, y, area, field = np.array(rows).reshape(-1, 4).T
    weights = build_weights(x, y, area, GRID, reach=reach)
    filled = weights.status != EMPTY
    assert np.isfinite(weights.matrix.data).all()
    out, constant = weights.apply(field, bounded=True), weights.apply(np.ones_like(field))
    assert (np.isnan(out) == ~filled).all()
    np.testing.assert_allclose(constant[filled], 1.0, atol=1e-12)
    if filled.any():
        assert field.min() <= np.nanmin(out) and np.nanmax(out) <= field.max()


def test_bounds_are_those_of_the_elements_in_reach():
    x, y = np.array([2.5, 2.9, 2.5, 2.9]), np.array([1.5, 1.5, 1.9, 1.9])
    weights = build_weights(x, y, np.ones(4), GRID)
    field = x + y
    assert weights.status[1, 2] == MLS
    assert weights.apply(field)[1, 2] == pytest.approx(3.0, abs=1e-12)
    assert weights.apply(field, bounded=True)[1, 2] == 4.0


def test_average_is_weighted_by_the_parent():
    """Thickness 1 m on three parts of ice and 5 m on one: 2 m where all are equally near."""
    x, y = np.array([2.5, 1.5]), np.array([1.0, 1.0])
    weights = build_weights(x, y, np.array([3.0, 1.0]), GRID)
    assert weights.apply(np.array([1.0, 5.0]))[1, 2] == pytest.approx(2.0, rel=1e-14)
    assert np.isnan(weights.apply(np.array([1.0, 5.0]))[3, 0])


def test_elements_without_weight_may_hold_nan():
    x, y = np.array([2.2, 2.1]), np.array([1.0, 1.0])
    weights = build_weights(x, y, np.array([1.0, 0.0]), GRID)
    assert weights.apply(np.array([4.0, np.nan]))[1, 2] == 4.0
    with pytest.raises(FloeError, match="nan at element 0"):
        weights.apply(np.array([np.nan, 4.0]))


def test_moments_add_up_over_slices():
    grid, x, y, area = scene()
    whole = node_moments(grid.pairs(x, y), area)
    parts = [slice(0, 150), slice(150, 400)]
    added = sum(node_moments(grid.pairs(x[p], y[p]), area[p]) for p in parts)
    np.testing.assert_allclose(added, whole, rtol=1e-12, atol=1e-3)


def test_condition_limit_is_obeyed():
    grid, x, y, area = scene(n=120)
    strict = build_weights(x, y, area, grid, condition_limit=8.0)
    filled = strict.status != EMPTY
    assert ((strict.condition <= 8.0) == (strict.status == MLS))[filled].all()
    assert 0 < (strict.status == MLS).sum() < filled.sum()


def test_saved_weights_give_the_same_bits(tmp_path):
    grid, x, y, area = scene(n=60)
    weights = build_weights(x, y, area, Grid(grid.x, grid.y, "EPSG:3413"), reach=2)
    save_weights(weights, tmp_path / "weights.nc")
    again = load_weights(tmp_path / "weights.nc")
    field = np.sin(x / 1e5)
    assert again.apply(field).tobytes() == weights.apply(field).tobytes()
    np.testing.assert_array_equal(again.status, weights.status)
    np.testing.assert_array_equal(again.condition, weights.condition)
    np.testing.assert_array_equal(again.target.x, grid.x)
    assert (again.target.crs, again.reach) == ("EPSG:3413", 2)


def test_broken_files_are_named(tmp_path):
    with pytest.raises(FloeError, match="there is no such file"):
        load_weights(tmp_path / "none.nc")
    (tmp_path / "bad.nc").write_bytes(b"text")
    with pytest.raises(FloeError, match=r"bad.nc: has no checksum at its end"):
        load_weights(tmp_path / "bad.nc")
    write_dataset(xr.Dataset({"weight": ("pair", np.ones(3))}), tmp_path / "other.nc")
    with pytest.raises(FloeError, match=r"other.nc: holds no remap weights"):
        load_weights(tmp_path / "other.nc")


def test_empty_nodes_are_filled_from_the_nearest():
    x, y = np.array([0.2, 0.1, 3.9]), np.array([0.1, 0.3, 2.9])
    plain = build_weights(x, y, np.ones(3), GRID)
    weights = plain.filled(1.5)
    field = np.array([1.0, 2.0, 7.0])
    out = weights.apply(field, bounded=True)
    was = plain.status != EMPTY
    np.testing.assert_array_equal(out[was], plain.apply(field, bounded=True)[was])
    assert weights.status[0, 2] == FILLED and out[0, 2] == out[0, 1]
    assert weights.status[1, 4] == FILLED and out[1, 4] == 7.0
    assert weights.status[0, 4] == EMPTY and np.isnan(out[0, 4])


def test_slices_on_ranks_give_the_same():
    """Two slices, added up as ranks would: first the moments, then the averages."""
    grid, x, y, area = scene(n=300)
    field = np.sin(x / 1e5)
    whole = build_weights(x, y, area, grid)
    parts = [slice(0, 120), slice(120, 300)]

    moments = [node_moments(grid.pairs(x[p], y[p]), area[p] / area.max()) for p in parts]
    total = moments[0] + moments[1]
    values = []
    for p in parts:
        ranks = Ranks(lambda part: total, lambda part: np.array([area.max()]))
        weights = build_weights(x[p], y[p], area[p], grid, ranks=ranks)
        np.testing.assert_array_equal(weights.status, whole.status)
        values.append(weights.matrix @ field[p])
    out = (values[0] + values[1]).reshape(grid.shape)
    filled = whole.status != EMPTY
    np.testing.assert_allclose(out[filled], whole.apply(field)[filled], rtol=1e-12, atol=1e-12)


def test_bad_input_is_named():
    one = np.ones(1)
    with pytest.raises(FloeError, match="axis 'x' must ascend"):
        Grid(np.array([0.0, 1.0, 3.0]), np.arange(3.0))
    with pytest.raises(FloeError, match="element 1 lies at x = nan"):
        build_weights(np.array([1.0, np.nan]), np.ones(2), np.ones(2), GRID)
    with pytest.raises(FloeError, match="element 0 is weighted by -1"):
        build_weights(one, one, -one, GRID)
    with pytest.raises(FloeError, match="1 elements, but 2 amounts"):
        build_weights(one, one, np.ones(2), GRID)
    with pytest.raises(FloeError, match="reach of 0"):
        build_weights(one, one, one, GRID, reach=0)
    with pytest.raises(FloeError, match="field has shape"):
        build_weights(one, one, one, GRID).apply(np.ones(2))
