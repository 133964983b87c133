# SPDX-License-Identifier: GPL-2.0-or-later
"""Age of the ice: a day a day, none of what is new, and kept by all that deals ice out anew."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from mpi4py import MPI

from floeflow.core.constants import ICE_DENSITY, SNOW_DENSITY
from floeflow.coupling.ages import grow_older
from floeflow.coupling.coupled_windows import advance_window
from floeflow.coupling.initial import make_state
from floeflow.dynamics.remesh.merge import merge, merge_targets
from floeflow.forcings.window import window_forcing
from floeflow.scene.load import build_scene
from floeflow.state.schema import MOBILE, check_state, expected_variables
from support.remesh_cases import coast_case, remapped, totals
from unit.coupling.test_sea import EFFECTS as AT_SEA
from unit.coupling.test_sea import pool, weather, windows
from unit.coupling.test_walls import a_packing

DAY = 86400.0


def two(volume: tuple[float, float] = (2.0, 0.0), age: float = 0.0) -> xr.Dataset:
    """Two mobile elements and one of the coast; ice of these volumes (m) with a tenth of snow."""
    ice = np.array([*volume, 3.0])[:, None]
    return xr.Dataset(
        {
            "type": ("element", np.array([MOBILE, MOBILE, 2])),
            "area": ("element", np.array([100.0, 100.0, 0.0])),
            "ice_volume": (("element", "category"), ice),
            "snow_volume": (("element", "category"), 0.1 * ice),
            "ice_age": ("element", np.array([age, age, 0.0])),
        }
    )


def mass_of(state: xr.Dataset) -> np.ndarray:
    load = ICE_DENSITY * state["ice_volume"] + SNOW_DENSITY * state["snow_volume"]
    return (state["area"] * load.sum("category")).values


def test_ice_grows_older_by_a_day_a_day() -> None:
    state = two()
    for _ in range(3):
        state = grow_older(state, 0.0, DAY)
    # Open water and the coast have no age.
    np.testing.assert_array_equal(state["ice_age"], [3 * DAY, 0.0, 0.0])


def test_new_ice_has_age_zero_and_dilutes_by_its_mass() -> None:
    state = two((2.0, 1.0), age=9 * DAY)
    # A fifth of the ice of the first is new, all of the second's, and more than is left of it.
    aged = grow_older(state, np.array([40.0, 300.0]), DAY)
    old = mass_of(state)[0] - ICE_DENSITY * 40.0
    assert float(aged["ice_age"][0]) * mass_of(state)[0] == pytest.approx(10 * DAY * old, rel=1e-12)
    assert float(aged["ice_age"][1]) == 0.0


def test_merging_and_remapping_keep_the_age_of_the_mass() -> None:
    state, cells = coast_case("remap, ice_age, internal_stress")
    random = np.random.default_rng(8)
    mobile = state["type"].values == MOBILE
    for name in ("ice_age", "internal_force_x", "stress_xx", "stress_xy"):
        size = DAY if name == "ice_age" else 1.0
        state[name] = ("element", np.where(mobile, size * random.random(mobile.size), 0.0))
    for after in (remapped(state, cells), merge(state, merge_targets(state, 1.1))):
        check_state(after)
        assert not np.array_equal(after["ice_age"], state["ice_age"])
        before, now = totals(state), totals(after)
        for name in ("ice_age", "internal_force_x", "stress_xx", "stress_xy"):
            assert now[name] == pytest.approx(before[name], rel=1e-9), name
        ages = after["ice_age"].values[after["type"].values == MOBILE]
        assert ages.min() >= 0.0 and ages.max() <= state["ice_age"].values.max()


def test_elements_that_freeze_at_sea_are_new_and_join_as_such() -> None:
    scene, state, places = pool(warm=0.0, effects=[*AT_SEA, "ice_age"])
    state["ice_age"] = ("element", np.full(state.sizes["element"], DAY))
    last = int(state["id"].max())
    # Heat of the columns alone: the windows of this test let nothing grow older.
    after, terms = windows(scene, state, places, weather(scene, 243.0), 3)
    check_state(after)
    born = after["id"].values > last
    assert terms["sea_born"] >= born.sum() > 5 and terms["sea_joined"] > 0.0
    assert not after["ice_age"].values[born].any()
    old = after["ice_age"].values[~born]
    assert old.max() <= DAY and old.min() < DAY * (1.0 - 1e-6)


def test_a_run_ages_its_ice_and_changes_nothing_else(tmp_path: Path) -> None:
    ends = []
    for more in ([], ["ice_age"]):
        scene = build_scene(
            {
                "name": "a",
                "effects": ["wind", "friction", *more],
                "domain": {"x_min": 0.0, "x_max": 4e4, "y_min": 0.0, "y_max": 4e4, "spacing": 1e4},
                "time": {"window": 3600.0},
                "forcing": {"step": 3600.0},
                "dynamics": {"samples": 2},
            }
        )
        state, forcing = make_state(scene, a_packing(), None), window_forcing(scene, 1, tmp_path)
        for _ in range(2):
            done = advance_window(
                MPI.COMM_SELF, scene, state, forcing, tmp_path / "log", lambda **_: None
            )
            state = done.state.assign_attrs(time=0.0)
        ends.append(state)
    plain, aged = ends
    mobile = aged["type"].values == MOBILE
    np.testing.assert_array_equal(aged["ice_age"].values[mobile], 7200.0)
    assert aged.drop_vars("ice_age").drop_attrs().identical(plain.drop_attrs())
    assert "ice_age" not in expected_variables(("wind", "friction"))
