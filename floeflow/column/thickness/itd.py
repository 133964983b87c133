# SPDX-License-Identifier: GPL-2.0-or-later
"""Thickness categories of ice that is not in layers: remapping after growth and melt.

The layered kernel does this within its steps. Zero-layer ice is given to the same functions as one
layer of ice and one of snow at their melting points.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numba
import numpy as np

from floeflow.column.kernel import sources_digest
from floeflow.column.params import ColumnParams
from floeflow.column.physics import Physics, as_records, jit
from floeflow.column.records import (
    CLEARED_ICE,
    LEVEL,
    MELT_SNOW,
    SUMS,
    Column,
    column_of,
    new_scratch,
)
from floeflow.column.state import Array, ColumnFluxes, ColumnState
from floeflow.column.thickness.categories import remap
from floeflow.column.thickness.category_cleanup import clear, rebin

if TYPE_CHECKING:
    from floeflow.column.records import Scratch


@jit
def remap_some(
    columns: Column,
    before: np.ndarray,
    bounds: np.ndarray,
    s: Scratch,
    freezing: float,
    sums: np.ndarray,
    p: Physics,
) -> None:
    """Move ice of all elements between categories, and melt traces of ice in the sea.

    Parameters
    ----------
    columns : Column
        Of n elements, (n, ncat) and (n, ncat, layers); advanced.
    before : ndarray
        Thickness before growth and melt (m), (n, ncat).
    bounds : ndarray
        Of the categories (m), (ncat + 1,).
    s : Scratch
        Work arrays.
    freezing : float
        Freezing point of the sea, in the unit of the surface's temperature.
    sums : ndarray
        Budget terms, added to, (n, len(SUMS)).
    p : Physics
        Constants.
    """
    for e in range(columns.area.shape[0]):
        c = column_of(columns, e)
        remap(c, before[e], bounds, s, p)
        rebin(c, s, bounds)
        clear(c, freezing, sums[e])


def _build(digest: str) -> Callable[..., Any]:
    @numba.njit(cache=True, error_model="numpy")
    def remap_all(
        columns: Column,
        before: np.ndarray,
        bounds: np.ndarray,
        freezing: np.ndarray,
        sums: np.ndarray,
        constants: np.ndarray,
    ) -> None:
        """Call `remap_some`, with ``constants``: `Physics` as a record, (1,)."""
        digest  # noqa: B018  (part of the key under which Numba caches)
        _, categories, ice_layers = columns.ice_enthalpy.shape
        s = new_scratch(categories, ice_layers, columns.snow_enthalpy.shape[2])
        remap_some(columns, before, bounds, s, freezing, sums, constants[0])

    return remap_all


_remap_all = _build(sources_digest())


def thicknesses(state: ColumnState) -> Array:
    """Thickness of each category (m), zero where there is no ice, (n, ncat).

    Parameters
    ----------
    state : ColumnState
        n elements of ncat categories.

    Returns
    -------
    ndarray
        m, (n, ncat).
    """
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
        Of the step; traces of ice that are cleared away melt in the sea and cool it.
    bounds : ndarray
        Of the categories (m), (ncat + 1,).
    params : ColumnParams
        Constants.

    Returns
    -------
    state : ColumnState
        Ice in the categories that its thickness belongs to, (n, ncat).
    fluxes : ColumnFluxes
        Of the step, with what traces of ice took from the sea.
    """
    shape = (*state.ice_fraction.shape, 1)
    columns = Column(
        area=np.array(state.ice_fraction, order="C"),
        ice=np.array(state.ice_volume, order="C"),
        snow=np.array(state.snow_volume, order="C"),
        surface=np.array(state.surface_temperature, order="C"),
        ice_enthalpy=np.full(shape, -params.ice_energy),
        snow_enthalpy=np.full(shape, -params.snow_energy),
        salinity=np.zeros(shape),
        level=np.zeros((*shape[:2], len(LEVEL))),
    )
    sums = np.zeros((shape[0], len(SUMS)))
    _remap_all(
        columns,
        before,
        bounds,
        params.freezing_temperature,
        sums,
        as_records(Physics()),
    )
    # Traces are summed by element: they count in the first category.
    ice, snow = np.zeros(shape[:2]), np.zeros(shape[:2])
    ice[:, 0], snow[:, 0] = sums[:, CLEARED_ICE], sums[:, MELT_SNOW]
    cost = (params.ice_energy * ice + params.snow_energy * snow)[:, 0]
    after = ColumnState(columns.area, columns.ice, columns.snow, columns.surface)
    return after, replace(
        fluxes,
        energy_to_ocean=fluxes.energy_to_ocean - cost,
        melt_base=fluxes.melt_base + ice,
        snow_melt=fluxes.snow_melt + snow,
    )
