# SPDX-License-Identifier: GPL-2.0-or-later
"""From columns to discs and back."""

from __future__ import annotations

import numpy as np
import pytest

from floeflow.core.constants import ICE_DENSITY, SNOW_DENSITY
from floeflow.state.elements import (
    bearing_thickness,
    element_arrays,
    joint_thickness,
    moved_state,
    pair_arrays,
    thin_bonds,
)
from floeflow.state.schema import check_state
from unit.state.test_state import a_state


def test_masses_follow_from_areas_ice_and_snow():
    state = a_state()
    state["type"].values[:] = 1
    arrays = element_arrays(state, 1e-3)
    ice, snow = state["ice_volume"].values[:, 0], state["snow_volume"].values[:, 0]
    expected = state["area"].values * (ICE_DENSITY * ice + SNOW_DENSITY * snow)
    assert arrays["mass"] == pytest.approx(expected, rel=1e-14)
    assert arrays["thickness"] == pytest.approx(ice, rel=1e-14)
    drag = state["area"].values * state["ice_fraction"].values[:, 0]
    assert arrays["ice_area"] == pytest.approx(drag, rel=1e-14)


def test_ice_that_melts_out_keeps_a_mass():
    state = a_state()
    state["type"].values[:] = 1
    state["ice_volume"].values[:] = 0.0
    state["snow_volume"].values[:] = 0.0
    arrays = element_arrays(state, 1e-3)
    assert arrays["mass"] == pytest.approx(state["area"].values * ICE_DENSITY * 1e-3)
    assert (arrays["thickness"] == 1e-3).all()
    # And the drag that goes with it, or nothing would ever stop what is left.
    assert arrays["ice_area"] == pytest.approx(state["area"].values, rel=1e-14)


def test_coast_is_as_thick_as_the_thickest_ice_and_feels_no_drag():
    state = a_state()
    state["type"].values[:] = [1, 2, 1, 2]
    arrays = element_arrays(state, 1e-3)
    ice = bearing_thickness(state)
    assert (arrays["thickness"][[1, 3]] == max(ice[0], ice[2])).all()
    assert (arrays["ice_area"][[1, 3]] == 0.0).all()
    assert (arrays["mass"] > 0).all()


def test_a_state_without_ice_elements_has_coast_all_the_same():
    state = a_state()
    state["type"].values[:] = 2
    assert (element_arrays(state, 0.01)["thickness"] == 0.01).all()


def test_what_the_model_left_becomes_a_valid_state():
    state = a_state()
    elements = {name: state[name].values + 1.0 for name in ("x", "y", "theta", "u", "v", "omega")}
    bonds = {name: values[1:] for name, values in pair_arrays(state, "bond").items()}
    contacts = {name: values[:0] for name, values in pair_arrays(state, "contact").items()}
    moved = moved_state(state, elements, bonds, contacts)
    check_state(moved)
    assert (moved["x"].values == state["x"].values + 1.0).all()
    assert moved.sizes["bond"] == state.sizes["bond"] - 1
    assert moved.sizes["contact"] == 0
    assert moved["ice_volume"].identical(state["ice_volume"])


def test_melt_thins_bonds_and_growth_does_not_heal_them():
    state = a_state()
    state["ice_volume"].values[:, 0] = [1.0, 2.0, 3.0, 0.5]
    state["bond_thickness"].values[:] = [0.8, 2.5, 2.5]
    assert thin_bonds(state)["bond_thickness"].values.tolist() == [0.8, 2.0, 0.5]


def test_without_bonds_nothing_is_thinned():
    state = a_state(("wind",))
    assert thin_bonds(state) is state
    assert np.array_equal(pair_arrays(state, "contact")["id_lo"], [1])


def test_the_coast_does_not_thin_the_bonds_to_it() -> None:
    state = a_state()
    state["type"] = ("element", np.array([1, 1, 1, 2], np.int8))
    state["ice_volume"].values[:] = [[1.0], [0.8], [0.5], [0.0]]
    state["bond_thickness"].values[:] = 2.0
    assert thin_bonds(state)["bond_thickness"].values.tolist() == [0.8, 0.5, 0.5]
    assert joint_thickness(state).tolist() == [1.0, 0.8, 0.5, 1.0]


def test_a_bond_goes_where_its_ice_has_melted_out() -> None:
    state = a_state()
    state["ice_volume"].values[:, 0] = [1.0, 0.0, 1.0, 1.0]
    state["bond_thickness"].values[:] = 0.5
    left = thin_bonds(state)
    check_state(left)
    assert left["bond_id_lo"].values.tolist() == [3] and left["bond_id_hi"].values.tolist() == [4]
