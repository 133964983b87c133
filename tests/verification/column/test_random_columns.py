# SPDX-License-Identifier: GPL-2.0-or-later
"""Any column: bounded, finite, and energy and water conserved to round-off."""

from dataclasses import fields, replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from floeflow.column.kernel import HOUR
from floeflow.column.layered import (
    LayeredState,
    ice_energy,
    ice_residual,
    pack_forcing,
    pond_residual,
    salt_residual,
    sea_residual,
    step,
    take,
    water_residual,
)
from floeflow.column.physics import Physics
from floeflow.column.thermodynamics.enthalpy import salinity_profile
from floeflow.column.thermodynamics.mush import brine_salinity, liquidus
from floeflow.column.thickness.categories import category_bounds
from support.sound_columns import sound

P = Physics()
DEPTH = 20.0  # m
MELTING = -P.melting_slope * salinity_profile(7, P)


def draw_columns(seed: int, n: int, categories: int, melting: bool) -> LayeredState:
    """Columns of 1e-6 to 20 m under 0 to 2 m of snow; all layers near melting, or any."""
    rng = np.random.default_rng(seed)
    shape = (n, categories)
    bounds = category_bounds(categories)
    low = np.maximum(bounds[:-1], 1e-6) if categories > 1 else np.array([1e-6])
    high = np.minimum(bounds[1:], 20.0)
    thickness = np.exp(rng.uniform(np.log(low), np.log(high), shape))
    area = rng.dirichlet(np.full(categories + 1, 0.5), n)[:, :categories]
    area[rng.random(shape) < 0.2] = 0.0
    snow = np.where(rng.random(shape) < 0.5, 10 ** rng.uniform(-6, np.log10(2.0), shape), 0.0)
    temperature = np.minimum(rng.uniform(-45.0, 0.0, (*shape, 7)), MELTING - 1e-9)
    if melting:
        temperature = MELTING - 10 ** rng.uniform(-9, -2, (*shape, 7))
    ice = P.heat_ice * (MELTING - temperature) + P.fusion * (1 - MELTING / temperature)
    ice = -P.ice_density * (ice - P.heat_water * MELTING)
    white = -P.snow_density * (P.fusion + P.heat_ice * rng.uniform(0.0, 45.0, (*shape, 1)))
    there = area > 0.0
    freezes = rng.random(n) < 0.3
    return LayeredState(
        ice_fraction=area,
        ice_volume=area * thickness,
        snow_volume=area * snow,
        surface_temperature=np.where(there, rng.uniform(-60.0, 0.0, shape), -1.8),
        ice_enthalpy=ice * there[..., None],
        snow_enthalpy=white * there[..., None],
        ice_salinity=np.broadcast_to(salinity_profile(7, P), (*shape, 7)) * there[..., None],
        sea_temperature=np.where(freezes, -34.0 * P.melting_slope, rng.uniform(-1.836, 2.0, n)),
        pending_freeze=np.where(freezes, rng.uniform(0.0, 3.6e6, n), 0.0),
    )


def draw_mush(seed: int, n: int, categories: int, melting: bool) -> LayeredState:
    """The same columns of mush, of 0.1 to 34 of salinity and -45 degC to its melting."""
    state = draw_columns(seed, n, categories, False)
    rng = np.random.default_rng(seed + 2)
    salinity = 10 ** rng.uniform(-1.0, 1.53, state.ice_enthalpy.shape)
    melts = np.vectorize(liquidus.py_func)(salinity)
    below = 10 ** rng.uniform(-9.0, -2.0 if melting else 1.6, salinity.shape)
    temperature = np.maximum(melts - below, -45.0)
    brine = np.vectorize(brine_salinity.py_func)(temperature)
    liquid = salinity / np.maximum(brine, salinity)
    ice = liquid * P.heat_water * P.water_density * temperature
    ice = ice + (1.0 - liquid) * P.ice_density * (P.heat_ice * temperature - P.fusion)
    there = (state.ice_fraction > 0.0)[..., None]
    freezing = liquidus.py_func(34.0)
    return replace(
        state,
        ice_enthalpy=ice * there,
        ice_salinity=salinity * there,
        sea_temperature=np.maximum(state.sea_temperature + 1.836 + freezing, freezing),
    )


