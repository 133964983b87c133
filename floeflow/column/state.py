# SPDX-License-Identifier: GPL-2.0-or-later
"""What goes into a column scheme and what comes out of it, as arrays over elements.

Records of arrays, without behaviour. All amounts are per square metre of the element's effective
area A, so that a slice of elements is a column problem of its own and ranks can share them.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from floeflow.column.params import ColumnParams

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ColumnState:
    """Columns of n elements with ncat thickness categories; arrays are (n, ncat).

    Parameters
    ----------
    ice_fraction : ndarray
        Share of A under ice of this category; the rest of A is open water.
    ice_volume : ndarray
        Ice volume per A (m).
    snow_volume : ndarray
        Snow volume per A (m).
    surface_temperature : ndarray
        Of the ice's or snow's surface (K).
    """

    ice_fraction: Array
    ice_volume: Array
    snow_volume: Array
    surface_temperature: Array


@dataclass(frozen=True)
class ColumnForcing:
    """Weather and ocean at the elements; arrays are (n,).

    Parameters
    ----------
    air_temperature : ndarray
        K.
    specific_humidity : ndarray
        kg/kg.
    wind_speed : ndarray
        m/s.
    shortwave_down, longwave_down : ndarray
        W/m2.
    snowfall : ndarray
        kg/m2/s.
    air_pressure : ndarray
        Pa.
    ocean_heat_flux : ndarray
        From the ocean to the ice's bottom or the lead, or to the mixed layer, upward (W/m2).
    friction_velocity : ndarray
        Under the ice (m/s); read with a mixed layer.
    """

    air_temperature: Array
    specific_humidity: Array
    wind_speed: Array
    shortwave_down: Array
    longwave_down: Array
    snowfall: Array
    air_pressure: Array
    ocean_heat_flux: Array
    friction_velocity: Array


@dataclass(frozen=True)
class ColumnFluxes:
    """What a step moved, summed over its time, per effective area: the terms of the budgets.

    Energy is counted from liquid water at its freezing point; vapour carries the latent heat of
    vaporisation, ice and snow minus that of fusion. Then, to round-off,

    - energy of ice and snow: change = energy_atmosphere + energy_ocean + energy_snowfall
      - energy_to_ocean
    - ice volume: change = growth_base + new_ice - melt_top - melt_base - melt_lateral
      - sublimation_ice
    - snow volume: change = snowfall - snow_melt - sublimation_snow

    Parameters
    ----------
    energy_atmosphere : ndarray
        Radiation, sensible heat and vapour, positive into the column (J/m2), (n,).
    energy_ocean : ndarray
        Ocean heat flux, positive into the column (J/m2), (n,).
    energy_snowfall : ndarray
        Brought by the snow on ice and in leads, negative (J/m2), (n,).
    energy_to_ocean : ndarray
        Heat that found nothing to melt, handed back to the ocean; negative where the sea melts
        snow that lost its ice (J/m2), (n,).
    growth_base, new_ice : ndarray
        Ice grown at the bottom, ice born in open water (m), (n, ncat).
    melt_top, melt_base, melt_lateral : ndarray
        Ice melted (m), (n, ncat).
    sublimation_ice, sublimation_snow : ndarray
        Ice and snow that left as vapour; negative: deposited (m), (n, ncat).
    snowfall : ndarray
        Snow fallen onto ice (m of snow), (n, ncat).
    snow_melt : ndarray
        Snow melted at the surface, beside a lead, or in the sea when its ice was gone
        (m of snow), (n, ncat).
    """

    energy_atmosphere: Array
    energy_ocean: Array
    energy_snowfall: Array
    energy_to_ocean: Array
    growth_base: Array
    new_ice: Array
    melt_top: Array
    melt_base: Array
    melt_lateral: Array
    sublimation_ice: Array
    sublimation_snow: Array
    snowfall: Array
    snow_melt: Array


def take(state: ColumnState, part: slice | NDArray[np.intp]) -> ColumnState:
    """Columns of some elements: what a rank works on.

    Parameters
    ----------
    state : ColumnState
        Columns of n elements.
    part : slice or ndarray of int
        Rows of the elements.

    Returns
    -------
    ColumnState
        The same arrays, their rows alone.
    """
    return ColumnState(**{f.name: getattr(state, f.name)[part] for f in fields(state)})


def add(a: ColumnFluxes, b: ColumnFluxes) -> ColumnFluxes:
    """Sum of what two successive steps moved.

    Parameters
    ----------
    a : ColumnFluxes
        Of the first and of the second step.
    b : ColumnFluxes
        Of the first and of the second step.

    Returns
    -------
    ColumnFluxes
        Each term summed.
    """
    return ColumnFluxes(**{f.name: getattr(a, f.name) + getattr(b, f.name) for f in fields(a)})


def column_energy(state: ColumnState, params: ColumnParams) -> Array:
    """Energy of ice and snow against liquid water (J/m2, negative), (n,).

    Parameters
    ----------
    state : ColumnState
        Columns.
    params : ColumnParams
        Constants.

    Returns
    -------
    ndarray
        L_f (rho_i v_i + rho_s v_s), negative.
    """
    ice = params.ice_energy * state.ice_volume
    snow = params.snow_energy * state.snow_volume
    return np.asarray(-(ice + snow).sum(axis=1))


def energy_residual(
    before: ColumnState, after: ColumnState, fluxes: ColumnFluxes, params: ColumnParams
) -> Array:
    """Change of the columns' energy that the fluxes do not explain (J/m2), (n,).

    Parameters
    ----------
    before : ColumnState
        Columns at the start and at the end of a step, or of more.
    after : ColumnState
        Columns at the start and at the end of a step, or of more.
    fluxes : ColumnFluxes
        What was moved meanwhile.
    params : ColumnParams
        Constants.

    Returns
    -------
    ndarray
        Round-off where the budget closes.
    """
    change = column_energy(after, params) - column_energy(before, params)
    gained = fluxes.energy_atmosphere + fluxes.energy_ocean + fluxes.energy_snowfall
    return np.asarray(change - (gained - fluxes.energy_to_ocean))


def ice_residual(before: ColumnState, after: ColumnState, fluxes: ColumnFluxes) -> Array:
    """Change of ice volume that the named terms do not explain (m), (n, ncat).

    Parameters
    ----------
    before : ColumnState
        Columns at the start and at the end of a step, or of more.
    after : ColumnState
        Columns at the start and at the end of a step, or of more.
    fluxes : ColumnFluxes
        What was moved meanwhile.

    Returns
    -------
    ndarray
        Round-off where the budget closes, but for what remapping moves between categories.
    """
    grown = fluxes.growth_base + fluxes.new_ice
    lost = fluxes.melt_top + fluxes.melt_base + fluxes.melt_lateral + fluxes.sublimation_ice
    return np.asarray(after.ice_volume - before.ice_volume - (grown - lost))


def snow_residual(before: ColumnState, after: ColumnState, fluxes: ColumnFluxes) -> Array:
    """Change of snow volume that the named terms do not explain (m), (n, ncat).

    Parameters
    ----------
    before : ColumnState
        Columns at the start and at the end of a step, or of more.
    after : ColumnState
        Columns at the start and at the end of a step, or of more.
    fluxes : ColumnFluxes
        What was moved meanwhile.

    Returns
    -------
    ndarray
        Round-off where the budget closes, but for what remapping moves between categories.
    """
    lost = fluxes.snow_melt + fluxes.sublimation_snow
    return np.asarray(after.snow_volume - before.snow_volume - (fluxes.snowfall - lost))
