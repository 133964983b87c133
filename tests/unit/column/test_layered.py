# SPDX-License-Identifier: GPL-2.0-or-later
"""Parts of the layered column: enthalpy, fluxes, light, layers, categories, refusals."""

import math
from typing import Any, NamedTuple

import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from floeflow.column.layered import LayeredState, pack_forcing, step
from floeflow.column.ocean.ocean import heat_to_ice as compiled_heat_to_ice
from floeflow.column.ocean.ocean import limit as compiled_limit
from floeflow.column.physics import Physics, as_records
from floeflow.column.records import FORCING, SUMS, level_shares
from floeflow.column.shortwave.ccsm3 import absorb as compiled_absorb
from floeflow.column.thermodynamics import boundary_layer as b
from floeflow.column.thermodynamics import enthalpy as e
from floeflow.column.thermodynamics.boundary_layer import Air, SurfaceForcing
from floeflow.column.thermodynamics.layers import even_out as compiled_even_out
from floeflow.column.thermodynamics.profile import new_profile
from floeflow.column.thickness.categories import category_bounds
from floeflow.column.thickness.categories import fit_line as compiled_fit_line
from floeflow.core.errors import FloeError

P = Physics()


def from_python(function: Any) -> Any:
    """Function that only compiled functions can call, for Python."""

    @numba.njit
    def run(*arguments):  # type: ignore[no-untyped-def]
        return function(*arguments)

    return run


absorb = from_python(compiled_absorb)
even_out = from_python(compiled_even_out)
fit_line = from_python(compiled_fit_line)
heat_to_ice = from_python(compiled_heat_to_ice)
ice_temperature = from_python(e.ice_temperature)
limit = from_python(compiled_limit)
surface_balance = from_python(b.surface_balance)
transfer = from_python(b.transfer)
MELTING = -P.melting_slope * e.salinity_profile(7, P)


@given(st.floats(0.0, 3.5), st.floats(-9.0, 1.7))
def test_temperature_and_enthalpy_are_inverse(salinity: float, below: float) -> None:
    melting = -P.melting_slope * salinity
    temperature = melting - 10.0**below
    energy = e.ice_enthalpy.py_func(temperature, melting, P)
    back = ice_temperature(energy, melting, P)
    # Next to melting a digit of enthalpy is many of temperature; far below it is the reverse.
    assert back == pytest.approx(temperature, rel=1e-12, abs=2e-13)
    assert ice_temperature(0.5 * energy if melting == 0 else 0.0, melting, P) <= melting


def test_enthalpy_at_melting_is_that_of_its_brine() -> None:
    melting = MELTING[-1]
    assert e.ice_enthalpy.py_func(melting, melting, P) == pytest.approx(
        P.ice_density * P.heat_water * melting
    )


def test_salinity_profile_and_bounds_are_those_of_the_reference() -> None:
    recorded = [0.27346241415658046, 1.3545142186206514, 2.2689049362399745, 2.796196999970741]
    assert e.salinity_profile(7, P)[:4] == pytest.approx(recorded, rel=1e-14)
    assert (e.salinity_profile(5, P._replace(bottom_salinity=0.0)) == 0.0).all()
    five = [0.0, 0.6445072168194258, 1.3914334975763036, 2.4701793819598885, 4.567287918850491]
    assert category_bounds(5)[:5] == pytest.approx(five, rel=1e-14)
    assert category_bounds(1)[0] == 0.1
    assert (np.diff(category_bounds(12)) > 0.0).all()


