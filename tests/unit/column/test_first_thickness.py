# SPDX-License-Identifier: GPL-2.0-or-later
"""The start's distribution of thickness: amounts kept, bounds held, ridges thickest."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from floeflow.column.first_thickness import FirstIce, gamma, single
from floeflow.column.initial_columns import first_columns
from floeflow.column.params import Settings
from floeflow.column.thickness.categories import category_bounds

BOUNDS = category_bounds(5)
MEANS = np.array([0.05, 0.3, 1.0, 2.0, 3.0, 6.0, 15.0])


def test_gamma_is_the_integral_of_its_density():
    found = gamma(np.array([3.0]), BOUNDS, 1.0)
    edges = [*BOUNDS[:-1], 60.0]
    for n in range(5):

        def density(h: float) -> float:
            return 0.5 * h**2 * np.exp(-h)  # shape 3 about a mean of 3 m

        assert found.area[0, n] == pytest.approx(quad(density, edges[n], edges[n + 1])[0])
        volume = quad(lambda h: h * density(h), edges[n], edges[n + 1])[0] / 3.0
        assert found.volume[0, n] == pytest.approx(volume)


@pytest.mark.parametrize("spread", [single, gamma])
@pytest.mark.parametrize("level", [0.0, 0.65, 1.0])
def test_amounts_are_kept_and_categories_hold_their_ice(spread, level):
    found = spread(MEANS, BOUNDS, level)
    np.testing.assert_allclose(found.area.sum(axis=1), 1.0, rtol=1e-14)
    np.testing.assert_allclose(found.volume.sum(axis=1), 1.0, rtol=1e-14)
    there = found.area > 0.0
    thick = np.divide(MEANS[:, None] * found.volume, found.area, where=there, out=0.0 * found.area)
    assert (thick[there] <= np.broadcast_to(BOUNDS[1:], thick.shape)[there]).all()
    assert (thick[there] >= np.broadcast_to(BOUNDS[:-1], thick.shape)[there]).all()
    np.testing.assert_allclose((found.area * found.level_area).sum(axis=1), level, atol=1e-12)


def test_ridges_are_the_thickest_ice():
    found = gamma(np.array([3.0]), BOUNDS, 0.65)
    assert found.level_area[0, 0] == found.level_area[0, 1] == 1.0
    assert found.level_area[0, -1] == 0.0
    ridged = 1.0 - (found.volume * found.level_volume).sum()
    assert ridged == pytest.approx(0.56, abs=0.01)  # on 0.35 of the area


def test_columns_of_a_pack_with_leads_hold_its_ice_and_snow():
    settings = Settings(scheme="mushy", processes=("snow",), categories=5)
    fraction, volume = np.array([0.9, 0.5, 0.0]), np.array([2.7, 0.5, 0.0])
    first = FirstIce("gamma", 0.65, lead_ice=0.1)
    made = first_columns(fraction, volume, np.full(3, 0.2), 250.0, settings, first)
    np.testing.assert_allclose(made["ice_fraction"].sum(axis=1), [1.0, 0.5, 0.0])
    np.testing.assert_allclose(made["ice_volume"].sum(axis=1), [2.71, 0.5, 0.0])
    np.testing.assert_allclose(made["snow_volume"].sum(axis=1), 0.2 * fraction)
    level = (made["ice_fraction"] * made["level_area"]).sum(axis=1)
    np.testing.assert_allclose(level, [0.65 * 0.9 + 0.1, 0.65 * 0.5, 0.0])  # leads are level
    assert np.isfinite(made["ice_enthalpy"]).all()
