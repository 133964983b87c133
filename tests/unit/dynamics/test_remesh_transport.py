# SPDX-License-Identifier: GPL-2.0-or-later
"""Amounts along the pieces: totals, bounds, constants, whatever the overlap."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from floeflow.dynamics.remesh.overlap import Pieces
from floeflow.dynamics.remesh.transport import amounts, sequence, transport, values_of
from floeflow.state.schema import VARIABLES, Variable

LAYERED = {
    "ice_heat": Variable(
        ("element", "category", "layer"),
        "float64",
        "J m-3",
        "heat",
        -3e8,
        0,
        "intensive",
        "ice_volume",
    ),
    "sea_heat": Variable(("element",), "float64", "K", "sea", 0, 300, "intensive", "area"),
}
RULES = {**VARIABLES, **LAYERED}


def any_pieces(seed: int, n: int, m: int) -> tuple[Pieces, np.ndarray]:
    """Random overlap of n old with m fresh elements, and the centres of the old."""
    random = np.random.default_rng(seed)
    count = random.integers(1, min(m, 5) + 1, n)
    source = np.repeat(np.arange(n), count)
    target = np.concatenate([np.sort(random.choice(m, c, replace=False)) for c in count])
    area = random.exponential(1e8, len(source)) * random.choice([1e-8, 1.0], len(source))
    x, y = random.normal(scale=1e4, size=(2, len(source)))
    return Pieces(source, target, area, x, y, n, m), random.normal(scale=1e4, size=(n, 2))


def any_columns(seed: int, pieces: Pieces, cats: int = 3) -> dict[str, np.ndarray]:
    """Columns with missing categories, columns without ice, layers and a sea."""
    random = np.random.default_rng(seed + 1)
    n = pieces.sources
    fraction = random.dirichlet(np.ones(cats + 1), n)[:, :cats] * random.integers(0, 2, (n, cats))
    volume = fraction * random.exponential(1.0, (n, cats))
    return {
        "area": np.bincount(pieces.source, weights=pieces.area, minlength=n),
        "ice_fraction": fraction,
        "ice_volume": volume,
        "snow_volume": fraction * random.exponential(0.2, (n, cats)),
        "surface_temperature": random.uniform(230, 273, (n, cats)),
        "ice_heat": random.uniform(-3e8, -1e8, (n, cats, 4)),
        "sea_heat": random.uniform(271, 275, n),
        "u": random.normal(size=n),
        "v": random.normal(size=n),
        "omega": random.normal(size=n),
    }


@given(st.integers(0, 10**6), st.integers(1, 12), st.integers(1, 12), st.booleans())
@settings(max_examples=60)
def test_totals_and_bounds(seed: int, n: int, m: int, slopes: bool) -> None:
    pieces, centre = any_pieces(seed, n, m)
    values = any_columns(seed, pieces)
    before = amounts(values, RULES)
    arrived = transport(values, centre, pieces, RULES, slopes)
    for name, amount in arrived.items():
        scale = np.abs(before[name]).sum(axis=0)
        np.testing.assert_allclose(
            amount.sum(axis=0), before[name].sum(axis=0), rtol=0, atol=1e-13 * scale.max() + 1e-300
        )
    total = arrived["ice_fraction"].sum(axis=1)
    assert (total <= arrived["area"] * (1 + 1e-14)).all() and (arrived["ice_fraction"] >= 0).all()
    for name, parent in (("ice_volume", "ice_fraction"), ("ice_heat", "ice_volume"), ("u", "mass")):
        _within_sources(name, parent, before, arrived, pieces)


def _within_sources(name, parent, before, arrived, pieces) -> None:
    def ratio(found):
        per = found[parent].reshape(
            found[parent].shape + (1,) * (found[name].ndim - found[parent].ndim)
        )
        per = np.broadcast_to(per, found[name].shape)
        return np.divide(found[name], per, out=np.full(per.shape, np.nan), where=per > 0)

    old, new = ratio(before), ratio(arrived)
    for j in range(pieces.targets):
        sources = old[pieces.source[pieces.target == j]]
        if len(sources) and np.isfinite(sources).any():
            size = 1e-12 * np.nanmax(np.abs(sources))
            low, high = (
                np.nanmin(sources, axis=0, initial=np.inf),
                np.nanmax(sources, axis=0, initial=-np.inf),
            )
            there = np.isfinite(new[j])
            assert (new[j] <= high + size)[there].all() and (new[j] >= low - size)[there].all()


def test_a_constant_stays_constant() -> None:
    pieces, centre = any_pieces(5, 9, 7)
    values = any_columns(5, pieces)
    values["ice_fraction"] = np.full((9, 3), 0.3)
    values["ice_volume"] = np.full((9, 3), 0.6)
    values["u"] = np.full(9, 0.25)
    arrived = transport(values, centre, pieces, RULES)
    fill = {name: np.zeros_like(amount) for name, amount in arrived.items()}
    fresh = values_of(arrived, arrived["area"], fill, RULES)
    there = arrived["area"] > 0
    for name, constant in (("ice_fraction", 0.3), ("ice_volume", 0.6), ("u", 0.25)):
        np.testing.assert_allclose(fresh[name][there], constant, rtol=1e-13)


def test_parents_come_before_what_sits_on_them() -> None:
    order = sequence(set(RULES) - {"drift_x", "drift_y"}, RULES)
    for name in order:
        for parent in (RULES[name].of, RULES[name].per):
            assert parent in ("", "mass") or order.index(parent) < order.index(name)
    assert set(order[-3:]) == {"u", "v", "omega"}


def test_gap_water_dilutes_ice_and_keeps_the_sea() -> None:
    arrived = {
        "area": np.array([1.0]),
        "ice_fraction": np.array([[0.8]]),
        "ice_volume": np.array([[1.6]]),
        "sea_heat": np.array([272.0]),
    }
    fill = {name: np.zeros_like(amount) for name, amount in arrived.items()}
    fresh = values_of(arrived, np.array([2.0]), fill, RULES)
    assert fresh["ice_fraction"][0, 0] == pytest.approx(0.4)
    assert fresh["ice_volume"][0, 0] == pytest.approx(0.8)
    assert fresh["sea_heat"][0] == pytest.approx(272.0)
