# SPDX-License-Identifier: GPL-2.0-or-later
"""Hard case 6: thermodynamics at its edges.

Ice that melts out within a step or is born in one, layers a picokelvin below melting where heat
capacity is a thousand times that of ice, sun on a millimetre of ice, weather that jumps by 50 K,
ice without salt, steps of a second and of a day. Column codes divide by thickness, by salinity and
by the distance to melting; Icepack aborts the run where its iteration fails. What must hold: no
abort; all finite and bounded; energy, water, salt and ponds closed to round-off in every step; the
surface balanced; long steps near what short ones give.
"""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest

from floeflow.column.layered import step
from floeflow.column.thermodynamics.zero_layer import step as simple_step
from support.stability.columns import BOUNDS, PHYSICS, advance, columns, freezing, weather
from unit.column.test_zero_layer import PARAMS, check
from unit.column.test_zero_layer import columns as simple_columns
from unit.column.test_zero_layer import weather as simple_weather

STEPS = 12
DAY = 86400.0
# From a monolayer of ice to more than any category, open water, and a speck of ice in it.
THICKNESS = np.array([1e-8, 1e-6, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 5.0, 0.5, 0.5])
AREA = np.array([1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 1e-6])
N = len(THICKNESS)


def jumping(low: float, high: float) -> np.ndarray:
    """One value, then the other, at every step."""
    return np.where(np.arange(STEPS) % 2, high, low)[:, None]


SUMMER = {
    "potential_temperature": 285.0,
    "humidity": 8e-3,
    "longwave": 380.0,
    "sun": 700.0,
    "wind": 15.0,
    "ocean_friction": 0.02,
}
THAW = {"potential_temperature": 274.0, "humidity": 4e-3, "longwave": 300.0}
# Name: columns that differ from the plain ones, weather that differs from a winter night.
CASES: dict[str, tuple[dict, dict]] = {
    "melts out": ({"sea": 2.0}, SUMMER),
    "first ice": ({"area": 0.0}, {"potential_temperature": 240.0, "longwave": 140.0, "wind": 20.0}),
    "snow on nothing": ({}, {"snowfall": 1e-3, "potential_temperature": 272.0, "longwave": 300.0}),
    "snow that sinks all ice": ({"snow": 2.0}, {"snowfall": 1e-3}),
    "near melting, warm": ({"below": 1e-9, "snow": 0.1}, THAW | {"sun": 100.0}),
    "near melting, cold": ({"below": 1e-12}, {}),
    "sun": ({"below": 2.0}, {"sun": 1000.0, "potential_temperature": 265.0, "longwave": 250.0}),
    "50 K a step": ({"snow": 0.1}, {"potential_temperature": jumping(240.0, 290.0)}),
    "sun on and off": ({"snow": 0.01}, {"sun": jumping(0.0, 1000.0)}),
    "no salt at all": ({"salinity": 0.0}, {"sea_salinity": 0.0}),
    "a trace of salt": ({"salinity": 1e-12}, {"sea_salinity": 1e-12}),
    "fresh ice on a salty sea": ({"salinity": 0.0}, {}),
    "all the salt of the sea": ({"salinity": 34.0, "below": 10.0}, {}),
    "a cloudburst": ({}, THAW | {"rain": 1e-2}),
    "the coldest storm": (
        {"below": 48.0},
        {"potential_temperature": 200.0, "longwave": 80.0, "wind": 40.0, "humidity": 1e-6},
    ),
    "no weather": ({}, {"wind": 0.0, "humidity": 0.0, "longwave": 0.0, "deep_heat": 0.0}),
}