def test_exchange_is_neutral_without_contrast_and_weaker_in_stable_air() -> None:
    saturated = P.vapour_ice * math.exp(-P.vapour_ice_exponent / 263.15) / 1.3
    same = Air(263.15, saturated, 1.3, 8.0, 0.0)
    neutral = (P.karman / math.log(P.reference_height / P.ice_roughness)) ** 2
    sensible, latent = transfer(-10.0, same, False, P)
    moist = P.heat_air + (P.heat_vapour - P.heat_air) * saturated
    # The stable function is 0.025 and not zero at z/L = 0, half a percent of the coefficients.
    assert sensible == pytest.approx(1.3 * 8.0 * neutral * moist + P.windless, rel=6e-3)
    assert latent == pytest.approx(1.3 * 8.0 * neutral * (P.vapour + P.fusion), rel=6e-3)
    warm = transfer(-10.0, same._replace(potential_temperature=270.0), False, P)
    cold = transfer(-10.0, same._replace(potential_temperature=258.0), False, P)
    assert warm[0] < 0.95 * sensible < 1.05 * sensible < cold[0]
    calm = transfer(-10.0, same._replace(wind=0.0), False, P)
    assert calm == transfer(-10.0, same._replace(wind=P.least_wind), False, P)


@given(st.floats(-60.0, 0.0))
def test_slope_of_the_surface_balance_is_its_derivative(temperature: float) -> None:
    forcing = SurfaceForcing(10.0, Air(255.0, 1e-3, 1.3, 5.0, 200.0), 12.0, 3e4)
    step_size = 1e-3
    high = surface_balance(temperature + step_size, forcing, P)
    low = surface_balance(temperature - step_size, forcing, P)
    _, slope, _, latent_slope = surface_balance(temperature, forcing, P)
    assert (high[0] - low[0]) / (2 * step_size) == pytest.approx(slope, rel=1e-6)
    assert (high[2] - low[2]) / (2 * step_size) == pytest.approx(latent_slope, rel=1e-5)


def test_light_is_shared_out_whole() -> None:
    source = np.empty(8)
    for thickness in (0.05, 0.3, 3.0):
        for snow in (0.0, 0.01, 0.5):
            surface, through = absorb(thickness, snow, -0.4, 100.0, 80.0, source, 1, P)
            assert source[0] == 0.0 and (source[1:] > 0.0).all()
            assert 0.0 < through < surface < 180.0
            fade = math.exp(-P.extinction * thickness)
            assert through == pytest.approx(source.sum() * fade / (1.0 - fade), rel=1e-9)
    bare, _ = absorb(3.0, 0.0, -5.0, 100.0, 80.0, source, 1, P)
    # Cold thick bare ice: albedos 0.78 and 0.36, seven tenths of the visible enter.
    assert bare == pytest.approx(100.0 * 0.22 * 0.3 + 80.0 * 0.64)
    assert absorb(3.0, 0.0, -5.0, 0.0, 0.0, source, 1, P) == (0.0, 0.0)
    assert (source == 0.0).all()


@given(st.lists(st.floats(0.0, 2.0), min_size=7, max_size=7), st.integers(0, 999))
def test_equal_layers_keep_energy(thickness: list[float], seed: int) -> None:
    w = new_profile(e.salinity_profile(7, P), 1, as_records(P))
    w.thickness[1:] = thickness
    w.enthalpy[1:] = np.random.default_rng(seed).uniform(-3.5e8, -1e8, 7)
    before = float((w.thickness * w.enthalpy).sum())
    low, high = w.enthalpy[1:].min(), w.enthalpy[1:].max()
    total = even_out(w, 1, 8, False)
    assert total == pytest.approx(sum(thickness), rel=1e-14, abs=1e-300)
    assert float((w.thickness * w.enthalpy).sum()) == pytest.approx(before, rel=1e-14, abs=1e-300)
    if total > 0.0:
        assert np.ptp(w.thickness[1:]) == 0.0
        assert (w.enthalpy[1:] >= low * (1 + 1e-12)).all()
        assert (w.enthalpy[1:] <= high * (1 - 1e-12)).all()


