# SPDX-License-Identifier: GPL-2.0-or-later
"""A coupling window of the column: equal sub-steps under forcing that varies in time."""

from __future__ import annotations

import math
from collections.abc import Callable

from floeflow.column.params import ColumnParams
from floeflow.column.schemes import SCHEMES
from floeflow.column.state import ColumnFluxes, ColumnForcing, ColumnState, add
from floeflow.errors import FloeError


def advance_window(
    state: ColumnState,
    sample: Callable[[float], ColumnForcing],
    t0: float,
    t1: float,
    dt_max: float,
    params: ColumnParams,
    scheme: str = "zero_layer",
) -> tuple[ColumnState, ColumnFluxes]:
    """Advance columns from t0 to t1 in equal sub-steps no longer than dt_max.

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
    scheme : str
        A name in ``SCHEMES``.

    Returns
    -------
    tuple of ColumnState and ColumnFluxes
        Columns at t1, and the budget terms summed over the window.

    Raises
    ------
    FloeError
        For an unknown scheme, or a window or step that is not positive.
    """
    if scheme not in SCHEMES:
        raise FloeError(f"column.scheme: '{scheme}' is no scheme; known are {', '.join(SCHEMES)}")
    if not (t1 > t0 and dt_max > 0.0):
        raise FloeError(f"column.step: no steps of {dt_max:g} s lead from {t0:g} s to {t1:g} s")
    # The allowance keeps 86400 s / 3600 s at 24 steps whatever round-off t0 and t1 carry.
    steps = max(1, math.ceil((t1 - t0) / dt_max * (1.0 - 1e-12)))
    dt = (t1 - t0) / steps
    total: ColumnFluxes | None = None
    for k in range(steps):
        state, moved = SCHEMES[scheme](state, sample(t0 + (k + 0.5) * dt), dt, params)
        total = moved if total is None else add(total, moved)
    assert total is not None
    return state, total