def draw_ponds(seed: int, state: LayeredState) -> LayeredState:
    """Level ice, ponds of up to 2 m with lids, and snow on the lids, on the ice of a state."""
    rng = np.random.default_rng(seed + 3)
    shape = state.ice_fraction.shape
    there = state.ice_fraction > 0.0
    wet = there & (rng.random(shape) < 0.6)
    flat = np.where(rng.random(shape) < 0.5, 1.0, rng.uniform(0.0, 1.0, shape))
    return replace(
        state,
        level_area=flat * there,
        level_volume=np.where(flat < 1.0, rng.uniform(0.0, 1.0, shape), 1.0) * there,
        pond_area=np.where(rng.random(shape) < 0.3, 1.0, rng.uniform(0.0, 1.0, shape)) * wet,
        pond_depth=10 ** rng.uniform(-8.0, 0.3, shape) * wet,
        pond_lid=np.where(rng.random(shape) < 0.5, 10 ** rng.uniform(-6.0, 0.0, shape), 0.0) * wet,
        lid_snow=np.where(rng.random(shape) < 0.3, rng.uniform(0.0, 0.3, shape), 0.0) * wet,
        lid_share=np.where(rng.random(shape) < 0.3, rng.uniform(0.0, 1.0, shape), 0.0) * wet,
    )


def draw_weather(seed: int, n: int, warm: bool) -> np.ndarray:
    """Air of -60 to 15 degC, 0 to 800 W/m2 of sun."""
    rng = np.random.default_rng(seed + 1)
    sun = rng.uniform(0.0, 800.0, n)
    values = {
        "potential_temperature": 273.15 + rng.uniform(-5.0 if warm else -60.0, 15.0, n),
        "humidity": 10 ** rng.uniform(-5, -2, n),
        "density": rng.uniform(1.1, 1.6, n),
        "wind": rng.uniform(0.0, 30.0, n),
        "longwave": rng.uniform(80.0, 400.0, n),
        "visible": 0.52 * sun,
        "infrared": 0.48 * sun,
        "snowfall": np.where(rng.random(n) < 0.5, rng.uniform(0.0, 2e-4, n), 0.0),
        "sea_salinity": np.full(n, 34.0),
        "deep_heat": rng.uniform(-5.0, 50.0, n),
        "mixed_depth": np.full(n, DEPTH),
        "ocean_friction": rng.uniform(0.0, 0.02, n),
        "rain": np.where(rng.random(n) < 0.3, rng.uniform(0.0, 1e-3, n), 0.0),
        "diffuse_visible": rng.uniform(0.0, 1.0, n),
        "diffuse_infrared": rng.uniform(0.0, 1.0, n),
        "sun_height": rng.uniform(-1.0, 1.0, n),
    }
    return pack_forcing(values, 1, n)


