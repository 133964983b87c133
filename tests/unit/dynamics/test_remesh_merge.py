# SPDX-License-Identifier: GPL-2.0-or-later
"""Merging: what is conserved, and bonds and contacts that pass to the merged element."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from mpi4py import MPI

from floeflow.dynamics.engine.engine import Engine
from floeflow.dynamics.remesh.merge import merge, merge_targets
from floeflow.dynamics.ridging.ridging import contact_share
from floeflow.state.elements import element_arrays, joint_thickness, pair_arrays
from floeflow.state.schema import MOBILE, check_state
from support.full_ice import full_params
from support.rafts import angular_momentum
from support.remesh_cases import coast_case, scales, totals

SHARE = 0.9


@pytest.fixture(scope="module")
def shrunk() -> xr.Dataset:
    """Some elements have lost three quarters of their area."""
    state = coast_case("merge")[0]
    small = np.flatnonzero(state["type"].values == MOBILE)[::4]
    state["radius"].values[small] *= 0.5
    state["area"].values[small] *= 0.25
    state.attrs["unclaimed_water"] = state.attrs["ocean_area"] - float(state["area"].sum())
    state["theta"].values[:] = np.random.default_rng(1).normal(size=state.sizes["element"])
    for side in ("lo", "hi"):
        row = np.searchsorted(state["id"], state[f"bond_id_{side}"])
        cos, sin = np.cos(state["theta"].values[row]), np.sin(state["theta"].values[row])
        for end in "ab":
            x, y = (state[f"bond_{side}_{end}{axis}"].values.copy() for axis in "xy")
            state[f"bond_{side}_{end}x"].values[:] = cos * x + sin * y
            state[f"bond_{side}_{end}y"].values[:] = cos * y - sin * x
    return state


@pytest.fixture(scope="module")
def merged(shrunk: xr.Dataset) -> xr.Dataset:
    return merge(shrunk, merge_targets(shrunk, SHARE))


def lines(state: xr.Dataset, side: str) -> dict[tuple[float, ...], tuple[float, float]]:
    """Ends of the glue lines on one side, in space (km, rounded), in both orders."""
    row = np.searchsorted(state["id"], state[f"bond_id_{side}"])
    cos, sin = np.cos(state["theta"].values[row]), np.sin(state["theta"].values[row])
    ends = []
    for end in "ab":
        x, y = (state[f"bond_{side}_{end}{axis}"].values for axis in "xy")
        ends += [
            state["x"].values[row] + cos * x - sin * y,
            state["y"].values[row] + sin * x + cos * y,
        ]
    return np.round(np.stack(ends, axis=1) / 1e3, 6)


def test_small_elements_go_and_amounts_stay(shrunk: xr.Dataset, merged: xr.Dataset) -> None:
    check_state(merged)
    assert merged.sizes["element"] < shrunk.sizes["element"] - 20
    before, after, scale = totals(shrunk), totals(merged), scales(shrunk)
    for name, value in before.items():
        if name != "omega":
            assert after[name] == pytest.approx(value, abs=1e-12 * scale[name]), name
    first, last = (element_arrays(state, 1e-9) for state in (shrunk, merged))
    spun, size = angular_momentum(first)
    assert angular_momentum(last)[0] == pytest.approx(spun, abs=1e-12 * size)
    disc = [(s["radius"].values ** 2).sum() for s in (shrunk, merged)]
    assert disc[1] == pytest.approx(disc[0], rel=0.1)


def test_each_joins_its_largest_neighbour(shrunk: xr.Dataset) -> None:
    into = merge_targets(shrunk, SHARE)
    radius, area = shrunk["radius"].values, shrunk["area"].values
    mobile = shrunk["type"].values == MOBILE
    moved = np.flatnonzero(into != np.arange(len(into)))
    assert (radius[moved] < SHARE * radius[mobile].mean()).all() and mobile[into[moved]].all()
    assert (area[into[moved]] > area[moved]).all() and (into[into] == into).all()
    assert (merge_targets(shrunk, 1e-6) == np.arange(len(into))).all()
    assert merge(shrunk, np.arange(len(into))) is shrunk


def test_bonds_stay_where_they_are_in_space(shrunk: xr.Dataset, merged: xr.Dataset) -> None:
    assert 0 < merged.sizes["bond"] < shrunk.sizes["bond"]
    known = {tuple(line) for side in ("lo", "hi") for line in lines(shrunk, side).tolist()}
    known |= {(*line[2:], *line[:2]) for line in known}
    for side in ("lo", "hi"):
        for line in lines(merged, side).tolist():
            assert tuple(line) in known


def test_nothing_pushes_that_did_not_before(merged: xr.Dataset, tmp_path: Path) -> None:
    params = full_params(time_step=0.5, bonds=True, ridging=True, compressive_strength=1e5)
    still = element_arrays(merged, 1e-3)
    for name in ("u", "v", "omega"):
        still[name][:] = 0.0
    with Engine(MPI.COMM_SELF, params, tmp_path / "log") as engine:
        engine.load(still, pair_arrays(merged, "bond"), pair_arrays(merged, "contact"))
        assert engine.diagnostics()["bonds"] == merged.sizes["bond"]
        engine.run(2)
        speed = np.hypot(engine.elements()["u"], engine.elements()["v"])
    assert speed.max() < 1e-9


def test_contacts_keep_their_force() -> None:
    state = coast_case("merge")[0]
    mobile = np.flatnonzero(state["type"].values == MOBILE)
    pairs = np.stack([state["bond_id_lo"], state["bond_id_hi"]], axis=1)[:40]
    rows = np.searchsorted(state["id"], pairs)
    place = np.stack([state["x"], state["y"]], axis=1)
    overlap = state["radius"].values[rows].sum(axis=1)
    overlap = overlap - np.hypot(*(place[rows[:, 1]] - place[rows[:, 0]]).T)
    bare = (
        state.copy(deep=True)
        .isel(bond=slice(0, 0))
        .drop_vars([n for n in state if state[n].dims == ("contact",)])
    )
    pressed = 7.0 / contact_share({"thickness": joint_thickness(state)}, *rows.T)
    made = {"id_lo": pairs[:, 0], "id_hi": pairs[:, 1], "slip": np.full(len(pairs), 0.1),
            "rest_overlap": overlap - pressed, "ridge_closing": np.full(len(pairs), 30.0),
            "ridge_thickness": np.ones(len(pairs)),
            "ridge_length": np.full(len(pairs), 2e4)}  # fmt: skip
    for name, values in made.items():
        bare[f"contact_{name}"] = ("contact", values)
    bare["radius"].values[mobile[::4]] *= 0.5
    bare["area"].values[mobile[::4]] *= 0.25
    kept = bare["contact_rest_overlap"].values - overlap
    rows_radius = bare["radius"].values[rows].sum(axis=1) - state["radius"].values[rows].sum(axis=1)
    bare["contact_rest_overlap"].values[:] = overlap + rows_radius + kept
    after = merge(bare, merge_targets(bare, SHARE))
    check_state(after)
    ridged = after["contact_ridge_closing"].values > 0
    a, b = (
        np.searchsorted(after["id"], after[f"contact_id_{e}"].values[ridged]) for e in ("lo", "hi")
    )
    apart = np.hypot(*(after[x].values[b] - after[x].values[a] for x in ("x", "y")))
    elastic = after["radius"].values[a] + after["radius"].values[b] - apart
    elastic -= after["contact_rest_overlap"].values[ridged]
    assert ridged.sum() > 15
    share = contact_share({"thickness": joint_thickness(after)}, a, b)
    np.testing.assert_allclose(elastic * share, 7.0, rtol=1e-6)
