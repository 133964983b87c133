# SPDX-License-Identifier: GPL-2.0-or-later
"""Columns as scenes run them: every scheme with any set of processes keeps its budgets."""

from __future__ import annotations

import itertools
from datetime import datetime

import numpy as np
import pytest

from floeflow.column.initial_columns import first_columns, layer_temperatures
from floeflow.column.params import Settings
from floeflow.column.schemes import SCHEMES, advance_columns
from floeflow.column.thickness.ridging_closure import close_columns
from floeflow.column.zero_layer_run import column_forcing
from floeflow.core.sun import day_of_year, sun_height
from floeflow.scene.effects import EFFECTS, column_variables

DAY = 86400.0
COLD = {
    "wind_u": 6.0,
    "wind_v": 2.0,
    "air_temperature": 248.0,
    "specific_humidity": 4e-4,
    "air_pressure": 1.01e5,
    "longwave_down": 180.0,
    "shortwave_down": 0.0,
    "snowfall": 4e-6,
    "ocean_heat_flux": 2.0,
}
WARM = COLD | {
    "air_temperature": 276.0,
    "specific_humidity": 4.2e-3,
    "longwave_down": 310.0,
    "shortwave_down": 320.0,
}
ALL = ("snow", "shortwave", "lateral_melt", "frazil", "mixed_layer")
SETS = [ALL, (), *[(name,) for name in ALL], *[tuple(set(ALL) - {name}) for name in ALL]]


def start(settings: Settings, fraction: list[float], thickness: list[float]) -> dict:
    """Columns with the variables of the processes, and no others."""
    a, h = np.array(fraction), np.array(thickness)
    every = first_columns(a, a * h, np.full(len(a), 0.1), 258.15, settings)
    effects = [name for name in EFFECTS if name in ("thermodynamics", *settings.processes)]
    return {name: every[name] for name in column_variables(effects, settings.scheme)}


def weather(values: dict[str, float], settings: Settings, count: int):
    """Forcing at all elements that has what the processes read."""
    kept = dict(values)
    for process, name in (("snow", "snowfall"), ("shortwave", "shortwave_down")):
        if not settings.has(process):
            del kept[name]
    kept["friction_velocity"] = 0.01
    return lambda t: {name: np.full(count, value) for name, value in kept.items()}


def check(before: dict, after: dict, terms: dict, seconds: float) -> None:
    """What holds in any window: shapes, bounds, budgets."""
    assert set(after) == set(before)
    for name, values in after.items():
        assert values.shape == before[name].shape and np.isfinite(values).all(), name
    assert (after["ice_fraction"] >= 0).all() and (after["ice_volume"] >= 0).all()
    assert (after["ice_fraction"].sum(axis=1) <= 1.0 + 1e-12).all()
    for kind, allowed in (("energy", 1e-8 * seconds), ("water", 1e-9), ("salt", 1e-11)):
        if f"{kind}_stored" in terms:
            named = sum(v for k, v in terms.items() if k.startswith(f"{kind}_"))
            assert np.abs(2.0 * terms[f"{kind}_stored"] - named).max() < allowed, kind
    for kind, volume in (("growth_", "ice_volume"), ("snow_", "snow_volume")):
        named = sum(v for k, v in terms.items() if k.startswith(kind))
        if volume in after:
            change = (after[volume] - before[volume]).sum(axis=1)
            assert np.abs(change - named).max() < 1e-12, kind
        else:
            assert not isinstance(named, np.ndarray), kind


@pytest.mark.parametrize("processes", SETS, ids=lambda names: "-".join(names) or "none")
@pytest.mark.parametrize(("scheme", "categories"), list(itertools.product(SCHEMES, (1, 5))))
def test_any_set_of_processes_keeps_its_budgets(scheme, categories, processes):
    settings = Settings(scheme=scheme, categories=categories, processes=processes)
    columns = start(settings, [0.0, 0.6, 0.95, 1.0], [0.0, 0.3, 1.5, 3.0])
    for values in (COLD, WARM):
        sample = weather(values, settings, 4)
        after, terms = advance_columns(columns, sample, (0.0, 3 * DAY), settings)
        check(columns, after, terms, 3 * DAY)
        for name, word in (("frazil", "new_ice"), ("lateral_melt", "lateral"), ("snow", "snow")):
            if name not in processes:
                assert not [term for term in terms if word in term]
        if values is COLD:
            born = after["ice_fraction"][0].sum() > 0
            assert born == ("frazil" in processes)
        columns = after