@pytest.mark.parametrize("dt", [1.0, 3600.0, DAY])
@pytest.mark.parametrize("name", PHYSICS)
def test_edges_of_layered_ice(name: str, dt: float, record):
    """Every case, by scheme and step: finite, bounded, all budgets closed in every step."""
    p = PHYSICS[name]
    rescued = solved = 0.0
    for own, given in CASES.values():
        sea = freezing(p, float(given.get("sea_salinity", 34.0)))
        before = columns(p, THICKNESS, **({"area": AREA, "sea": sea} | own))
        _, sums = advance(before, weather(STEPS, N, **given), dt, p)
        rescued, solved = rescued + sums["rescued"].sum(), solved + sums["solves"].sum()
    record(cases=len(CASES), solves=solved, rescued=rescued)
    assert solved > 1000


@pytest.mark.parametrize("dt", [1.0, 3600.0, DAY])
def test_edges_of_zero_layer_ice(dt: float):
    """The same weather on ice that holds no heat."""
    simple = {"air_temperature": "potential_temperature", "shortwave_down": "sun",
              "longwave_down": "longwave", "wind_speed": "wind", "snowfall": "snowfall",
              "specific_humidity": "humidity"}  # fmt: skip
    for own, given in CASES.values():
        state = simple_columns(
            THICKNESS, own.get("snow", 0.0), own.get("area", AREA), 273.15 - own.get("below", 5.0)
        )
        for k in range(STEPS):
            now = {
                name: float(np.broadcast_to(given[old], (STEPS, 1))[k, 0])
                for name, old in simple.items()
                if old in given
            }
            after, fluxes = simple_step(state, simple_weather(N, **now), dt, PARAMS)
            check(state, after, fluxes, dt)
            state = after


