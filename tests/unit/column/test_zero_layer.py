# SPDX-License-Identifier: GPL-2.0-or-later
"""Invariants of the zero-layer column: budgets, bounds, Stefan's law, slices, seasons."""

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from floeflow.column.params import ColumnParams
from floeflow.column.state import (
    ColumnForcing,
    ColumnState,
    column_energy,
    energy_residual,
    ice_residual,
    snow_residual,
    take,
)
from floeflow.column.thermodynamics import surface, zero_layer
from floeflow.column.thermodynamics.surface import balance, saturation, surface_fluxes
from floeflow.column.unsolved import UnsolvedError
from floeflow.column.window import advance_window
from floeflow.core.constants import STEFAN_BOLTZMANN
from floeflow.core.errors import FloeError

PARAMS = ColumnParams()
step = zero_layer.step


def columns(thickness, snow=0.0, fraction=1.0, temperature=260.0):
    """One category; scalars or sequences over elements."""
    h, s, a, t = np.broadcast_arrays(*np.atleast_1d(thickness, snow, fraction, temperature))
    return ColumnState(*(np.array(v, float)[:, None] for v in (a, a * h, a * s, t)))


def weather(n=1, **given_values):
    values = {
        "air_temperature": 250.0,
        "specific_humidity": 5e-4,
        "wind_speed": 5.0,
        "shortwave_down": 0.0,
        "longwave_down": 180.0,
        "snowfall": 0.0,
        "air_pressure": 1.01e5,
        "ocean_heat_flux": 2.0,
        "friction_velocity": 0.005,
    }
    values.update(given_values)
    return ColumnForcing(**{k: np.full(n, float(v)) for k, v in values.items()})


def check(before, after, fluxes, dt):
    """Everything that must hold after any step."""
    for record in (after, fluxes):
        for f in fields(record):
            assert np.isfinite(getattr(record, f.name)).all(), f.name
    assert (after.ice_fraction >= 0).all() and (after.ice_volume >= 0).all()
    assert (after.snow_volume >= 0).all()
    assert (after.ice_fraction.sum(axis=1) <= 1 + 1e-12).all()
    assert ((after.surface_temperature >= 100) & (after.surface_temperature <= 273.15)).all()
    gone = after.ice_volume == 0
    assert (after.ice_fraction[gone] == 0).all() and (after.snow_volume[gone] == 0).all()
    for name in ("growth_base", "new_ice", "melt_top", "melt_base", "melt_lateral", "snow_melt"):
        assert (getattr(fluxes, name) >= 0).all(), name
    energy = np.abs(column_energy(before, PARAMS)) + np.abs(fluxes.energy_atmosphere)
    allowed = np.maximum(1e-8 * dt, 1e-14 * energy)
    assert (np.abs(energy_residual(before, after, fluxes, PARAMS)) <= allowed).all()
    assert np.abs(ice_residual(before, after, fluxes)).max() <= 1e-14
    assert np.abs(snow_residual(before, after, fluxes)).max() <= 1e-14


thicknesses = st.floats(0, 20) | st.floats(1e-6, 1e-3) | st.just(0.0)
elements = st.tuples(thicknesses, st.floats(0, 2), st.floats(1e-6, 1), st.floats(200, 273.15))


@settings(deadline=None, derandomize=True, max_examples=300)
@given(
    st.lists(elements, min_size=3, max_size=3),
    st.floats(213.15, 288.15),
    st.floats(0, 1),
    st.floats(0, 40),
    st.floats(0, 800),
    st.floats(80, 420),
    st.floats(0, 1e-4),
    st.floats(-50, 200),
    st.sampled_from([1.0, 600.0, 3600.0, 86400.0]),
)
def test_any_column(cells, air, humidity, wind, sun, sky, snowfall, ocean, dt):
    h, s, a, t = (np.array(v) for v in zip(*cells, strict=True))
    pressure = np.array([1.01e5])
    wet = humidity * saturation(np.array([air]), pressure, True)[0][0]
    forcing = weather(
        3,
        air_temperature=air,
        specific_humidity=wet,
        wind_speed=wind,
        shortwave_down=sun,
        longwave_down=sky,
        snowfall=snowfall,
        ocean_heat_flux=ocean,
    )
    single = columns(h, s, a, t)
    after, fluxes = step(single, forcing, dt, PARAMS)
    check(single, after, fluxes, dt)
    # The same cells as three categories of one element.
    share = a / max(a.sum(), 1.0)
    several = ColumnState(*(v[None, :] for v in (share, share * h, share * s, t)))
    one = ColumnForcing(**{f.name: getattr(forcing, f.name)[:1] for f in fields(forcing)})
    for _ in range(3):
        after, fluxes = step(several, one, dt, PARAMS)
        check(several, after, fluxes, dt)
        several = after


