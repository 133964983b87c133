# SPDX-License-Identifier: GPL-2.0-or-later
"""Bonds at the start join near neighbours that hold enough ice."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from floeflow.packings import bonds, packing
from floeflow.scene.blocks import Packing
from unit.packings.test_packing import coastline, mobile


@pytest.fixture(scope="module")
def packed() -> xr.Dataset:
    return packing.make_packing(coastline(), Packing(elements=300), 7)


def test_bonds_join_near_neighbours_with_ice(packed: xr.Dataset) -> None:
    near, all_edges = (bonds.make_bonds(packed, gap, 0.0) for gap in (0.1, 1.0))
    assert 0 < near.sizes["bond"] < all_edges.sizes["bond"] <= packed.sizes["edge"]
    lo, hi = near["bond_id_lo"].values - 1, near["bond_id_hi"].values - 1
    x, y, radius = (packed[name].values for name in ("x", "y", "radius"))
    span = np.hypot(x[hi] - x[lo], y[hi] - y[lo])
    np.testing.assert_allclose(near["bond_span"], span, rtol=1e-14)
    assert (span < 1.1 * (radius[lo] + radius[hi])).all()
    volume = packed["ice_volume"].values[:, 0]
    np.testing.assert_array_equal(near["bond_thickness"], np.minimum(volume[lo], volume[hi]))
    assert mobile(packed)[lo].all() and mobile(packed)[hi].all()


def test_open_ice_has_no_bonds(packed: xr.Dataset) -> None:
    fraction = packed["ice_fraction"].values[:, 0]
    table = bonds.make_bonds(packed, 0.2, 0.6)
    assert 0 < table.sizes["bond"] < bonds.make_bonds(packed, 0.2, 0.0).sizes["bond"]
    for end in ("lo", "hi"):
        assert fraction[table[f"bond_id_{end}"].values - 1].min() >= 0.6


def test_fast_ice_is_frozen_to_the_coast_along_the_shore(packed: xr.Dataset) -> None:
    without, table = (bonds.make_bonds(packed, 0.2, 0.5, coast) for coast in (False, True))
    lo, hi = (table[f"bond_id_{end}"].values - 1 for end in ("lo", "hi"))
    coast = ~mobile(packed)
    fast = coast[lo] | coast[hi]
    assert fast.sum() > 20 and not (coast[lo] & coast[hi]).any()
    # Those within the ice are the same with and without.
    for name in without:
        np.testing.assert_array_equal(table[name].values[~fast], without[name].values)
    # As thick as the ice, which must be dense enough; the line between the discs, across.
    ice = np.where(coast[lo], hi, lo)[fast]
    assert packed["ice_fraction"].values[ice, 0].min() >= 0.5
    volume = packed["ice_volume"].values[:, 0]
    np.testing.assert_array_equal(table["bond_thickness"].values[fast], volume[ice])
    x, y, radius = (packed[name].values for name in ("x", "y", "radius"))
    smaller = np.minimum(radius[lo], radius[hi])[fast]
    length = table["bond_length"].values[fast]
    assert (length > 0).all() and (length <= 2 * smaller * (1 + 1e-12)).all()
    nx, ny = x[hi] - x[lo], y[hi] - y[lo]
    span = np.hypot(nx, ny)
    for end in "ab":
        px, py = (table[f"bond_lo_{end}{axis}"].values for axis in "xy")
        ahead = ((px * nx + py * ny) / span)[fast]
        assert (ahead > radius[lo][fast] * (1 - 1e-9)).all()
        assert (ahead < (span - radius[hi])[fast] * (1 + 1e-9)).all()
        aside = np.abs((py * nx - px * ny) / span)[fast]
        assert (aside <= smaller * (1 + 1e-12)).all()


def test_without_a_coast_there_is_nothing_to_freeze_to(packed: xr.Dataset) -> None:
    inland = packed.isel(element=mobile(packed))
    a, b = (bonds.make_bonds(inland, 0.2, 0.5, coast) for coast in (False, True))
    xr.testing.assert_identical(a, b)
