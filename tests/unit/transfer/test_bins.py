# SPDX-License-Identifier: GPL-2.0-or-later
"""Invariants of the adding up: totals, land, full cells; and of the choice between the two."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from floeflow.core.errors import FloeError
from floeflow.transfer import Field, Grid, Remapper, build_bins, build_room, build_weights, remap

GRID = Grid(np.arange(6.0), np.arange(5.0))
PARTS = 4


def sea_of(share, reach=1):
    """Room of cells of which a share (ny, nx) is sea, in columns of a quarter from the right."""
    fine = (np.arange(6 * PARTS) + 0.5) / PARTS - 0.5, (np.arange(5 * PARTS) + 0.5) / PARTS - 0.5
    x, y = (axis.ravel() for axis in np.meshgrid(*fine))
    column, row = np.round(x).astype(int), np.round(y).astype(int)
    sea = 0.5 - (x - column) < np.broadcast_to(share, GRID.shape)[row, column]
    x, y = x[sea], y[sea]
    return build_room(x, y, np.full(len(x), PARTS**-2.0), GRID, reach=reach)


@pytest.mark.parametrize("reach", [1, 2])
def test_total_is_conserved(reach):
    rng = np.random.default_rng(0)
    x, y = rng.uniform(-0.5, 5.5, 300), rng.uniform(-0.5, 4.5, 300)
    room = sea_of(rng.choice([0.25, 0.5, 1.0], GRID.shape), reach)
    volume = rng.uniform(0, 1e12, 300)
    total = build_bins(x, y, room).total(volume)
    assert total.sum() == pytest.approx(volume.sum(), rel=1e-13)
    assert (total >= 0).all()


def test_no_ice_on_land_and_what_finds_no_sea_is_counted():
    room = sea_of([0, 0, 0, 1, 1, 1])
    x, y = np.array([0.5, 2.4, 4.0, 40.0]), np.full(4, 2.2)
    bins = build_bins(x, y, room)
    amount = np.array([1.0, 10.0, 100.0, 1000.0])
    total = bins.total(amount)
    assert (total[:, :3] == 0).all()
    assert total.sum() == pytest.approx(110.0, rel=1e-14)
    assert bins.unplaced(amount) == 1001.0
    coverage = bins.coverage(amount)
    assert np.isnan(coverage[:, :3]).all() and np.isfinite(coverage[:, 3:]).all()


@pytest.mark.parametrize("reach", [1, 2])
@pytest.mark.parametrize("share", [1.0, [0, 0, 1, 1, 1, 1], [0, 0.5, 1, 1, 0.25, 0]])
def test_a_full_sea_covers_its_cells_up_to_the_coast(reach, share):
    """No false leads at the domain's edge, nor where the coast cuts the cells."""
    room = sea_of(share, reach)
    fine = (np.arange(60) + 0.5) / 10 - 0.5, (np.arange(50) + 0.5) / 10 - 0.5
    x, y = (axis.ravel() for axis in np.meshgrid(*fine))
    column = np.round(x).astype(int)
    area = 0.01 * np.clip(
        (np.broadcast_to(share, 6)[column] - (0.5 - (x - column))) / 0.1 + 0.5, 0, 1
    )
    coverage = build_bins(x, y, room).coverage(area)
    sea = room.area > 0
    np.testing.assert_allclose(coverage[sea], 1.0, atol=0.02)
    assert np.isnan(coverage[~sea]).all()
    assert (coverage * room.area)[sea].sum() == pytest.approx(area.sum(), rel=1e-12)


def test_plain_hats_where_there_is_no_coast():
    np.testing.assert_allclose(sea_of(1.0).pull, 1.0, rtol=1e-2)


def test_half_a_cell_of_ice_is_half_covered():
    """An ice edge along x = 3: the cell on it is half ice, those further away full or empty."""
    fine = (np.arange(35) + 0.5) / 10 - 0.5
    x, y = (axis.ravel() for axis in np.meshgrid(fine, (np.arange(50) + 0.5) / 10 - 0.5))
    coverage = build_bins(x, y, sea_of(1.0)).coverage(np.full(len(x), 0.01))
    np.testing.assert_allclose(coverage[2], [1, 1, 1, 0.5, 0, 0], atol=2e-3)
    assert coverage.sum() == pytest.approx(17.5, rel=1e-12)


# A share of the least number that there is would be rounded to nothing.
amounts = st.floats(0, 100, allow_subnormal=False)
places = st.tuples(st.floats(-3, 9), st.floats(-3, 9), amounts)


@settings(deadline=None, derandomize=True, max_examples=200)
@given(
    st.lists(places, max_size=10),
    st.lists(st.sampled_from([0.0, 0.25, 1.0]), min_size=30, max_size=30),
    st.integers(1, 3),
)
def test_any_elements(rows, room, reach):
    x, y, amount = np.array(rows).reshape(-1, 3).T
    bins = build_bins(x, y, sea_of(np.array(room).reshape(GRID.shape), reach))
    total = bins.total(amount)
    assert (total >= 0).all() and (total[bins.room.area == 0] == 0).all()
    np.testing.assert_allclose(total.sum() + bins.unplaced(amount), amount.sum(), rtol=1e-12)


def test_kind_decides():
    x, y = np.array([2.2, 1.8, 2.1, 1.7]), np.array([1.1, 1.3, 0.8, 0.9])
    weights = {"ice_area": build_weights(x, y, np.ones(4), GRID)}
    remapper = Remapper(weights, build_bins(x, y, sea_of(1.0)))
    thickness, volume = Field("sithick", "intensive", "ice_area"), Field("volume", "extensive")
    twos = np.full(4, 2.0)
    assert remap(thickness, twos, remapper)[1, 2] == pytest.approx(2.0)
    assert remap(volume, twos, remapper).sum() == pytest.approx(8.0)
    with pytest.raises(FloeError, match="averaged over 'ice_mass'.*there are: ice_area"):
        remap(Field("siu", "intensive", "ice_mass"), twos, remapper)


def test_bad_input_is_named():
    one = np.ones(1)
    with pytest.raises(FloeError, match="one finite area each"):
        build_room(one, one, -one, GRID)
    with pytest.raises(FloeError, match="outside the grid"):
        build_room(-5 * one, one, one, GRID)
    with pytest.raises(FloeError, match="amounts have shape"):
        build_bins(one, one, sea_of(1.0)).total(np.ones(2))