@pytest.mark.parametrize("flux", [-400.0, -1.0, 0.0, 30.0, 300.0])
def test_surface_balance_is_solved(flux):
    """The temperature found balances the fluxes, or is melting with the rest as excess."""
    forcing = weather(4, longwave_down=250.0 + flux / 2, shortwave_down=max(flux, 0.0))
    conductance = np.array([[1e-2], [1.0], [1e2], [2e6]])
    first = np.array([[120.0], [273.15], [250.0], [271.0]])
    t, excess, fluxes = balance(first, conductance, forcing, np.full((4, 1), 0.6), PARAMS)
    below = conductance * (PARAMS.freezing_temperature - t)
    # Round-off of the temperature, times what one kelvin conducts, bounds what can be asked.
    np.testing.assert_array_less(
        np.abs(fluxes.net + below - excess), 1e-8 + 1e-13 * 273 * conductance
    )
    assert ((excess == 0) | (t == PARAMS.melting_temperature)).all()


def test_a_surface_without_balance_stops_the_run(monkeypatch):
    before = columns([2.0, 1.0])
    with monkeypatch.context() as stuck:
        stuck.setattr(surface, "MAX_ITERATIONS", 1)
        with pytest.raises(UnsolvedError, match="in 2 of 2 columns, first in column 0"):
            step(before, weather(2), 3600.0, PARAMS)
    before.surface_temperature[1] = np.nan
    with pytest.raises(UnsolvedError, match="in 1 of 2 columns, first in column 1"):
        step(before, weather(2), 3600.0, PARAMS)


def test_flux_slope_is_the_derivative():
    forcing = weather(3, wind_speed=12.0)
    t = np.array([[230.0], [255.0], [273.0]])
    for ice in (True, False):
        up = surface_fluxes(t + 1e-3, forcing, 0.5, ice, PARAMS).net
        down = surface_fluxes(t - 1e-3, forcing, 0.5, ice, PARAMS).net
        slope = surface_fluxes(t, forcing, 0.5, ice, PARAMS).slope
        np.testing.assert_allclose((up - down) / 2e-3, slope, rtol=1e-6)


def test_saturation_over_water_and_ice():
    """Against the Goff-Gratch values of the Smithsonian tables (hPa), as near as Murray comes."""
    pressure = np.full(2, 1e5)
    q, _ = saturation(np.array([273.15, 293.15]), pressure, False)
    vapour = q * pressure / (0.622 + 0.378 * q) / 100
    np.testing.assert_allclose(vapour, [6.107, 23.37], rtol=2e-3)
    q, _ = saturation(np.array([253.15, 233.15]), pressure, True)
    vapour = q * pressure / (0.622 + 0.378 * q) / 100
    np.testing.assert_allclose(vapour, [1.032, 0.1283], rtol=2e-2)


def stefan_error(steps):
    """Relative error against h^2 = h0^2 + 2 k (Tf - Ts) t / (rho L) after 30 days."""
    # Wind without end ties the surface to the air: a fixed surface temperature.
    params = replace(PARAMS, ocean_salinity=0.0)
    forcing = weather(
        air_temperature=253.15, specific_humidity=0.0, wind_speed=1e9, ocean_heat_flux=0.0
    )
    end, h0 = 30 * 86400.0, 0.2
    after, _, _ = advance_window(columns(h0), lambda t: forcing, 0.0, end, end / steps, params)
    assert abs(after.surface_temperature[0, 0] - 253.15) < 1e-6
    growth = 2 * params.keys.ice_conductivity * 20.0 * end / params.ice_energy
    return abs(after.ice_volume[0, 0] / np.sqrt(h0**2 + growth) - 1)


def no_vapour(temperature, pressure, ice):
    """Over ice that does not sublimate."""
    return np.zeros_like(temperature), np.zeros_like(temperature)


def test_stefan_growth_converges_at_first_order(monkeypatch):
    monkeypatch.setattr(surface, "saturation", no_vapour)
    errors = [stefan_error(steps) for steps in (60, 120, 240, 480)]
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (rates > 0.95).all() and errors[-1] < 1e-3


def test_equilibrium_thickness():
    """Conduction through ice and snow equals the ocean's heat: k and snow enter as they should."""
    forcing = weather(wind_speed=0.0, longwave_down=170.0, ocean_heat_flux=10.0)
    emitted = PARAMS.keys.emissivity * STEFAN_BOLTZMANN
    surface = ((PARAMS.keys.emissivity * 170.0 + 10.0) / emitted) ** 0.25
    resistance = (PARAMS.freezing_temperature - surface) / 10.0
    h = (resistance - 0.1 / PARAMS.keys.snow_conductivity) * PARAMS.keys.ice_conductivity
    state = columns(h, 0.1)
    after, fluxes = step(state, forcing, 3600.0, PARAMS)
    assert abs(after.ice_volume[0, 0] - h) < 1e-12
    assert abs(after.surface_temperature[0, 0] - surface) < 1e-7


