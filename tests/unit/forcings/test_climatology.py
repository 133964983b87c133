# SPDX-License-Identifier: GPL-2.0-or-later
"""The synthetic year: seasons as in the tables, balanced winds, storms that can be repeated."""

from __future__ import annotations

from datetime import datetime, timedelta

import numpy as np
import pytest

from floeflow.core.constants import AIR_DENSITY, EARTH_RADIUS, EARTH_ROTATION
from floeflow.core.monthly import MIDDLES, at_day, blend
from floeflow.forcings.climatology import NAMES, fields, ocean, tables, wind
from floeflow.forcings.climatology.wind import SURFACE_SHARE, TURN, pressure_and_wind
from floeflow.forcings.forcing import make_forcing
from floeflow.scene.blocks import Climatology
from floeflow.scene.effects import forcing_variables
from floeflow.scene.load import build_scene

START = datetime(1982, 1, 1)
CALM = Climatology(storminess=0.0)
YEAR = (np.arange(0, 365, 5) + 0.5) * 86400.0


def monthly(lon: float, lat: float, name: str) -> np.ndarray:
    """Means over eight hours of the middle day of each month at a place."""
    seconds = (MIDDLES[:, None] + np.arange(8) / 8.0).ravel() * 86400.0
    found = fields(np.array([lon]), np.array([lat]), START, seconds, [name], CALM, 30.0)[name]
    return found[:, 0].reshape(12, 8).mean(axis=1)


def test_tables_have_twelve_months_and_places_on_the_right_side():
    north, south = (tables.AIR_NORTH, tables.SEA_NORTH), (tables.AIR_SOUTH, tables.SEA_SOUTH)
    for table, sign in (*((t, 1) for t in north), *((t, -1) for t in south)):
        assert all(len(months) == 12 for months in table.values())
        assert all(sign * lat > 0 for _, lat in table)
    assert all(min(months) >= -1.8 for months in (*tables.SEA_NORTH.values(),))


def test_months_are_met_and_the_year_closes():
    table = np.array(tables.CLOUD_PACK)
    np.testing.assert_allclose(at_day(table, MIDDLES), table, atol=1e-12)
    assert at_day(table, np.array([0.0]))[0] == pytest.approx(at_day(table, np.array([365.0]))[0])
    lon, lat = np.array([0.0, 77.0]), np.array([90.0, 80.0])
    weights = blend(lon, lat, np.array([[0.0, 90.0], [80.0, 73.0]]), 2e5)
    np.testing.assert_allclose(weights.sum(axis=1), 1.0)
    assert weights[0, 0] > 0.99


def test_pack_and_warm_sector_have_their_seasons():
    pole, ship = monthly(0.0, 89.0, "air_temperature"), monthly(2.0, 66.0, "air_temperature")
    assert pole.argmin() in (0, 1) and 240.0 < pole.min() < 244.0
    assert 272.5 < pole.max() < 273.5
    assert ship.min() > 274.0 and (ship - pole)[:3].min() > 25.0
    # Fluxes over the pack within a sixth of Fletcher's (1965), as Maykut and Untersteiner (1971)
    # give them (kcal/cm2 a month): January and July.
    down = monthly(180.0, 85.0, "longwave_down") * 30.4 * 86400.0 / 4.184e7
    assert down[0] == pytest.approx(10.4, rel=1 / 6) and down[6] == pytest.approx(19.1, rel=1 / 6)
    sun = monthly(180.0, 85.0, "shortwave_down") * 30.4 * 86400.0 / 4.184e7
    assert sun[0] == 0.0 and sun[6] == pytest.approx(13.6, rel=1 / 6)
    snow = monthly(180.0, 85.0, "snowfall") * 30.4 * 86400.0
    assert 100.0 < snow.sum() < 180.0 and snow[6] < 0.5 * snow[8]


def test_currents_keep_the_norwegian_sea_warm_and_leave_the_pack_alone():
    heat = monthly(2.0, 66.0, "ocean_heat_flux")
    assert heat[0] > 60.0 > 0.0 > heat[6]
    # Far stations weigh a little everywhere.
    pack = monthly(-150.0, 80.0, "ocean_heat_flux")
    np.testing.assert_allclose(pack, tables.HEAT_PACK, rtol=0.01)
    lon, lat = np.array([-150.0, 2.0]), np.array([80.0, 66.0])
    np.testing.assert_allclose(ocean.open_all_year(lon, lat), [0.0, 1.0], atol=1e-3)


