# SPDX-License-Identifier: GPL-2.0-or-later
"""Sampling of gridded forcing, and the window that steps through it."""

from dataclasses import fields

import numpy as np
import pytest
import xarray as xr

from floeflow.column.forcing import sample_series
from floeflow.column.params import ColumnParams, Settings
from floeflow.column.schemes import advance_columns
from floeflow.column.state import ColumnState, energy_residual
from floeflow.column.window import advance_window
from floeflow.column.zero_layer_run import column_forcing
from floeflow.core.errors import FloeError
from floeflow.scene.effects import column_forcing_variables

X = np.array([0.0, 1e5, 2e5, 3e5])
Y = np.array([-1e5, 0.0, 1e5])
T = np.array([0.0, 21600.0, 43200.0])
TYPICAL = {
    "wind_u": 3.0,
    "wind_v": 4.0,
    "air_temperature": 250.0,
    "specific_humidity": 4e-4,
    "shortwave_down": 0.0,
    "longwave_down": 180.0,
    "snowfall": 1e-6,
    "air_pressure": 1.01e5,
    "ocean_heat_flux": 2.0,
}


COLUMN_VARIABLES = column_forcing_variables(("thermodynamics", "snow", "shortwave"))


def column_sampler(data, x, y):
    series = sample_series(data, COLUMN_VARIABLES, x, y)
    return lambda t: column_forcing(series(t), len(x))


def forcing_data(**replaced):
    shape = (len(T), len(Y), len(X))
    values = {**TYPICAL, **replaced}
    data = {
        name: (("time", "y", "x"), np.broadcast_to(np.asarray(v, float), shape).copy())
        for name, v in values.items()
    }
    return xr.Dataset(data, coords={"time": T, "y": Y, "x": X})


def test_bilinear_in_space_and_linear_in_time():
    t, y, x = np.meshgrid(T, Y, X, indexing="ij")
    plane = 2 + 3e-5 * x - 1e-5 * y + 1e-10 * x * y + 1e-4 * t
    rng = np.random.default_rng(0)
    px, py = rng.uniform(0, 3e5, 40), rng.uniform(-1e5, 1e5, 40)
    series = sample_series(forcing_data(wind_u=plane), ["wind_u"], px, py)
    for time in (0.0, 1000.0, 21600.0, 30000.0, 43200.0, 5.0):
        expected = 2 + 3e-5 * px - 1e-5 * py + 1e-10 * px * py + 1e-4 * time
        np.testing.assert_allclose(series(time)["wind_u"], expected, rtol=1e-13)


def test_edge_value_holds_outside():
    t, y, x = np.meshgrid(T, Y, X, indexing="ij")
    far = np.array([-5e4, 9e6]), np.array([1.4e5, -3e6])
    series = sample_series(forcing_data(wind_u=x), ["wind_u"], *far)
    np.testing.assert_array_equal(series(0.0)["wind_u"], [0.0, 3e5])


def test_speed_of_the_wind():
    sample = column_sampler(forcing_data(), np.array([1.0]), np.array([2.0]))
    assert sample(100.0).wind_speed[0] == pytest.approx(5.0, rel=1e-15)


def test_gaps_are_named_only_where_they_are_used():
    hole = np.full((len(T), len(Y), len(X)), 250.0)
    hole[1, 2, 3] = np.nan
    data = forcing_data(air_temperature=hole)
    away = sample_series(data, ["air_temperature"], np.array([2e5]), np.array([0.0]))
    assert away(30000.0)["air_temperature"][0] == 250.0
    near = sample_series(data, ["air_temperature"], np.array([2.5e5]), np.array([5e4]))
    with pytest.raises(FloeError, match="air_temperature is not finite at 21600 s near x = 250000"):
        near(30000.0)


def test_bad_input_is_named():
    data = forcing_data()
    place = np.array([1e5]), np.array([0.0])
    with pytest.raises(FloeError, match="'wind_u' is missing"):
        sample_series(data.drop_vars("wind_u"), COLUMN_VARIABLES, *place)
    with pytest.raises(FloeError, match="axis 'x'"):
        sample_series(data.isel(x=slice(None, None, -1)), COLUMN_VARIABLES, *place)
    with pytest.raises(FloeError, match="covers 0 s to 43200 s"):
        sample_series(data, COLUMN_VARIABLES, *place)(50000.0)


def some_state(n=6):
    h = np.linspace(0.0, 3.0, n)[:, None]
    return ColumnState(np.where(h > 0, 0.9, 0.0), 0.9 * h, 0.1 * h, np.full((n, 1), 260.0))


def test_window_sums_its_steps_and_keeps_the_budget():
    state, params = some_state(), ColumnParams()
    warming = 250.0 + np.linspace(0, 30, 3)[:, None, None]
    data = forcing_data(air_temperature=warming)
    sample = column_sampler(data, np.linspace(0, 3e5, 6), np.zeros(6))
    after, _, fluxes = advance_window(state, sample, 0.0, 43200.0, 3600.0, params)
    assert np.abs(energy_residual(state, after, fluxes, params)).max() < 1e-8 * 43200
    half, _, first = advance_window(state, sample, 0.0, 21600.0, 3600.0, params)
    again, _, second = advance_window(half, sample, 21600.0, 43200.0, 3600.0, params)
    for f in fields(after):
        np.testing.assert_array_equal(getattr(again, f.name), getattr(after, f.name))
    np.testing.assert_allclose(
        first.growth_base + second.growth_base, fluxes.growth_base, rtol=1e-13
    )


@pytest.mark.parametrize(("end", "longest", "steps"), [(86400.0, 3600.0, 24), (100.0, 60.0, 2)])
def test_equal_steps(end, longest, steps):
    inside = column_sampler(forcing_data(), np.zeros(6), np.zeros(6))
    times = []

    def sample(t):
        times.append(t)
        return inside(0.0)

    advance_window(some_state(), sample, 0.0, end, longest, ColumnParams())
    np.testing.assert_allclose(times, (np.arange(steps) + 0.5) * end / steps)


def test_unknown_scheme_and_empty_window():
    sample = column_sampler(forcing_data(), np.zeros(6), np.zeros(6))
    with pytest.raises(FloeError, match="unknown scheme 'two_layer'"):
        advance_columns({}, sample, (0.0, 1.0), Settings(scheme="two_layer"))
    with pytest.raises(FloeError, match="no steps of"):
        advance_window(some_state(), sample, 5.0, 5.0, 1.0, ColumnParams())
