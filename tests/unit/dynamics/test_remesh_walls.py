# SPDX-License-Identifier: GPL-2.0-or-later
"""Contacts with walls after elements have moved: what is near stays, what is far is forgotten."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from floeflow.dynamics.remesh.tables import FAR, with_walls
from floeflow.state.schema import VARIABLES
from floeflow.state.walls import lines

RADIUS, REST = 5e3, 300.0
DEEP = 400.0  # overlap before (m): 100 m of it push


def beside(*heights: float, contact: bool = False) -> xr.Dataset:
    """Discs above a wall along x at these heights of their centres (m)."""
    n = len(heights)
    elements = {
        "id": np.arange(1, n + 1),
        "type": np.ones(n),
        "x": 2e4 * np.arange(n),
        "y": np.asarray(heights),
        "radius": np.full(n, RADIUS),
    }
    state = xr.Dataset(
        {name: ("element", v.astype(VARIABLES[name].dtype)) for name, v in elements.items()},
        attrs={"time": 0.0},
    )
    if contact:
        faces = lines(np.array([[[-1e5, 0.0], [1e5, 0.0]]]))
        for name, values in faces.items():
            full = f"wall_face_{name}"
            state[full] = ("wall_face", values.astype(VARIABLES[full].dtype))
        for full, rule in VARIABLES.items():
            if full.startswith("wall_contact_"):
                state[full] = ("wall_contact", np.zeros(n, dtype=rule.dtype))
        state["wall_contact_id"].values[:] = elements["id"]
        state["wall_contact_rest_overlap"].values[:] = REST
    return state


def after(*heights: float) -> xr.Dataset:
    """State whose discs stood ``DEEP`` in the wall and stand at these heights now (m)."""
    before = beside(*[RADIUS - DEEP] * len(heights), contact=True)
    return with_walls(beside(*heights), before, before["id"].values)


def test_a_disc_that_stays_keeps_its_elastic_overlap() -> None:
    state = after(RADIUS - DEEP - 50.0)
    assert state["wall_contact_id"].values.tolist() == [1]
    assert float(state["wall_contact_rest_overlap"][0]) == pytest.approx(REST + 50.0)


def test_a_disc_far_from_a_wall_forgets_it() -> None:
    near, far = RADIUS * (1.0 + 0.9 * FAR), RADIUS * (1.0 + 1.1 * FAR)
    state = after(near, far, far + 33e3)
    assert state["wall_contact_id"].values.tolist() == [1]
    # A rest below zero holds the disc off, as a ridge does: by no more than FAR of its radius.
    assert -FAR * RADIUS - DEEP < float(state["wall_contact_rest_overlap"][0]) < 0.0


def test_a_disc_that_comes_into_a_wall_is_not_pushed() -> None:
    before = beside(RADIUS + 30e3, contact=True)
    before = before.isel(wall_contact=slice(0))
    state = with_walls(beside(RADIUS - 200.0), before, before["id"].values)
    assert float(state["wall_contact_rest_overlap"][0]) == pytest.approx(200.0)
