# SPDX-License-Identifier: GPL-2.0-or-later
# mypy: disable-error-code="no-untyped-def"
"""Thickness categories of ice that is not in layers: remapping after growth and melt.

The layered kernel does this within its steps. Zero-layer ice is given to the same functions as one
layer of ice and one of snow at their melting points.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numba
import numpy as np

from floeflow.column.kernel import sources_digest
from floeflow.column.params import ColumnParams
from floeflow.column.physics import Physics, as_records
from floeflow.column.records import CLEARED_ICE, LEVEL, MELT_SNOW, SUMS, Column, new_scratch
from floeflow.column.state import Array, ColumnFluxes, ColumnState
from floeflow.column.thickness.categories import remap
from floeflow.column.thickness.category_cleanup import clear, rebin


def _build(digest: str) -> Callable[..., Any]:
    @numba.njit(cache=True, error_model="numpy")
    def remap_all(
        area, ice, snow, surface, ice_enthalpy, snow_enthalpy, salinity, level, before, bounds,
        freezing, sums, constants,
    ):  # fmt: skip
        digest  # noqa: B018  (part of the key under which Numba caches)
        p = constants[0]
        s = new_scratch(area.shape[1], ice_enthalpy.shape[2], snow_enthalpy.shape[2])
        for e in range(area.shape[0]):
            c = Column(
                area[e], ice[e], snow[e], surface[e], ice_enthalpy[e], snow_enthalpy[e],
                salinity[e], level[e],
            )  # fmt: skip
            remap(c, before[e], bounds, s, p)
            rebin(c, s, bounds)
            clear(c, freezing, sums[e])

    return remap_all


_remap_all = _build(sources_digest())


def thicknesses(state: ColumnState) -> Array:
    """Thickness of each category (m), zero where there is no ice, (n, ncat)."""
    exists = state.ice_fraction > 0.0
    return np.where(exists, state.ice_volume / np.where(exists, state.ice_fraction, 1.0), 0.0)


def remap_categories(
    before: Array, state: ColumnState, fluxes: ColumnFluxes, bounds: Array, params: ColumnParams
) -> tuple[ColumnState, ColumnFluxes]:
    """Move ice between categories after a step of growth and melt (Lipscomb 2001).

    Parameters
    ----------
    before : ndarray
        Thickness of each category before the step (m), (n, ncat).
    state : ColumnState
        After the step.
    fluxes : ColumnFluxes
        Of the step; crumbs that are cleared away melt in the sea, at its cost.
    bounds : ndarray
        Of the categories (m), (ncat + 1,).
    params : ColumnParams
        Constants.
    """
    moved = [
        np.array(getattr(state, name), order="C")
        for name in ("ice_fraction", "ice_volume", "snow_volume", "surface_temperature")
    ]
    shape = (*state.ice_fraction.shape, 1)
    layers = [np.full(shape, -params.ice_energy), np.full(shape, -params.snow_energy)]
    sums = np.zeros((shape[0], len(SUMS)))
    _remap_all(
        *moved,
        *layers,
        np.zeros(shape),
        np.zeros((*shape[:2], len(LEVEL))),
        before,
        bounds,
        params.freezing_temperature,
        sums,
        as_records(Physics()),
    )
    # Crumbs are told of by element: they count in the first category.
    ice, snow = np.zeros(shape[:2]), np.zeros(shape[:2])
    ice[:, 0], snow[:, 0] = sums[:, CLEARED_ICE], sums[:, MELT_SNOW]
    cost = (params.ice_energy * ice + params.snow_energy * snow)[:, 0]
    return ColumnState(*moved), replace(
        fluxes,
        energy_to_ocean=fluxes.energy_to_ocean - cost,
        melt_base=fluxes.melt_base + ice,
        snow_melt=fluxes.snow_melt + snow,
    )
