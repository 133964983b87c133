# SPDX-License-Identifier: GPL-2.0-or-later
"""Discs that grow until their contacts are as long as the outlines of their elements."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from floeflow.core.constants import EDGE_SHARE
from floeflow.dynamics.ridging.filled_discs import INSCRIBED, fill_areas
from floeflow.state.elements import element_arrays
from floeflow.state.schema import COAST, check_state
from floeflow.state.walls import rings
from unit.dynamics.test_ridging import pushes, ridged_state


def turning(state: xr.Dataset) -> np.ndarray:
    """Angular momentum of each element (kg m2/s)."""
    elements = element_arrays(state, 1e-3)
    return 0.5 * elements["mass"] * elements["radius"] ** 2 * elements["omega"]


def test_discs_fill_the_share_and_contacts_keep_their_forces(tmp_path: Path) -> None:
    state, _, params = ridged_state(tmp_path / "log")
    # Gaps of some per cent, as in a tessellation, and one disc that is large already.
    state["area"] = 1.15 * state["area"]
    state["area"].values[20] *= 0.8
    state["omega"].values[:] = np.linspace(-1e-4, 1e-4, 30)
    filled = fill_areas(state)
    check_state(filled)
    coast = state["type"].values == COAST
    wanted = np.sqrt(INSCRIBED * state["area"].values / np.pi)
    grows = ~coast & (wanted > state["radius"].values)
    assert grows.any() and not grows[~coast].all()
    np.testing.assert_allclose(filled["radius"].values[grows], wanted[grows], rtol=1e-15)
    np.testing.assert_array_equal(filled["radius"].values[~grows], state["radius"].values[~grows])
    np.testing.assert_allclose(turning(filled)[~coast], turning(state)[~coast], rtol=1e-13)
    before, after = pushes(state, params), pushes(filled, params)
    assert sum(push > 0.0 for push in before.values()) > 5
    for pair, push in before.items():
        assert after[pair] == pytest.approx(push, rel=0, abs=1e-9 * max(before.values()))
    for name in ("x", "y", "area", "u", "v"):
        assert filled[name].identical(state[name])
    assert fill_areas(filled).identical(filled)


def test_contacts_all_around_are_as_long_as_the_outline() -> None:
    """Six sides of the hexagon about a disc that fills its share of an element of 1 m2."""
    radius = np.sqrt(INSCRIBED / np.pi)
    side = np.sqrt(2.0 / (3.0 * np.sqrt(3.0)))
    assert 2.0 * EDGE_SHARE * radius == pytest.approx(side, rel=1e-3)


def test_a_gap_closes_at_most(tmp_path: Path) -> None:
    """Open contacts are nearer to each other by what the discs grew, but do not push."""
    state, _, params = ridged_state(tmp_path / "log")
    state["area"] = 1.4 * state["area"]
    filled = fill_areas(state)
    hardest = [max(pushes(each, params).values()) for each in (state, filled)]
    assert hardest[1] == pytest.approx(hardest[0])

    def gaps(of: xr.Dataset) -> np.ndarray:
        lo, hi = (np.searchsorted(of["id"], of[f"contact_id_{end}"]) for end in ("lo", "hi"))
        x, y, radius = (of[name].values for name in ("x", "y", "radius"))
        apart = np.hypot(x[hi] - x[lo], y[hi] - y[lo])
        return apart - radius[lo] - radius[hi] + of["contact_rest_overlap"].values

    lo, hi = (np.searchsorted(state["id"], state[f"contact_id_{end}"]) for end in ("lo", "hi"))
    growth = (filled["radius"] - state["radius"]).values
    was, now = gaps(state), gaps(filled)
    is_open = was > 0.0
    assert is_open.any()
    least = np.maximum(was - growth[lo] - growth[hi], 0.0)
    np.testing.assert_allclose(now[is_open], least[is_open], atol=1e-9 * was.max())


def test_discs_end_at_a_closed_coast(tmp_path: Path) -> None:
    state, _, _ = ridged_state(tmp_path / "log")
    state["area"] = 1.3 * state["area"]
    radius = float(state["radius"].values[15])
    near = float(state["x"].values.max()) + 1.01 * radius
    ring = np.array([[near, -1e6], [near + 1e6, -1e6], [near + 1e6, 1e6], [near, 1e6]])
    faces = rings(np.array([0, len(ring)]), ring)
    named = {f"wall_face_{name}": ("wall_face", values) for name, values in faces.items()}
    filled = fill_areas(state.assign(named))
    mobile = state["type"].values != COAST
    reach = (filled["x"] + filled["radius"]).values[mobile]
    assert reach.max() == pytest.approx(near, rel=1e-12)
    assert (filled["radius"].values >= state["radius"].values).all()
    free = fill_areas(state)["radius"].values
    assert (filled["radius"].values < free)[mobile].any()


def test_without_room_nothing_changes(tmp_path: Path) -> None:
    state, _, _ = ridged_state(tmp_path / "log")
    state["area"] = 0.5 * state["area"]
    assert fill_areas(state) is state
