# SPDX-License-Identifier: GPL-2.0-or-later
"""Redistribution: area, volume, energy and salt to round-off; the functions against integrals."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from floeflow.column.initial_columns import first_columns
from floeflow.column.params import Settings
from floeflow.column.schemes import SCHEMES, scheme_of
from floeflow.column.thickness.categories import category_bounds
from floeflow.column.thickness.redistribution import (
    PARTICIPATION,
    SNOW_KEPT,
    participation,
    redistribute,
    ridge_shape,
    ridge_shares,
)
from floeflow.column.thickness.ridging_closure import close_columns


def draw(seed: int, n: int, categories: int) -> dict[str, np.ndarray]:
    """Columns of any thickness distribution, with empty categories and without open water too."""
    rng = np.random.default_rng(seed)
    bounds = category_bounds(categories)
    area = rng.dirichlet(np.full(categories + 1, 0.5), n)
    area[rng.random(area.shape) < 0.3] = 0.0
    area = area[:, 1:] / np.maximum(area.sum(axis=1, keepdims=True), 1e-300)
    shape = area.shape
    low, high = np.maximum(bounds[:-1], 1e-4), np.minimum(bounds[1:], 20.0)
    layers = (*shape, 3)
    return {
        "ice_fraction": area,
        "ice_volume": area * rng.uniform(low, high, shape),
        "snow_volume": area * rng.uniform(0.0, 1.0, shape),
        "surface_temperature": rng.uniform(230.0, 273.0, shape),
        "ice_enthalpy": -rng.uniform(1e8, 4e8, layers),
        "ice_salinity": rng.uniform(0.0, 30.0, layers),
        "snow_enthalpy": -rng.uniform(1.1e8, 1.3e8, (*shape, 1)),
    }


@settings(deadline=None, derandomize=True, max_examples=60)
@given(
    st.integers(0, 2**32 - 1),
    st.integers(2, 8),
    st.sampled_from([0.0, 1e-9, 1e-3, 0.1, 0.5, 0.95]),
)
def test_anything_that_is_closed_conserves(seed, categories, most):
    before = draw(seed, 20, categories)
    closed = most * np.random.default_rng(seed + 1).random(20)
    after = (ridged := redistribute(before, closed, category_bounds(categories))).columns
    kept = 1.0 - closed
    assert (after["ice_fraction"] >= 0).all() and (after["ice_volume"] >= 0).all()
    assert (after["ice_fraction"].sum(axis=1) <= 1.0 + 1e-14).all()
    # Ice never takes more area than before, and never less than the closing asks for.
    left = after["ice_fraction"].sum(axis=1) * kept
    assert (left <= before["ice_fraction"].sum(axis=1) + 1e-14).all()
    volume = before["ice_volume"].sum(axis=1)
    np.testing.assert_allclose(after["ice_volume"].sum(axis=1) * kept, volume, rtol=1e-13)
    snow = (after["snow_volume"].sum(axis=1) + ridged.snow_lost) * kept
    np.testing.assert_allclose(snow, before["snow_volume"].sum(axis=1), rtol=1e-13, atol=1e-300)
    for name in ("ice_enthalpy", "ice_salinity"):
        start = (before[name] * before["ice_volume"][..., None]).sum(axis=1)
        end = (after[name] * after["ice_volume"][..., None]).sum(axis=1) * kept[:, None]
        np.testing.assert_allclose(end, start, rtol=1e-13, atol=1e-300)
    start = (before["snow_enthalpy"][..., 0] * before["snow_volume"]).sum(axis=1)
    end = (after["snow_enthalpy"][..., 0] * after["snow_volume"]).sum(axis=1) + ridged.snow_energy
    np.testing.assert_allclose(end * kept, start, rtol=1e-13, atol=1e-300)
    # Properties stay within those that there were.
    for name in ("surface_temperature", "ice_enthalpy", "ice_salinity"):
        there = after["ice_volume"] > 1e-12
        slack = 1e-9 * np.abs(before[name]).max()
        assert (after[name][there] >= before[name].min() - slack).all()
        assert (after[name][there] <= before[name].max() + slack).all()
    assert not ridged.forced.any()


def test_nothing_closed_changes_nothing():
    before = draw(4, 30, 5)
    after = redistribute(before, np.zeros(30), category_bounds(5)).columns
    for name in ("ice_fraction", "ice_volume", "snow_volume"):
        np.testing.assert_allclose(after[name], before[name], rtol=1e-15)


def test_open_water_closes_before_ice_ridges():
    thick = {
        "ice_fraction": np.array([[0.0, 0.0, 0.5, 0.0, 0.0]]),
        "ice_volume": np.array([[0.0, 0.0, 1.0, 0.0, 0.0]]),
        "surface_temperature": np.full((1, 5), 250.0),
    }
    after = redistribute(thick, np.array([0.3]), category_bounds(5)).columns
    # G is 0.5 where the ice begins: e^(-10) of the participation is left for it.
    assert after["ice_fraction"].sum() * 0.7 == pytest.approx(0.5, abs=2e-5)
    # Without open water all of it is ridged, into ice of twice the thickness and more.
    after = redistribute(thick, np.array([0.7]), category_bounds(5)).columns
    assert after["ice_fraction"].sum() == pytest.approx(1.0, abs=1e-13)
    assert (after["ice_volume"].sum() * 0.3) == pytest.approx(1.0, rel=1e-14)
    assert after["ice_fraction"][0, 3:].sum() > 0.2


def test_participation_is_the_integral_of_its_density():
    area = np.array([[0.02, 0.01, 0.0, 0.5, 0.47], [0.0, 1e-12, 0.3, 0.3, 0.4]])
    part = participation(area, area.sum(axis=1))
    np.testing.assert_allclose(part.sum(axis=1), 1.0, rtol=1e-14)
    whole = PARTICIPATION * (1.0 - np.exp(-1.0 / PARTICIPATION))
    edges = np.concatenate([[0.0], np.cumsum(area[0]) / area[0].sum()])
    for n, (low, high) in enumerate(zip(edges[:-1], edges[1:], strict=True)):
        exact, _ = quad(lambda g: np.exp(-g / PARTICIPATION) / whole, low, high, epsabs=1e-14)
        assert part[0, n] == pytest.approx(exact, abs=1e-13)
    # A sliver keeps its digits.
    assert part[1, 1] == pytest.approx(1e-12 / whole, rel=1e-6)


def test_mean_participation_is_that_of_thorndike():
    # Lipscomb et al. (2007): e-folding 0.05 has the mean G of the linear function with G* = 0.15.
    area = np.full((1, 20000), 1.0 / 20000)
    part = participation(area, np.ones(1))[0]
    middles = (np.arange(20000) + 0.5) / 20000
    assert float(part @ middles) == pytest.approx(0.15 / 3.0, rel=1e-4)


@pytest.mark.parametrize("thickness", [0.05, 0.3, 1.0, 3.0])
def test_ridges_are_exponential(thickness):
    bounds = category_bounds(5)
    area, volume = ridge_shares(np.array([[thickness]]), bounds)
    least, scale = (float(each) for each in ridge_shape(np.array(thickness)))
    for m in range(5):
        low, high = max(bounds[m], least), max(bounds[m + 1], least)
        if m == 4:
            high = least + 60.0 * scale
        density = [quad(f, low, high, epsabs=1e-13)[0] for f in (
            lambda h: np.exp(-(h - least) / scale) / scale,
            lambda h: h * np.exp(-(h - least) / scale) / scale / (least + scale),
        )]  # fmt: skip
        assert area[0, 0, m] == pytest.approx(density[0], abs=1e-10)
        assert volume[0, 0, m] == pytest.approx(density[1], abs=1e-10)


@pytest.mark.parametrize("sea", [True, False])
@pytest.mark.parametrize("scheme", SCHEMES)
def test_the_sea_pays_for_the_snow_that_falls_in(scheme, sea):
    processes = ("snow", "mixed_layer") if sea else ("snow",)
    asked = Settings(scheme=scheme, categories=5, processes=processes)
    a, h = np.array([1.0, 0.9]), np.array([1.2, 0.4])
    columns = first_columns(a, a * h, np.full(2, 0.3), 255.0, asked)
    if not sea:
        columns = {k: v for k, v in columns.items() if k not in ("sea_temperature",)}
    closed = np.array([0.2, 0.3])
    # What ridging hands over: volumes per area that is left, fractions as they were.
    for name in ("ice_volume", "snow_volume"):
        columns[name] = columns[name] / (1.0 - closed)[:, None]
    after, terms = close_columns(columns, closed, asked)
    assert (terms["snow_ridging"] < 0).all()
    ice = columns["ice_volume"].sum(axis=1)
    np.testing.assert_allclose(after["ice_volume"].sum(axis=1), ice, rtol=1e-14)
    kept = scheme_of(asked).stored
    gained = kept(after, asked)["energy"] - kept(columns, asked)["energy"]
    paid = terms.get("energy_ridging", np.zeros(2))
    # The last digit of the sea's temperature is 5e-6 J/m2.
    np.testing.assert_allclose(gained, paid, atol=2e-5)
    assert ("energy_ridging" in terms) != sea
    water = kept(after, asked)["water"] - kept(columns, asked)["water"]
    np.testing.assert_allclose(water, terms["water_ridging"], atol=1e-10)
    snow = columns["snow_volume"].sum(axis=1)
    assert (-terms["snow_ridging"] < (1 - SNOW_KEPT) * snow).all()