@pytest.mark.parametrize("scheme", SCHEMES)
def test_heat_that_goes_down_freezes_no_sea_under_the_sun(scheme):
    settings = Settings(scheme=scheme, processes=ALL)
    columns = start(settings, [0.6, 0.95], [0.8, 1.5])
    for down in (80.0, 150.0):
        sample = weather(WARM | {"ocean_heat_flux": -down}, settings, 2)
        after, terms = advance_columns(columns, sample, (0.0, 3 * DAY), settings)
        check(columns, after, terms, 3 * DAY)
        assert (terms["growth_new_ice"] == 0).all()
        # It takes what the sun brings to open water: less melts than without.
        still = advance_columns(columns, weather(WARM, settings, 2), (0.0, 3 * DAY), settings)[1]
        assert (still["growth_melt_base"] < terms["growth_melt_base"]).all()


@pytest.mark.parametrize("light", ["ccsm3", "delta_eddington"])
@pytest.mark.parametrize("scheme", ["bl99", "mushy"])
def test_ponds_keep_their_water(scheme, light):
    settings = Settings(scheme=scheme, categories=5, processes=(*ALL, "ponds"), light=light)
    columns = start(settings, [0.0, 0.6, 0.95, 1.0], [0.0, 0.3, 1.5, 3.0])
    assert (columns["level_area"] == (columns["ice_fraction"] > 0)).all()
    sun = {"sun_height": 0.5}
    # Frozen over first: what ponds hold at the end is there to run off.
    for values in (WARM, COLD, WARM):
        sample = weather(values | sun, settings, 4)
        after, terms = advance_columns(columns, sample, (0.0, 20 * DAY), settings)
        check(columns, after, terms, 20 * DAY)
        named = sum(value for name, value in terms.items() if name.startswith("pond_"))
        assert np.abs(2.0 * terms["pond_stored"] - named).max() < 1e-12
        if values is WARM:
            assert (terms["pond_gain"][2:] > 0).all()
        columns = after
    # Ridges are not level, and what ponds they had has run off.
    closed = np.array([0.0, 0.3, 0.2, 0.6])
    ridged, terms = close_columns(columns, closed, settings)
    there, left = (c["ice_fraction"] * c["level_area"] for c in (columns, ridged))
    run_off = (there - left * (1.0 - closed)[:, None]) * columns["pond_area"]
    run_off = (run_off * columns["pond_depth"]).sum(axis=1)
    assert run_off[3] > 0
    np.testing.assert_allclose(terms["pond_ridging"] * (1.0 - closed), -run_off, atol=1e-15)
    level = (ridged["ice_fraction"] * ridged["level_area"]).sum(axis=1)
    assert (level <= ridged["ice_fraction"].sum(axis=1) + 1e-14).all()
    assert level[3] < 0.9 * ridged["ice_fraction"][3].sum()
    again, its = advance_columns(columns, sample, (0.0, DAY), settings, closed)
    named = sum(value for name, value in its.items() if name.startswith("pond_"))
    assert np.abs(2.0 * its["pond_stored"] - named).max() < 1e-12


def test_the_sun_stands_where_it_should():
    lon, lat = np.array([0.0, 0.0, 0.0, 90.0]), np.array([0.0, 80.0, 23.4, 0.0])
    noon = sun_height(day_of_year(datetime(2021, 3, 21), 43200.0), lat, lon)
    # Equinox: the cosine of the latitude, and sunset a quarter of the earth to the east.
    np.testing.assert_allclose(noon, [1.0, np.cos(np.radians(80.0)), 0.918, 0.0], atol=0.04)
    assert day_of_year(datetime(2021, 1, 1), 0.0) == 1.0
    assert day_of_year(datetime(2020, 12, 31, 6), 86400.0 * 1.5) == 1.75


