# SPDX-License-Identifier: GPL-2.0-or-later
"""The window boundary after ridging: areas, volumes and forces."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from mpi4py import MPI

from floeflow.dynamics.engine.engine import Engine, EngineParams
from floeflow.dynamics.ridging.ridging import close_areas, contact_share
from floeflow.state.elements import element_arrays, moved_state, pair_arrays
from floeflow.state.schema import check_state, expected_variables
from support.full_ice import full_params
from support.rafts import bonded, lattice
from unit.state.test_state import a_state

EFFECTS = ("friction", "bonds", "ridging", "thermodynamics", "snow")


def ridged_state(log: Path) -> tuple[xr.Dataset, np.ndarray, EngineParams]:
    """A squeezed raft with ridges, broken and whole bonds, open contacts and a coast."""
    raft = lattice(6, 5)
    random = np.random.default_rng(4)
    thickness = random.uniform(0.1, 2.0, 30)
    raft["u"], raft["v"] = -2e-4 * raft["x"] + 1.0, -1e-4 * raft["y"]
    raft["type"][:6] = 2
    raft["u"][:6] = raft["v"][:6] = 0.0
    state = a_state(EFFECTS, n=30).isel(bond=slice(0, 0), contact=slice(0, 0))
    for name in ("type", "x", "y", "theta", "u", "v", "omega", "radius"):
        state[name] = ("element", raft[name])
    state["area"] = ("element", np.where(raft["type"] == 2, 0.0, 1.1 * raft["ice_area"]))
    for name, value in (("ice_fraction", 0.9), ("ice_volume", thickness), ("snow_volume", 0.1)):
        state[name].values[:, 0] = np.where(raft["type"] == 2, 0.0, value)
    total = float(state["area"].sum())
    state.attrs |= {"ocean_area": total + 5e6, "unclaimed_water": 5e6}
    elements = element_arrays(state, 1e-3)
    table = bonded(elements)
    held = (table["id_lo"] > 6) & (table["id_lo"] % 3 > 0)
    table = {name: values[held] for name, values in table.items()}
    params = full_params(time_step=0.1, bonds=True, ridging=True, compressive_strength=1e5)
    with Engine(MPI.COMM_SELF, params, log) as engine:
        engine.load(elements, table)
        engine.run(600)
        moved = engine.elements()
        state = moved_state(state, moved, engine.bonds(), engine.contacts())
    return state, moved["ridged_area"], params


def pushes(state: xr.Dataset, params: EngineParams) -> dict[tuple[int, int], float]:
    """Elastic normal force (N) of each contact."""
    elements, contacts = element_arrays(state, 1e-3), pair_arrays(state, "contact")
    lo, hi = (np.searchsorted(elements["id"], contacts[f"id_{end}"]) for end in ("lo", "hi"))
    apart = np.hypot(*(elements[axis][hi] - elements[axis][lo] for axis in ("x", "y")))
    overlap = elements["radius"][lo] + elements["radius"][hi] - apart - contacts["rest_overlap"]
    force = params.contact_modulus * contact_share(elements, lo, hi) * np.maximum(overlap, 0.0)
    return dict(zip(zip(contacts["id_lo"], contacts["id_hi"], strict=True), force, strict=True))


def glue_lines(state: xr.Dataset) -> np.ndarray:
    """Ends of all glue lines in space, seen from either side (m)."""
    out = []
    for side in ("lo", "hi"):
        row = np.searchsorted(state["id"], state[f"bond_id_{side}"])
        cos, sin = (f(state["theta"].values[row]) for f in (np.cos, np.sin))
        for end in "ab":
            ax, ay = (state[f"bond_{side}_{end}{axis}"].values for axis in "xy")
            out.append(state["x"].values[row] + cos * ax - sin * ay)
            out.append(state["y"].values[row] + sin * ax + cos * ay)
    return np.array(out)


def test_area_volume_and_forces_over_the_boundary(tmp_path: Path) -> None:
    log = tmp_path / "log"
    state, ridged, params = ridged_state(log)
    assert (ridged > 0).sum() > 5 and (ridged[:6] == 0).all()
    closed = close_areas(state, ridged, 1e-3)
    check_state(closed)
    owned = float(closed["area"].sum()) + closed.attrs["unclaimed_water"]
    assert owned == pytest.approx(state.attrs["ocean_area"], rel=1e-12)
    lost = (state["area"] - closed["area"]).values
    np.testing.assert_allclose(lost, ridged, rtol=0, atol=1e-9 * state["area"].values.max())
    for name in ("ice_volume", "snow_volume"):
        before, after = ((s["area"] * s[name].sum("category")).values for s in (state, closed))
        np.testing.assert_allclose(after, before, rtol=1e-14)
    # Leads close first: the ice area stays until there are none.
    before, after = (s["area"].values * s["ice_fraction"].values.sum(1) for s in (state, closed))
    room = closed["area"].values
    np.testing.assert_allclose(after, np.minimum(before, room), rtol=1e-13)
    assert (after < before).any() and (after[ridged > 0] == before[ridged > 0]).any()
    kept = close_areas(state, ridged, 1e-3, leads=False)
    assert kept["ice_fraction"].identical(state["ice_fraction"])
    assert ((closed["radius"] < state["radius"]).values == (ridged > 0)).all()
    assert (closed["contact_rest_overlap"].values < 0).any()
    # Each contact pushes as hard as before; where centres have moved it pushes along their line.
    before, after = pushes(state, params), pushes(closed, params)
    hardest = max(before.values())
    assert hardest > 1e6
    for pair, push in before.items():
        assert after.get(pair, 0.0) == pytest.approx(push, rel=0, abs=1e-9 * hardest)
    np.testing.assert_array_equal(closed["bond_thickness"], state["bond_thickness"])
    moved = np.hypot(closed["x"] - state["x"], closed["y"] - state["y"]).values
    assert moved[ridged > 0].max() > 1.0 and (moved[ridged == 0] == 0).all()
    lines = [glue_lines(s) for s in (state, closed)]
    np.testing.assert_allclose(lines[1], lines[0], rtol=0, atol=1e-9)
    # And the next window can be loaded and run.
    with Engine(MPI.COMM_SELF, params, log) as engine:
        tables = (pair_arrays(closed, "bond"), pair_arrays(closed, "contact"))
        engine.load(element_arrays(closed, 1e-3), *tables)
        engine.run(200)


def test_without_ridging_nothing_closes(tmp_path: Path) -> None:
    state, ridged, _ = ridged_state(tmp_path / "log")
    same = close_areas(state, 0 * ridged, 1e-3)
    for name in ("area", "radius", "ice_volume"):
        np.testing.assert_array_equal(same[name].values, state[name].values)


def test_of_an_element_that_would_vanish_a_rest_stays(tmp_path: Path) -> None:
    state, ridged, _ = ridged_state(tmp_path / "log")
    ridged[9] = 2.0 * state["area"].values[9]
    closed = close_areas(state, ridged, 1e-3)
    check_state(closed)
    assert 0.0 < closed["area"].values[9] < 0.05 * state["area"].values[9]
    owned = float(closed["area"].sum()) + closed.attrs["unclaimed_water"]
    assert owned == pytest.approx(state.attrs["ocean_area"], rel=1e-12)
    amount = [
        float((s["area"] * s["ice_volume"].sum("category")).values[9]) for s in (state, closed)
    ]
    assert amount[1] == pytest.approx(amount[0], rel=1e-12)


def test_only_ridging_brings_ridges_to_the_state() -> None:
    assert not [n for n in expected_variables(("friction", "bonds")) if "ridge" in n]
    assert "contact_ridge_length" in expected_variables(EFFECTS)


def test_what_is_left_lies_away_from_the_ridge() -> None:
    # 1 and 2 lost strips 20 m wide and 1000 m long in all, on their sides towards each other.
    x = np.array([0.0, 1980.0])
    state = a_state(("ridging", "thermodynamics"), n=2).isel(contact=[0])
    for name, value in (("x", x), ("y", 0 * x), ("theta", 0 * x), ("radius", 0 * x + 1000.0)):
        state[name] = ("element", value)
    state["type"] = ("element", np.array([1, 1], np.int8))
    state["area"] = ("element", np.full(2, 4e6))
    state["ice_volume"].values[:] = 1.0
    state["contact_ridge_closing"].values[:] = 20.0
    state["contact_ridge_length"].values[:] = 1000.0
    closed = close_areas(state, np.full(2, 1e4), 1e-3)
    moved = 1e4 * (1000.0 - 5.0) / (4e6 - 1e4)
    np.testing.assert_allclose(closed["x"].values - x, [-moved, moved], rtol=1e-12)
    # Of a ridge that was there before the window nothing is taken once more.
    again = close_areas(closed, np.zeros(2), 1e-3, {"contact": pair_arrays(closed, "contact")})
    np.testing.assert_array_equal(again["x"].values, closed["x"].values)


def test_what_lies_beside_a_ridge_is_no_further_off_for_it(tmp_path: Path) -> None:
    # 1 and 2 have ridged; 3 lies 3 m from 2, 4 a tenth of a diameter from 3, 5 and 6 are coast.
    x = np.array([0.0, 1980.0, 3983.0, 6183.0, 8190.0, 10190.0])
    state = a_state(("ridging", "thermodynamics"), n=6).isel(contact=[0])
    for name, value in (("x", x), ("y", 0 * x), ("theta", 0 * x), ("radius", 0 * x + 1000.0)):
        state[name] = ("element", value)
    for name in ("u", "v", "omega"):
        state[name] = ("element", 0 * x)
    state["type"] = ("element", np.array([1, 1, 1, 1, 2, 2], np.int8))
    state["area"] = ("element", np.where(state["type"] == 1, 4e6, 0.0))
    state["ice_volume"].values[:] = state["ice_fraction"].values[:] = 1.0
    state["contact_rest_overlap"].values[:] = 20.0
    # No contact tells where the ridges were: discs shrink about their centres.
    state["contact_ridge_closing"].values[:] = 0.0
    ridged = np.array([1e4, 1e4, 0.0, 1e3, 0.0, 0.0])
    closed = close_areas(state, ridged, 1e-3)
    check_state(closed)
    pairs = zip(closed["contact_id_lo"].values, closed["contact_id_hi"].values, strict=True)
    assert list(pairs) == [(1, 2), (2, 3), (4, 5)]

    def gaps_of(state: xr.Dataset) -> np.ndarray:
        at, radius = state["x"].values, state["radius"].values
        return np.asarray(at[[2, 4]] - at[[1, 3]] - radius[[1, 3]] - radius[[2, 4]])

    gaps = gaps_of(closed)
    assert gaps[0] > 4.0  # the disc has become smaller
    np.testing.assert_allclose(gaps + closed["contact_rest_overlap"].values[1:], [3.0, 7.0])
    # Element 3 comes from there: it meets 2 after its 3 m, not after the gap of the discs.
    elements = element_arrays(closed, 1e-3)
    elements["mass"][2], elements["u"][2] = 1e27, -1.0
    params = full_params(time_step=0.01, ridging=True, friction=False, contact_damping=0.0)
    with Engine(MPI.COMM_SELF, params, tmp_path / "log") as engine:
        engine.load(elements, None, pair_arrays(closed, "contact"))
        engine.run(299)
        assert engine.diagnostics()["elastic_contact"] < 1.0
        engine.run(10)
        met = engine.contacts()
        assert engine.diagnostics()["elastic_contact"] > 1e4
    assert met["ridge_length"][1] > 0 and met["ridge_thickness"][1] == pytest.approx(1.0, rel=0.01)
    # A window later, still open pairs keep their gaps once more.
    again = close_areas(closed, ridged, 1e-3)
    np.testing.assert_allclose(
        gaps_of(again) + again["contact_rest_overlap"].values[1:], [3.0, 7.0]
    )