@settings(max_examples=100)
@given(
    seed=st.integers(0, 2**31),
    categories=st.sampled_from([1, 2, 5]),
    mushy=st.booleans(),
    melting=st.booleans(),
    warm=st.booleans(),
    dt=st.sampled_from([60.0, 3600.0, 86400.0]),
    scattered=st.booleans(),
    redistributed=st.booleans(),
    ponds=st.sampled_from(["none", "spread", "keep", "no lids"]),
)
def test_any_column(
    seed: int,
    categories: int,
    mushy: bool,
    melting: bool,
    warm: bool,
    dt: float,
    scattered: bool,
    redistributed: bool,
    ponds: str,
) -> None:
    n = 200
    p = P._replace(
        mushy=mushy,
        delta_eddington=scattered,
        redistribute_light=redistributed,
        ponds=ponds != "none",
        ponds_cover_level=ponds == "spread",
        pond_lids=ponds != "no lids",
    )
    before = (draw_mush if mushy else draw_columns)(seed, n, categories, melting)
    if p.ponds:
        before = draw_ponds(seed, before)
    forcing, bounds = draw_weather(seed, n, warm), category_bounds(categories)
    after, sums = step(before, forcing, dt, bounds, p)
    sound(after)
    assert (after.ice_salinity[after.ice_fraction > 0.0] > 0.0).all()
    most = np.maximum(np.abs(ice_energy(before)), np.abs(ice_energy(after)))
    hours = max(1.0, dt / HOUR)  # into which a step may be cut: round-off adds up
    allowed = np.maximum(1e-8 * dt, hours * 1e-14 * most)
    assert (np.abs(ice_residual(before, after, sums)) <= allowed).all()
    sea = P.heat_water * P.water_density * DEPTH * 3.0  # J/m2, the most that it holds
    assert (
        np.abs(sea_residual(before, after, sums, DEPTH, p)) <= 1e-8 * dt + hours * 1e-15 * sea
    ).all()
    ice, snow = water_residual(before, after, sums)
    assert np.abs(ice).max() < hours * 2e-14
    assert np.abs(snow).max() < hours * 2e-15
    if mushy:
        assert np.abs(salt_residual(before, after, sums)).max() < hours * 1e-12
    assert (sums["rescued"] <= sums["solves"]).all()
    assert np.abs(pond_residual(before, after, sums)).max() < hours * 1e-14
    light = forcing[0, :, 5] + forcing[0, :, 6]
    shone = sums["light_absorbed"] + sums["light_to_sea"]
    # The light is dealt out before the ice changes; in a step of several parts it may grow first.
    lit = before.ice_fraction.sum(axis=1) if hours == 1.0 else 1.0
    assert (shone <= light * lit * dt * (1.0 + 1e-12)).all()
    assert (shone >= 0.0).all()

    part = slice(n // 3, n // 2)
    alone, _ = step(take(before, part), forcing[:, part], dt, bounds, p)
    for field in fields(after):
        whole = getattr(after, field.name)[part]
        assert np.array_equal(getattr(alone, field.name), whole), field.name


def test_what_the_iteration_cannot_do_is_done_and_counted() -> None:
    # All layers within a hundredth of a kelvin of melting under any weather: many do not converge.
    before = draw_columns(3, 2000, 1, True)
    forcing, bounds = draw_weather(3, 2000, False), category_bounds(1)
    after, sums = step(before, forcing, 3600.0, bounds, P)
    rescued = sums["rescued"] > 0
    assert 0.05 < rescued.mean() < 0.9
    assert sums["sweeps"].max() < 60
    # The fallback balances the surface: what it gives off is what the layers conduct to it.
    fallback, _ = step(before, forcing, 3600.0, bounds, P._replace(iterations=0))
    for field in fields(after):
        same = getattr(after, field.name)[rescued] == getattr(fallback, field.name)[rescued]
        assert same.all(), field.name
    sound(fallback)


def test_ice_goes_and_comes_back() -> None:
    before = draw_columns(5, 50, 5, False)
    hot, cold = draw_weather(5, 50, True), draw_weather(5, 50, False)
    for name, value in (("hot", 288.0), ("cold", 233.0)):
        weather = hot if name == "hot" else cold
        weather[:, :, 0] = value
        weather[:, :, 4] = 400.0 if name == "hot" else 150.0
        weather[:, :, 5:7] = 400.0 if name == "hot" else 0.0
        weather[:, :, 7] = weather[:, :, 9] = 0.0
    bounds = category_bounds(5)
    gone, _ = step(before, np.repeat(hot, 24 * 400, axis=0), 3600.0, bounds, P)
    assert (gone.ice_fraction == 0.0).all() and (gone.sea_temperature > 0.0).all()
    back, sums = step(gone, np.repeat(cold, 24 * 100, axis=0), 3600.0, bounds, P)
    sound(back)
    assert (back.ice_fraction.sum(axis=1) > 0.5).all() and (sums["new_ice"] > 0.0).all()
