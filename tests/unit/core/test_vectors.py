# SPDX-License-Identifier: GPL-2.0-or-later
"""Turning vectors, and the formulas of the analytic forcing, at places with known answers."""

from __future__ import annotations

import numpy as np
import pyproj
import pytest

from floeflow.core import grids, vectors
from floeflow.forcings import analytic, forcing
from floeflow.scene.blocks import Cyclone, Gyre


@pytest.mark.parametrize(
    ("lon", "along"),
    # EPSG:6931 has Greenwich downwards: east there points to +x.
    [(0.0, (1, 0)), (90.0, (0, 1)), (180.0, (-1, 0)), (-90.0, (0, -1))],
)
@pytest.mark.parametrize("crs", ["EPSG:6931", "+proj=stere +lat_0=90 +lat_ts=70 +lon_0=0"])
def test_a_purely_eastward_wind(crs: str, lon: float, along: tuple[int, int]) -> None:
    angle = vectors.north_angle(pyproj.CRS(crs), np.array([lon]), np.array([75.0]))
    u, v = vectors.east_north_to_map(np.array([10.0]), np.array([0.0]), angle)
    assert (u[0], v[0]) == pytest.approx((10.0 * along[0], 10.0 * along[1]), abs=1e-6)


def test_north_points_to_the_pole_everywhere() -> None:
    crs = pyproj.CRS("EPSG:6931")
    x, y = np.meshgrid(np.linspace(-3e6, 3e6, 13) + 1e3, np.linspace(-3e6, 3e6, 13) + 2e3)
    angle = vectors.north_angle(crs, *grids.to_lonlat(crs, x, y))
    u, v = vectors.east_north_to_map(np.zeros_like(x), np.ones_like(x), angle)
    distance = np.hypot(x, y)
    np.testing.assert_allclose(u, -x / distance, atol=1e-7)
    np.testing.assert_allclose(v, -y / distance, atol=1e-7)


def test_at_the_pole_north_is_that_of_the_meridian() -> None:
    crs = pyproj.CRS("EPSG:6931")
    lon = np.array([0.0, 90.0, 200.0])
    at_pole = vectors.north_angle(crs, lon, np.full(3, 90.0))
    below = vectors.north_angle(crs, lon, np.full(3, 89.0))
    np.testing.assert_allclose(np.exp(1j * at_pole), np.exp(1j * below), atol=1e-9)


@pytest.mark.parametrize("turns", [-2, -1, 1, 3])
def test_longitude_may_count_any_number_of_turns(turns: int) -> None:
    crs, lon = pyproj.CRS("EPSG:6931"), np.array([10.0, 200.0])
    plain = vectors.north_angle(crs, lon, np.full(2, 80.0))
    turned = vectors.north_angle(crs, lon + 360.0 * turns, np.full(2, 80.0))
    np.testing.assert_allclose(turned, plain, atol=1e-6)


def test_turning_there_and_back_keeps_the_vector() -> None:
    rng = np.random.default_rng(2)
    u, v, angle = rng.normal(size=(3, 100))
    there = vectors.east_north_to_map(u, v, angle)
    np.testing.assert_allclose(np.hypot(*there), np.hypot(u, v), rtol=1e-14)
    np.testing.assert_allclose(vectors.map_to_east_north(*there, angle), (u, v), atol=1e-14)


def test_cyclone_turns_by_hemisphere_and_travels() -> None:
    cyclone = Cyclone(x=0.0, y=0.0, u=10.0, v=0.0, inflow_angle=0.0, wind_speed=20.0, radius=5e5)
    x, y = np.array([5e5, 2.5e5, 1e6]), np.zeros(3)
    u, v = analytic.cyclone_wind(cyclone, x, y, 0.0, northern=True)
    assert u == pytest.approx([0, 0, 0]) and v == pytest.approx([20, 10, 10])
    _, south = analytic.cyclone_wind(cyclone, x, y, 0.0, northern=False)
    assert south == pytest.approx(-v)
    _, later = analytic.cyclone_wind(cyclone, x + 3.6e5, y, 36000.0, northern=True)
    assert later == pytest.approx(v)
    inward = cyclone.model_copy(update={"inflow_angle": 90.0})
    u, v = analytic.cyclone_wind(inward, x, y, 0.0, northern=True)
    assert u == pytest.approx([-20, -10, -10]) and v == pytest.approx([0, 0, 0], abs=1e-12)


def test_gyre_is_fastest_at_its_radius_and_clockwise() -> None:
    gyre = Gyre(x=0.0, y=0.0, radius=4e5, current_speed=0.1)
    x = np.linspace(0, 2e6, 2001)
    u, v = analytic.gyre_current(gyre, x, np.zeros_like(x))
    assert x[np.argmin(v)] == pytest.approx(4e5, abs=1e3)
    assert v.min() == pytest.approx(-0.1, rel=1e-6)
    assert np.abs(u).max() == 0.0


def test_humidity_of_known_weather() -> None:
    # Saturation over ice: 611 Pa at 0 C, 103 Pa at -20 C (WMO tables).
    assert float(analytic.saturation_over_ice(273.15)) == pytest.approx(610.7, rel=2e-3)
    assert float(analytic.saturation_over_ice(253.15)) == pytest.approx(103.2, rel=5e-3)
    # Dew point 10 C at 1000 hPa: 7.63 g/kg.
    q = forcing.dew_point_humidity(np.array([283.15]), np.array([1.0e5]))
    assert q[0] == pytest.approx(7.65e-3, rel=5e-3)