@pytest.mark.parametrize("lat", [75.0, -65.0])
def test_wind_blows_along_the_isobars_turned_to_low_pressure(lat: float):
    lon, step = np.array([20.0]), 0.01
    days = np.array([20.0])

    def at(east: float, north: float):
        place = lon + east, np.array([lat + north])
        return pressure_and_wind(*place, START, days * 86400.0, days, 7, 1.0)

    p_east = (at(step, 0)[0] - at(-step, 0)[0]) / (
        2 * np.radians(step) * EARTH_RADIUS * np.cos(np.radians(lat))
    )
    p_north = (at(0, step)[0] - at(0, -step)[0]) / (2 * np.radians(step) * EARTH_RADIUS)
    _, u, v = at(0, 0)
    f = 2 * EARTH_ROTATION * np.sin(np.radians(lat))
    along = np.array([-p_north, p_east]) * SURFACE_SHARE / (AIR_DENSITY * f)
    assert np.hypot(u, v) == pytest.approx(np.hypot(*along), rel=1e-4)
    cosine = (u * along[0] + v * along[1]) / np.hypot(u, v) ** 2
    assert cosine.item() == pytest.approx(np.cos(TURN), rel=1e-3)
    assert (u * p_east + v * p_north).item() < 0.0  # across, towards low pressure


def test_winds_have_the_speeds_of_the_pack_in_all_seasons():
    # Over the central Arctic 4 to 6 m/s in all seasons (Przybylak 2003).
    lon, lat = np.array([0.0, 180.0, 90.0, -150.0, -30.0]), np.array([88.0, 82.0, 84.0, 80.0, 84.0])
    wanted, speeds = ["wind_u", "wind_v"], []
    for seed in range(4):
        found = fields(lon, lat, START, YEAR, wanted, Climatology(seed=seed), 30.0)
        speeds.append(np.hypot(found["wind_u"], found["wind_v"]))
    seasons = np.array(speeds).mean(axis=(0, 2))[:72].reshape(4, 18).mean(axis=1)
    assert seasons.min() > 4.0 and seasons.max() < 6.5, seasons
    assert 10.0 < np.max(speeds) < 40.0


def test_storms_are_the_seed_s_and_any_window_is_made_by_itself():
    lon, lat = np.array([10.0]), np.array([72.0])
    whole = fields(lon, lat, START, YEAR, ["wind_u"], Climatology(seed=4), 30.0)["wind_u"]
    part = fields(lon, lat, START, YEAR[40:], ["wind_u"], Climatology(seed=4), 30.0)["wind_u"]
    np.testing.assert_array_equal(part, whole[40:])
    other = fields(lon, lat, START, YEAR, ["wind_u"], Climatology(seed=5), 30.0)["wind_u"]
    assert np.abs(other - whole).max() > 1.0


def test_the_first_year_has_storms_too():
    """Its blocks of days are so long before 2000 that their numbers are below those of seeds."""
    first = (datetime(1, 1, 1) - datetime(2000, 1, 1)) / timedelta(days=1)
    found = wind.storms(1, first, first + 30.0, True, 1.0)
    assert found and found[0].birth < first + 30.0


def test_currents_are_those_of_the_charts():
    lon, lat = np.array([-8.0, 9.0, -148.0, -140.0]), np.array([78.0, 78.0, 80.5, 76.5])
    east, north = ocean.currents(lon, lat)
    assert north[0] < -0.06 and north[1] > 0.06  # East Greenland, West Spitsbergen
    # The Beaufort Gyre turns clockwise: east on its northern side, south on its eastern.
    assert east[2] > 0.02 and north[3] < -0.01
    assert np.hypot(east, north).max() < 0.3
    # Over the ice of Fram Strait it flows southward at close to 5 cm/s (Smedsrud et al. 2011).
    strait = np.arange(-14.0, 0.5, 0.5)
    _, north = ocean.currents(strait, np.full_like(strait, 79.0))
    assert -0.06 < north.mean() < -0.045


@pytest.mark.parametrize("crs", ["EPSG:6931", "EPSG:6932"])
def test_a_window_has_all_that_the_effects_read(crs: str):
    effects = ["wind", "ocean_drag", "coriolis", "thermodynamics", "snow", "shortwave"]
    scene = build_scene(
        {
            "name": "year",
            "effects": [*effects, "frazil", "mixed_layer", "sea_relaxation"],
            "domain": {"crs": crs, "x_min": -2e6, "x_max": 2e6, "y_min": -2e6, "y_max": 2e6},
            "forcing": {"source": "climatology"},
        }
    )
    data = make_forcing(scene, "", 3)
    assert set(data.data_vars) == set(forcing_variables(scene.effects))
    assert float(data["time"][0]) == 2 * 86400.0 and float(data["time"][-1]) == 3 * 86400.0
    for name in set(NAMES) & set(data.data_vars):
        assert np.isfinite(data[name].values).all(), name
    north = crs.endswith("1")
    summer = data["shortwave_down"].mean() > 100.0  # the window lies in the first days of January
    assert bool(summer) is not north