@given(st.floats(0.01, 1.0), st.floats(0.0, 1.0))
def test_line_holds_area_and_volume(area: float, place: float) -> None:
    low, high = 0.6, 1.4
    thickness = low + (high - low) * (0.02 + 0.96 * place)
    g0, g1, left, right = fit_line(area, thickness, low, high)
    width = right - left
    assert low - 1e-12 <= left < right <= high + 1e-12
    assert g0 * width + g1 * width**2 / 2 == pytest.approx(area, rel=1e-9)
    moment = g0 * width**2 / 2 + g1 * width**3 / 3 + left * area
    assert moment == pytest.approx(area * thickness, rel=1e-9)
    assert min(g0, g0 + g1 * width) >= -1e-9 * area / width
    assert fit_line(0.0, thickness, low, high) == (0.0, 0.0, 0.0, 0.0)


def test_the_ocean_gives_no_more_than_its_potential() -> None:
    assert heat_to_ice(-1.0, -1.836, 0.0, 0.01, 3600.0, P) == (0.0, 0.0)
    bottom, side = heat_to_ice(-1.0, -1.836, -50.0, 0.01, 3600.0, P)
    assert bottom == 50.0 and 0.0 < side < 1e-3
    stored = -5e8
    bottom, side = limit(bottom, side, stored, -50.0, 3600.0)
    assert bottom - side * stored / 3600.0 == pytest.approx(50.0)
    assert limit(3.0, 0.0, stored, -50.0, 3600.0) == (3.0, 0.0)


def cell(n: int = 2, categories: int = 2) -> LayeredState:
    shape = (n, categories)
    return LayeredState(
        np.full(shape, 0.4), np.full(shape, 0.2) * [1.0, 2.0], np.zeros(shape),
        np.full(shape, -5.0), np.full((*shape, 7), -3e8), np.full((*shape, 1), -1.1e8),
        np.full((*shape, 7), 2.0), np.full(n, -1.8), np.zeros(n),
    )  # fmt: skip


def weather(n: int = 2) -> dict[str, np.ndarray]:
    values = dict.fromkeys(FORCING, np.zeros(n))
    values |= {
        "potential_temperature": np.full(n, 250.0),
        "density": np.full(n, 1.3),
        "longwave": np.full(n, 180.0),
        "sea_salinity": np.full(n, 34.0),
        "mixed_depth": np.full(n, 20.0),
    }
    return values


def test_steps_in_one_call_are_single_steps() -> None:
    forcing, bounds = pack_forcing(weather(), 5, 2), category_bounds(2)
    state = start = cell()
    together, sums = step(start, forcing, 1800.0, bounds, P)
    for k in range(5):
        state, _ = step(state, forcing[k : k + 1], 1800.0, bounds, P)
    for name in LayeredState.__dataclass_fields__:
        assert np.array_equal(getattr(state, name), getattr(together, name)), name
        assert np.array_equal(getattr(start, name), getattr(cell(), name)), name
    assert set(sums) == set(SUMS) and (sums["growth"] > 0.0).all()


def test_bad_forcing_and_shapes_are_refused() -> None:
    values = weather()
    values["wind"] = np.array([1.0, np.nan])
    with pytest.raises(FloeError, match="wind is not finite in step 0 of element 1"):
        pack_forcing(values, 1, 2)
    del values["wind"]
    with pytest.raises(FloeError, match="'wind' is missing"):
        pack_forcing(values, 1, 2)
    with pytest.raises(FloeError, match="do not fit 2 elements of 2 categories"):
        step(cell(), pack_forcing(weather(), 1, 2), 60.0, category_bounds(5), P)


class Shares(NamedTuple):
    """What of a column `level_shares` reads and sets."""

    area: np.ndarray
    ice: np.ndarray
    level: np.ndarray


def test_level_shares_stay_shares_whatever_round_off_leaves():
    """A category gives nearly all away: what is left is a difference of large amounts."""
    column = Shares(np.array([1e-9]), np.array([1e-13]), np.ones((1, 7)))
    amounts = np.zeros(7)
    amounts[:5] = 1e-9 * (1 + 1e-11), 1e-13 * (1 + 1e-11), -1e-27, 0.0, 0.0
    from_python(level_shares)(column, 0, amounts)
    np.testing.assert_array_equal(column.level[0, :5], [1.0, 1.0, 0.0, 0.0, 0.0])