def test_warm_air_melts_snow_before_ice():
    forcing = weather(air_temperature=278.15, longwave_down=320.0, shortwave_down=200.0)
    state = columns([2.0, 2.0], [0.3, 0.0], temperature=273.15)
    two = ColumnForcing(**{f.name: np.repeat(getattr(forcing, f.name), 2) for f in fields(forcing)})
    after, fluxes = step(state, two, 3600.0, PARAMS)
    assert fluxes.snow_melt[0, 0] > 0 and fluxes.melt_top[0, 0] == 0
    assert fluxes.snow_melt[1, 0] == 0 and fluxes.melt_top[1, 0] > 0
    assert (after.surface_temperature == PARAMS.melting_temperature).all()


def test_thin_ice_under_sun_vanishes_and_leaves_zeros():
    forcing = weather(3, air_temperature=280.0, shortwave_down=500.0, longwave_down=320.0)
    state = columns([1e-6, 1e-3, 1e-3], [0.0, 0.0, 0.05], 0.4)
    after, fluxes = step(state, forcing, 86400.0, PARAMS)
    check(state, after, fluxes, 86400.0)
    assert (after.ice_volume == 0).all() and (after.ice_fraction == 0).all()
    assert (fluxes.energy_to_ocean > 0).all()


def test_snow_on_nothing_goes_to_the_sea():
    state = ColumnState(*(np.array([[v]]) for v in (0.5, 0.0, 0.2, 260.0)))
    forcing = weather(air_temperature=276.0, longwave_down=330.0, specific_humidity=4e-3)
    after, fluxes = step(state, forcing, 60.0, PARAMS)
    check(state, after, fluxes, 60.0)
    assert fluxes.snow_melt[0, 0] == 0.2 and after.ice_fraction[0, 0] == 0


def test_lead_freezes_at_new_ice_thickness():
    forcing = weather()
    state = columns(2.0, 0.1, 0.9)
    after, fluxes = step(state, forcing, 3600.0, PARAMS)
    born = fluxes.new_ice[0, 0]
    assert born > 0
    assert after.ice_fraction[0, 0] - 0.9 == pytest.approx(born / PARAMS.new_ice_thickness)
    closed, _ = step(state, forcing, 40 * 86400.0, PARAMS)
    assert closed.ice_fraction[0, 0] == 1.0


def test_lead_in_sun_melts_the_sides_at_constant_thickness():
    forcing = weather(air_temperature=271.0, shortwave_down=300.0, longwave_down=250.0)
    state = columns(2.0, 0.1, 0.5, 265.0)
    after, fluxes = step(state, forcing, 3600.0, PARAMS)
    check(state, after, fluxes, 3600.0)
    assert fluxes.melt_lateral[0, 0] > 0 and after.ice_fraction[0, 0] < 0.5
    kept = 1.0 + (fluxes.growth_base - fluxes.melt_base - fluxes.melt_top - fluxes.sublimation_ice)
    thickness = after.ice_volume / after.ice_fraction
    np.testing.assert_allclose(thickness, kept / 0.5, rtol=1e-14)


def test_slices_give_the_same_bits():
    rng = np.random.default_rng(3)
    state = columns(rng.uniform(0, 4, 50), rng.uniform(0, 0.5, 50), rng.uniform(0, 1, 50))
    values = {f.name: getattr(weather(50), f.name) for f in fields(ColumnForcing)}
    values["air_temperature"] = rng.uniform(230, 280, 50)
    whole, _ = step(state, ColumnForcing(**values), 3600.0, PARAMS)
    for part in (slice(0, 17), slice(17, 50)):
        own = ColumnForcing(**{k: v[part] for k, v in values.items()})
        piece, _ = step(take(state, part), own, 3600.0, PARAMS)
        for f in fields(piece):
            np.testing.assert_array_equal(getattr(piece, f.name), getattr(whole, f.name)[part])


def test_ice_without_area_is_refused():
    state = ColumnState(*(np.array([[v]]) for v in (0.0, 1.0, 0.0, 260.0)))
    with pytest.raises(FloeError, match="element 0 has ice without area"):
        step(state, weather(), 3600.0, PARAMS)


def test_a_rank_without_elements_has_nothing_to_do():
    forcing = weather(0)
    after, fluxes = step(columns([]), forcing, 3600.0, PARAMS)
    assert after.ice_volume.shape == (0, 1) and fluxes.energy_ocean.shape == (0,)
