# SPDX-License-Identifier: GPL-2.0-or-later
"""A coupling window of the column: equal sub-steps under forcing that varies in time."""

from __future__ import annotations

import math
from collections.abc import Callable

from floeflow.column.ocean.slab import Sea
from floeflow.column.params import ColumnParams
from floeflow.column.state import ColumnFluxes, ColumnForcing, ColumnState, add
from floeflow.column.thermodynamics import zero_layer
from floeflow.column.thickness.categories import category_bounds
from floeflow.column.thickness.itd import remap_categories, thicknesses
from floeflow.core.errors import FloeError


def sub_steps(t0: float, t1: float, longest: float) -> tuple[int, float]:
    """Number and length (s) of equal steps from t0 to t1, none above the longest.

    Parameters
    ----------
    t0 : float
        s, t0 < t1.
    t1 : float
        s, t0 < t1.
    longest : float
        s, positive.

    Returns
    -------
    count : int
        Of steps, 1 or more.
    step : float
        Length of each, s.

    Raises
    ------
    FloeError
        For a window or step that is not positive.
    """
    if not (t1 > t0 and longest > 0.0):
        raise FloeError(f"column.step: no steps of {longest:g} s lead from {t0:g} s to {t1:g} s")
    # The allowance keeps 86400 s / 3600 s at 24 steps whatever round-off t0 and t1 carry.
    steps = max(1, math.ceil((t1 - t0) / longest * (1.0 - 1e-12)))
    return steps, (t1 - t0) / steps


def advance_window(
    state: ColumnState,
    sample: Callable[[float], ColumnForcing],
    t0: float,
    t1: float,
    dt_max: float,
    params: ColumnParams,
    sea: Sea | None = None,
) -> tuple[ColumnState, Sea | None, ColumnFluxes]:
    """Advance zero-layer columns from t0 to t1 in equal sub-steps no longer than dt_max.

    Parameters
    ----------
    state : ColumnState
        Columns at t0.
    sample : callable
        Forcing at the elements at a time (s); asked at the middle of each sub-step, which is the
        sub-step's mean of forcing that is linear in time.
    t0, t1 : float
        Start and end (s), t0 < t1.
    dt_max : float
        Longest sub-step (s).
    params : ColumnParams
        Constants.
    sea : Sea, optional
        Mixed layer at t0.

    Returns
    -------
    tuple of ColumnState, Sea or None, and ColumnFluxes
        Columns and mixed layer at t1, and the budget terms summed over the window.

    Raises
    ------
    FloeError
        For a window or step that is not positive.
    """
    steps, dt = sub_steps(t0, t1, dt_max)
    bounds = category_bounds(state.ice_fraction.shape[1])
    total: ColumnFluxes | None = None
    for k in range(steps):
        forcing, before = sample(t0 + (k + 0.5) * dt), thicknesses(state)
        state, sea, moved = zero_layer.step_with_sea(state, sea, forcing, dt, params)
        if len(bounds) > 2:
            state, moved = remap_categories(before, state, moved, bounds, params)
        total = moved if total is None else add(total, moved)
    assert total is not None
    return state, sea, total
