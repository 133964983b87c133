# SPDX-License-Identifier: GPL-2.0-or-later
"""All that must be true of a state of columns, whatever came before it."""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from floeflow.column.layered import LayeredState


def sound(state: LayeredState) -> None:
    """Finite, within bounds, nothing where there is no ice, water on ponds alone."""
    for field in fields(state):
        assert np.isfinite(getattr(state, field.name)).all(), field.name
    for name in ("ice_fraction", "ice_volume", "snow_volume", "pending_freeze"):
        assert getattr(state, name).min() >= 0.0, name
    # 1 but for the round-off of a sum of categories.
    assert state.ice_fraction.sum(axis=1).max() <= 1.0 + 1e-15
    there = state.ice_fraction > 0.0
    assert np.array_equal(there, state.ice_volume > 0.0)
    assert (state.snow_volume[~there] == 0.0).all()
    assert state.surface_temperature.max() <= 0.0
    assert state.surface_temperature.min() > -90.0
    assert (state.ice_enthalpy[there] < 0.0).all() and (state.ice_enthalpy > -5e8).all()
    assert (state.ice_salinity >= 0.0).all() and (state.ice_salinity < 60.0).all()
    for name in ("level_area", "level_volume", "pond_area", "lid_share"):
        share = getattr(state, name)
        assert share.min() >= 0.0 and share.max() <= 1.0 + 1e-12, name
    for name in ("pond_depth", "pond_lid"):
        assert getattr(state, name).min() >= 0.0, name
    # Water stands on ponds, and lids float on it.
    assert (state.pond_depth[state.pond_area == 0.0] == 0.0).all()
