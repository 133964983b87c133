# SPDX-License-Identifier: GPL-2.0-or-later
"""Contacts of ice that grows or melts under load."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from mpi4py import MPI

from floeflow.coupling.initial import make_state
from floeflow.dynamics.bonds.stress_free_growth import keep_forces
from floeflow.dynamics.engine.engine import Engine
from floeflow.state.bonds import element_rows
from floeflow.state.elements import element_arrays, pair_arrays
from support.full_ice import full_params
from support.rafts import discs
from unit.coupling.test_walls import a_packing, a_scene
from unit.state.test_state import a_state

LEAST = 1e-3
PRESSED = 3.0  # m of elastic overlap


def pressed_row(thickness: float) -> xr.Dataset:
    """Three elements in a row, each pressed against the next, the middle one the thickest."""
    row = discs(1990.0 * np.arange(3), np.zeros(3))
    state = a_state(("friction", "thermodynamics", "snow"), n=3).isel(contact=[0, 0])
    for name in ("type", "x", "y", "theta", "u", "v", "omega", "radius"):
        state[name] = ("element", row[name])
    state["ice_fraction"].values[:, 0] = 1.0
    state["ice_volume"].values[:, 0] = thickness * np.array([1.0, 2.0, 0.5])
    state["snow_volume"].values[:] = 0.0
    rest = 10.0 - PRESSED
    for name, value in (("id_lo", [1, 2]), ("id_hi", [2, 3]), ("rest_overlap", [rest, rest]),
                        ("slip", [0.2, -0.1])):  # fmt: skip
        state[f"contact_{name}"].values[:] = value
    return state


def overlaps(state: xr.Dataset) -> np.ndarray:
    """Elastic overlaps of the contacts, m."""
    lo, hi = (element_rows(state["id"].values, state[f"contact_id_{e}"].values)
              for e in ("lo", "hi"))  # fmt: skip
    x, radius = state["x"].values, state["radius"].values
    return radius[lo] + radius[hi] - (x[hi] - x[lo]) - state["contact_rest_overlap"].values


def elastic_energy(state: xr.Dataset, log) -> float:  # noqa: ANN001
    """As the engine finds it, J."""
    with Engine(MPI.COMM_SELF, full_params(time_step=1.0), log) as engine:
        engine.load(element_arrays(state, LEAST), None, pair_arrays(state, "contact"))
        return engine.diagnostics()["elastic_contact"]


@pytest.mark.parametrize("factor", [1.0 + 1e-9, 1.5, 100.0])
def test_ice_that_grows_adds_no_force_and_no_energy(factor: float, tmp_path):  # noqa: ANN001
    before, grown = pressed_row(0.1), pressed_row(0.1 * factor)
    after = keep_forces(before, grown, LEAST, 0.0)
    np.testing.assert_allclose(overlaps(after), PRESSED / factor, rtol=1e-9)
    np.testing.assert_allclose(after["contact_slip"], np.array([0.2, -0.1]) / factor, rtol=1e-9)
    first = elastic_energy(before, tmp_path / "log")
    assert elastic_energy(after, tmp_path / "log") == pytest.approx(first / factor, rel=1e-6)
    assert elastic_energy(grown, tmp_path / "log") > first


@pytest.mark.parametrize("factor", [1.0, 0.5, 0.0])
def test_ice_that_melts_takes_its_force_with_it(factor: float):
    before, melted = pressed_row(0.1), pressed_row(0.1 * factor)
    after = keep_forces(before, melted, LEAST, 0.0)
    for name in after.variables:
        np.testing.assert_array_equal(after[name].values, melted[name].values, err_msg=str(name))


def test_open_water_takes_up_what_pressed():
    before, opened = pressed_row(0.1), pressed_row(0.1)
    opened["ice_fraction"].values[2, 0] = 0.25
    after = keep_forces(before, opened, LEAST, 0.0)
    np.testing.assert_allclose(overlaps(after), [PRESSED, 0.25 * PRESSED], rtol=1e-9)


def test_first_ice_does_not_inherit_the_push_of_the_made_up_ice_before_it():
    before, frozen = pressed_row(0.0), pressed_row(2.0 * LEAST)
    before["ice_fraction"].values[:] = 0.0
    frozen["ice_fraction"].values[:] = 0.02
    after = keep_forces(before, frozen, LEAST, 0.0)
    assert (overlaps(after) <= 0.02 * PRESSED * (1 + 1e-9)).all()


@pytest.mark.parametrize("factor", [0.5, 1.0, 4.0])
def test_walls_are_pressed_no_harder_either(factor: float):
    packing = a_packing(gap=1.3).isel(element=slice(0, 6, 5), element_bound=slice(0, 3))
    before = make_state(a_scene("rim: [left, bottom]", "friction, walls"), packing, None)
    start = before["wall_contact_rest_overlap"].values.copy()
    before["wall_contact_rest_overlap"].values[:] -= PRESSED
    grown = before.assign(ice_volume=factor * before["ice_volume"])
    after = keep_forces(before, grown, LEAST, 0.0)
    elastic = start - after["wall_contact_rest_overlap"].values
    np.testing.assert_allclose(elastic, PRESSED / max(factor, 1.0), rtol=1e-6)


def test_open_pairs_stay_open():
    before, grown = pressed_row(0.1), pressed_row(1.0)
    for state in (before, grown):
        state["contact_rest_overlap"].values[:] = 11.0
    after = keep_forces(before, grown, LEAST, 0.0)
    np.testing.assert_array_equal(after["contact_rest_overlap"], 11.0)
