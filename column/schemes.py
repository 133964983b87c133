# SPDX-License-Identifier: GPL-2.0-or-later
"""The column schemes by the name under which a scene asks for them.

A scheme is a pure function ``step(state, forcing, dt, params) -> (state, fluxes)``.
"""

from __future__ import annotations

from collections.abc import Callable

from floeflow.column import zero_layer
from floeflow.column.params import ColumnParams
from floeflow.column.state import ColumnFluxes, ColumnForcing, ColumnState

Scheme = Callable[
    [ColumnState, ColumnForcing, float, ColumnParams], tuple[ColumnState, ColumnFluxes]
]

SCHEMES: dict[str, Scheme] = {"zero_layer": zero_layer.step}
