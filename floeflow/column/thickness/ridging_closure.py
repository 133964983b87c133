# SPDX-License-Identifier: GPL-2.0-or-later
"""Closing of the elements in the terms of their columns, and the heat that the sea gives for it."""

from __future__ import annotations

import numpy as np

from floeflow.column.layered_run import freezing_point, layered_physics, layered_state, pond_water
from floeflow.column.ocean.slab import Sea, chill, heat_capacity
from floeflow.column.params import Settings, zero_layer_params
from floeflow.column.physics import KELVIN
from floeflow.column.state import Array
from floeflow.column.thickness.categories import category_bounds
from floeflow.column.thickness.redistribution import redistribute

Columns = dict[str, Array]

_VOLUMES = ("ice_volume", "snow_volume")


def before_closing(columns: Columns, closed: Array) -> Columns:
    """Columns that ridging left, as they were before the closing but per area that is left.

    Parameters
    ----------
    columns : dict of ndarray
        By the names of the state's schema, after ridging has used up area.
    closed : ndarray
        Share of each element's area that has just closed, (n,).

    Returns
    -------
    dict of ndarray
        ``ice_fraction`` is that of the area that is left.
    """
    return columns | {"ice_fraction": columns["ice_fraction"] / (1.0 - closed)[:, None]}


def close_columns(
    columns: Columns, closed: Array, settings: Settings
) -> tuple[Columns, dict[str, Array]]:
    """Redistribute the ice of elements whose area has shrunk.

    Parameters
    ----------
    columns : dict of ndarray
        As ridging left them: volumes per area that is left, fractions as they were.
    closed : ndarray
        Share of the area before that was closed, (n,).
    settings : Settings
        Of the columns, with two categories or more.

    Returns
    -------
    columns : dict of ndarray
        Per area that is left. Snow that fell off ridges melts in the mixed layer, if there is one.
    terms : dict of ndarray
        ``snow_ridging`` (m), ``water_ridging`` (kg/m2) and, without a mixed layer,
        ``energy_ridging`` (J/m2), (n,) each, of snow; with ponds ``pond_ridging`` (m).
    """
    before = dict(columns)
    for name in _VOLUMES:
        if name in before:
            before[name] = before[name] * (1.0 - closed)[:, None]
    ridged = redistribute(before, closed, category_bounds(settings.categories))
    after = ridged.columns
    terms: dict[str, Array] = {}
    if settings.has("ponds"):
        ponds = (before_closing(columns, closed), after)
        first, last = (pond_water(layered_state(each, settings)) for each in ponds)
        terms["pond_ridging"] = last - first
    if not settings.has("snow"):
        return after, terms
    p, params = layered_physics(settings), zero_layer_params(settings)
    density, cost = p.snow_density, -ridged.snow_energy
    if settings.scheme == "zero_layer":
        density, cost = params.snow_density, params.snow_energy * ridged.snow_lost
    terms |= {"snow_ridging": -ridged.snow_lost, "water_ridging": -density * ridged.snow_lost}
    if not settings.has("mixed_layer"):
        return after, terms | {"energy_ridging": cost}
    sea = Sea(after["sea_temperature"], after["pending_freeze"])
    freezing = freezing_point(settings) + KELVIN
    sea = chill(sea, np.maximum(cost, 0.0), heat_capacity(params), freezing)
    seas = {"sea_temperature": sea.temperature, "pending_freeze": sea.pending_freeze}
    return after | seas, terms
