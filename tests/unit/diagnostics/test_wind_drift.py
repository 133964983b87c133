# SPDX-License-Identifier: GPL-2.0-or-later
"""Regression of drift on wind, and free drift, against what is known of them."""

from __future__ import annotations

import numpy as np
import pytest

from floeflow.core.constants import AIR_DENSITY, SEAWATER_DENSITY
from floeflow.diagnostics.wind_drift import FreeDrift, WindSums, free_drift, wind_fit, wind_sums


def test_a_known_factor_and_angle_come_back_whole_and_in_parts():
    rng = np.random.default_rng(1)
    wind = rng.normal(size=(400, 2)) @ [8.0, 8.0j]
    slope, current = 0.018 * np.exp(-0.5j), 0.03 + 0.01j
    weight = rng.uniform(0.5, 2.0, wind.size)
    drift = slope * wind + current
    halves = [np.s_[:150], np.s_[150:]]
    sums = sum((wind_sums(wind[h], drift[h], weight[h]) for h in halves), WindSums())
    fit = wind_fit(sums)
    assert fit.factor == pytest.approx(0.018, rel=1e-10)
    assert fit.turning == pytest.approx(-0.5, rel=1e-10)
    assert fit.current == pytest.approx(current, rel=1e-9)
    assert fit.explained == pytest.approx(1.0, abs=1e-10)


def test_noise_lowers_what_is_explained_and_nothing_gives_no_fit():
    rng = np.random.default_rng(2)
    wind = rng.normal(size=(5000, 2)) @ [8.0, 8.0j]
    noise = rng.normal(size=(5000, 2)) @ [0.16, 0.16j]
    fit = wind_fit(wind_sums(wind, 0.02 * wind + noise, np.ones(5000)))
    assert fit.factor == pytest.approx(0.02, rel=0.03)
    assert fit.explained == pytest.approx(0.5, abs=0.03)
    calm = wind_fit(wind_sums(np.full(9, 5 + 0j), np.full(9, 0.1 + 0j), np.ones(9)))
    assert np.isnan([calm.factor, wind_fit(WindSums()).factor]).all()


@pytest.mark.parametrize("coriolis", [1.4e-4, -1.4e-4, 0.0])
def test_free_drift_is_in_balance(coriolis):
    drags = FreeDrift(1.2e-3, 5.5e-3, np.radians(25.0), coriolis, 1800.0)
    wind = np.array([0.0, 2.0, 10.0, 25.0])
    u = free_drift(wind, drags)
    turn = np.exp(1j * np.copysign(drags.turning_angle, coriolis))
    water = SEAWATER_DENSITY * drags.ocean_drag * np.abs(u) * u * turn
    force = water + 1j * drags.mass * coriolis * u
    np.testing.assert_allclose(force, AIR_DENSITY * drags.air_drag * wind**2, atol=1e-12)
    # Ice goes to the right of the wind in the north, to the left in the south.
    assert np.all(np.sign(np.angle(u[1:])) == (-np.sign(coriolis) if coriolis else -1))
    assert 0.014 < abs(u[2]) / 10.0 < 0.022


def test_without_water_there_is_no_free_drift():
    assert np.isnan(free_drift(np.array([5.0]), FreeDrift(1e-3, 0.0, 0.0, 1e-4, 900.0))).all()
