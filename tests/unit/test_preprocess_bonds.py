# SPDX-License-Identifier: GPL-2.0-or-later
"""Bonds at the start join near neighbours that hold enough ice."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from test_preprocess_packing import coastline, mobile

from floeflow.config.blocks import Packing
from floeflow.preprocess import bonds, packing


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