@pytest.mark.parametrize("name", PHYSICS)
def test_ice_melts_out_in_one_step_and_leaves_nothing(name: str):
    p = PHYSICS[name]
    thin = np.array([1e-8, 1e-5, 1e-3, 0.02])
    before = columns(p, thin, snow=[0.0, 1e-6, 0.01, 0.0], sea=3.0)
    after, sums = advance(before, weather(1, 4, **SUMMER), DAY, p)
    assert (after.ice_volume == 0.0).all() and (after.snow_volume == 0.0).all()
    assert (after.ice_enthalpy == 0.0).all() and (after.pond_depth == 0.0).all()
    # The sea is 3 K warm and gets a summer's day: it melts the ice and is warm still.
    assert (after.sea_temperature > 0.0).all()
    melted = sum(sums[n] for n in ("melt_top", "melt_bottom", "melt_lateral", "cleared_ice"))
    gone = melted + sums["sublimation_ice"] - sums["snow_ice"] - sums["growth"]
    np.testing.assert_allclose(gone, thin, rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize("name", PHYSICS)
def test_first_ice_is_as_thick_as_new_ice_and_as_cold_as_the_sea(name: str):
    p = PHYSICS[name]
    before = columns(p, 0.0, area=0.0)
    after, sums = advance(before, weather(2, 1), 3600.0, p)
    assert sums["new_ice"][0] > 0.0 and 0.0 < after.ice_fraction.sum() < 1.0
    thickness = after.ice_volume.sum() / after.ice_fraction.sum()
    assert thickness == pytest.approx(p.new_ice_thickness, rel=0.05)
    assert (after.ice_fraction[0, 1:] == 0.0).all()


@pytest.mark.parametrize("name", PHYSICS)
def test_snow_on_nothing_goes_to_the_sea_or_sinks_until_it_floats(name: str):
    """Snow that falls on open water, and a foot of snow on ice no thicker than round-off."""
    p = PHYSICS[name]
    before = columns(p, [0.5, 1e-13], snow=[0.0, 0.3], area=[0.0, 1.0])
    after, sums = advance(before, weather(4, 2, **THAW, snowfall=[1e-3, 0.0]), 3600.0, p)
    snow, ice = (v.sum(axis=1) for v in (after.snow_volume, after.ice_volume))
    buoyancy = (p.water_density - p.ice_density) * ice
    assert snow[0] == 0.0 and sums["snowfall"][0] == 0.0
    assert ice[1] > 0.0 and p.snow_density * snow[1] < 1.02 * buoyancy[1]


@pytest.mark.parametrize("name", PHYSICS)
def test_sunlight_on_a_millimetre_of_ice(name: str):
    """Light that the ice cannot hold goes to the sea: nothing boils, nothing is lost."""
    p = PHYSICS[name]
    before = columns(p, 1e-3, below=1.0)
    sunny = weather(60, 1, potential_temperature=271.0, longwave=280.0, sun=1000.0)
    after, sums = advance(before, sunny, 60.0, p)
    to_sea = sums["light_to_sea"][0]
    assert to_sea > 0.0
    assert sums["light_absorbed"][0] + to_sea < 3600.0 * 1000.0 * 1.0001
    assert after.surface_temperature.max() <= 0.0


@pytest.mark.parametrize("name", PHYSICS)
def test_a_year_with_an_ice_free_summer(name: str, record):
    """Hourly steps through a polar year so warm that all ice goes, and comes back."""
    p = PHYSICS[name]
    state, sea, free = columns(p, 1.2, snow=0.2, below=8.0), freezing(p), []
    volume, warmest = [], -99.0
    for day in range(365):
        season = np.cos(2.0 * np.pi * (day - 196) / 365.0)  # warmest in mid July
        high = max(season + 0.3, 0.0)
        today = weather(
            *(24, 1),
            potential_temperature=258.0 + 21.0 * season,
            humidity=1.6e-3 * 10.0 ** (0.45 * season),
            longwave=235.0 + 85.0 * season,
            sun=330.0 * high,
            sun_height=max(0.4 * high, 0.01),
            snowfall=1e-5 if season < 0.0 else 0.0,
            deep_heat=4.0,
        )
        state, _ = advance(state, today, 3600.0, p, at_once=24)
        volume.append(state.ice_volume.sum())
        free.append(volume[-1] == 0.0)
        warmest = max(warmest, float(state.sea_temperature[0]))
    record(days_without_ice=sum(free), warmest_sea=warmest, ice_at_end=volume[-1])
    assert 20 < sum(free) < 200 and 0.0 < warmest < 15.0
    assert 0.3 < volume[-1] < 3.0 and max(volume) < 4.0 and sea < 0.0


WINTERS = {
    "cold": {},
    "storm": {"potential_temperature": 220.0, "wind": 30.0, "longwave": 120.0},
}


@pytest.mark.parametrize("winter", WINTERS)
@pytest.mark.parametrize("name", ["bl99", "mushy"])
def test_daily_steps_grow_what_hourly_steps_grow(name: str, winter: str, record):
    """Open water and ice of any thickness, five days: flux through no ice lasts no day."""
    p, start = PHYSICS[name], np.array([0.0, 1e-6, 1e-3, 0.05, 0.2, 0.5, 2.0])
    grown = []
    for dt in (DAY, 7200.0, 600.0):
        before = columns(p, start, area=np.where(start > 0.0, 1.0, 0.0))
        after, _ = step(before, weather(int(5 * DAY / dt), 7, **WINTERS[winter]), dt, BOUNDS, p)
        grown.append(after.ice_volume.sum(axis=1))
    worst = np.abs(grown[0] / grown[2] - 1.0).max()
    record(daily_over_ten_minutes=worst)
    assert worst < 0.1
    assert np.abs(grown[1] / grown[2] - 1.0).max() < 0.1


def test_columns_of_a_case_do_not_touch_each_other():
    """A column alone gives the bits that it gives among the hardest."""
    p = PHYSICS["mushy, ponds, delta-Eddington"]
    before = columns(p, THICKNESS, area=AREA, below=1e-12)
    whole, _ = step(before, weather(STEPS, N), DAY, BOUNDS, p)
    for k in range(N):
        one = columns(p, THICKNESS[k : k + 1], area=AREA[k : k + 1], below=1e-12)
        alone, _ = step(one, weather(STEPS, 1), DAY, BOUNDS, p)
        for field in fields(whole):
            assert np.array_equal(getattr(alone, field.name)[0], getattr(whole, field.name)[k])
