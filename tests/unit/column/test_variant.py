# SPDX-License-Identifier: GPL-2.0-or-later
"""Melt converges with step and layers; area follows the water of ponds."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numba import njit

from floeflow.column.initial_columns import first_columns
from floeflow.column.params import Settings
from floeflow.column.physics import Physics
from floeflow.column.ponds.flushing import flushing
from floeflow.column.ponds.ponds import basin
from floeflow.column.schemes import advance_columns
from floeflow.scene.effects import column_variables

DAY = 86400.0
SUMMER = {
    "wind_u": 4.0,
    "wind_v": 0.0,
    "air_temperature": 273.2,
    "specific_humidity": 3.7e-3,
    "air_pressure": 1.01e5,
    "longwave_down": 290.0,
    "shortwave_down": 240.0,
    "snowfall": 0.0,
    "ocean_heat_flux": 2.0,
    "friction_velocity": 0.005,
    "sun_height": 0.45,
}
PROCESSES = ("snow", "shortwave", "lateral_melt", "frazil", "mixed_layer", "ponds")
SETTINGS = Settings(scheme="mushy", categories=5, processes=PROCESSES, light="delta_eddington")


class Profile(NamedTuple):
    """What flushing reads of a column: thickness (m), temperature (degC), liquid share."""

    thickness: np.ndarray
    temperature: np.ndarray
    liquid: np.ndarray


def melted(settings: Settings, snow: float, days: int) -> tuple[dict, dict]:
    """Columns of 2 m of ice under so much snow (m) after days of melt, and sums of their terms."""
    every = first_columns(np.ones(1), np.full(1, 2.0), np.full(1, snow), 271.0, settings)
    effects = ("thermodynamics", *settings.processes)
    columns = {name: every[name] for name in column_variables(effects, settings.scheme)}
    sample = {name: np.full(1, value) for name, value in SUMMER.items()}
    return advance_columns(columns, lambda _: sample, (0.0, days * DAY), settings)


def summer(settings: Settings) -> tuple[float, float]:
    """Thickness (m) and share of the ice under ponds after 30 days of melt."""
    after, _ = melted(settings, 0.1, 30)
    ice = after["ice_fraction"]
    ponds = (ice * after["level_area"] * after["pond_area"]).sum() / ice.sum()
    return float(after["ice_volume"].sum() / ice.sum()), float(ponds)


def test_ponds_spread_over_all_ice_in_the_way_of_icepack_alone() -> None:
    _, share = summer(SETTINGS)
    _, spread = summer(replace(SETTINGS, variant="icepack"))
    assert spread > 0.9
    assert 0.15 < share < 0.35  # of the ice in constant melt; SHEBA had 0.24 at most


@pytest.mark.parametrize("categories", [1, 5])
def test_melt_does_not_depend_on_the_step(categories: int) -> None:
    settings = replace(SETTINGS, categories=categories)
    hours, _ = summer(settings)
    quarters, _ = summer(replace(settings, step=900.0))
    assert abs(hours - quarters) < 0.01 * (2.0 - quarters)


@pytest.mark.parametrize("categories", [1, 5])
def test_melt_converges_with_the_layers(categories: int) -> None:
    few, usual, many, most = (
        2.0 - summer(replace(SETTINGS, categories=categories, layers=layers))[0]
        for layers in (4, 7, 14, 28)
    )
    assert 0.0 < most - many < 0.75 * (many - usual) < 0.75 * (usual - few)
    assert most - usual < 0.25 * most


@njit
def held(water, level, p):
    """Area and depth of a pond; compiled functions call it only."""
    return basin(water, level, p)


@given(st.floats(0.0, 1.0), st.sampled_from([0.0, 1e-3, 0.2, 0.65, 1.0]))
def test_a_pond_holds_its_water_within_the_level_ice(water: float, level: float) -> None:
    p = Physics(mushy=True, ponds=True)
    area, depth = held(water, level, p)
    assert 0.0 <= area <= level
    if level > 0.0 and water > 1e-20:
        assert abs(area * depth - water) <= 1e-15
    if 0.0 < area < level:
        assert abs(depth - p.pond_aspect * area) <= 1e-14


def test_what_ponds_catch_does_not_depend_on_how_categories_divide_the_ice() -> None:
    """Five days in which snow melts alone, so that all categories melt alike."""
    water = [
        float(melted(replace(SETTINGS, categories=n), 0.3, 5)[1]["pond_gain"][0]) for n in (1, 5)
    ]
    assert water[0] > 0.01
    assert abs(water[1] / water[0] - 1.0) < 0.05


@njit
def through(profile, ice, step, p):
    """Flushing below 0.5 m of water that covers all ice; compiled functions call it only."""
    return flushing(profile, 0, ice, 0.0, 0.5, 1.0, step, p)


def washed(p: Physics, step: float) -> float:
    """Downward speed (m/s) through ice of seven layers near melting under a deep pond."""
    layers, ice = 7, 1.5
    profile = Profile(
        thickness=np.full(layers, ice / layers),
        temperature=np.full(layers, -1.0),
        liquid=np.full(layers, 0.1),
    )
    return float(through(profile, ice, step, p))


def test_what_flushing_washes_out_does_not_depend_on_the_step() -> None:
    hour = Physics(mushy=True, ponds=True, flush_time=3600.0)
    assert washed(hour, 3600.0) == washed(hour, 900.0) > 0.0
    step = Physics(mushy=True, ponds=True)
    assert washed(step, 900.0) > washed(step, 3600.0) == washed(hour, 3600.0)