@pytest.mark.parametrize("scheme", SCHEMES)
def test_ice_melts_out_and_comes_back(scheme):
    settings = Settings(scheme=scheme, categories=5, processes=ALL)
    columns = start(settings, [0.9, 1.0], [0.2, 0.05])
    hot = WARM | {"air_temperature": 285.0, "shortwave_down": 500.0, "longwave_down": 370.0}
    gone, terms = advance_columns(columns, weather(hot, settings, 2), (0.0, 10 * DAY), settings)
    check(columns, gone, terms, 10 * DAY)
    assert (gone["ice_volume"] == 0).all() and (gone["ice_fraction"] == 0).all()
    assert (gone["sea_temperature"] > columns["sea_temperature"] + 1.0).all()
    # Warm water does not freeze at once; when it has cooled it does.
    sample = weather(COLD, settings, 2)
    soon, terms = advance_columns(gone, sample, (0.0, DAY), settings)
    check(gone, soon, terms, DAY)
    assert (soon["ice_volume"] == 0).all()
    later, terms = advance_columns(soon, sample, (0.0, 60 * DAY), settings)
    check(soon, later, terms, 60 * DAY)
    assert (later["ice_volume"].sum(axis=1) > 0.05).all()


@pytest.mark.parametrize("scheme", SCHEMES)
def test_without_a_mixed_layer_water_freezes_at_once(scheme):
    born = []
    for processes in (ALL, ALL[:-1]):
        settings = Settings(scheme=scheme, processes=processes)
        columns = start(settings, [0.0], [0.0])
        if "mixed_layer" in processes:
            columns["sea_temperature"] += 1.0
        sample = weather(COLD, settings, 1)
        after, _ = advance_columns(columns, sample, (0.0, 6 * 3600.0), settings)
        born.append(after["ice_volume"].sum())
    assert born[0] == 0.0 and born[1] > 0.005


@pytest.mark.parametrize("scheme", SCHEMES)
def test_slices_give_the_same_bits(scheme):
    settings = Settings(scheme=scheme, categories=3, processes=ALL)
    fraction, thickness = np.linspace(0.2, 1.0, 7), np.linspace(0.1, 4.0, 7)
    columns = start(settings, fraction, thickness)
    warmth = np.linspace(0.0, 30.0, 7)

    def sample(part: slice):
        def at(t: float):
            values = weather(COLD, settings, 7)(t)
            values["air_temperature"] = values["air_temperature"] + warmth
            return {name: value[part] for name, value in values.items()}

        return at

    whole, terms = advance_columns(columns, sample(slice(None)), (0.0, DAY), settings)
    for part in (slice(0, 2), slice(2, 7), slice(3, 3)):
        own = {name: values[part] for name, values in columns.items()}
        piece, its = advance_columns(own, sample(part), (0.0, DAY), settings)
        for name in whole:
            np.testing.assert_array_equal(piece[name], whole[name][part], err_msg=name)
        for name in terms:
            np.testing.assert_array_equal(its[name], terms[name][part], err_msg=name)


@pytest.mark.parametrize("scheme", ["bl99", "mushy"])
def test_first_layers_lie_between_surface_and_sea(scheme):
    settings = Settings(scheme=scheme, categories=5, layers=4, processes=ALL)
    columns = start(settings, [0.9, 0.0], [1.5, 0.0])
    snow, ice = layer_temperatures(columns, settings)
    assert ice.shape == (2, 5, 4) and snow.shape == (2, 5, 1)
    there = columns["ice_volume"][0] > 0
    assert there.sum() == 1 and np.isnan(ice[1]).all()
    profile = np.concatenate([snow[0, there][0], ice[0, there][0]])
    assert (np.diff(profile) > 0).all()
    assert profile[0] > 258.15 and profile[-1] < columns["sea_temperature"][0]
    np.testing.assert_allclose(np.diff(profile[1:]), np.diff(profile[1:])[0])


def test_what_no_effect_reads_counts_as_none():
    values = {name: np.ones(2) for name in COLD if name not in ("snowfall", "shortwave_down")}
    forcing = column_forcing(values, 2)
    assert (forcing.snowfall == 0).all() and (forcing.shortwave_down == 0).all()
