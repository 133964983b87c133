# SPDX-License-Identifier: GPL-2.0-or-later
"""Zero-layer thermodynamics (Semtner 1976, appendix): ice and snow that hold no heat.

The cheap scheme. Temperature is linear through ice and through snow, from the freezing point at
the bottom to the surface, whose temperature balances conduction with the weather. The conductive
flux out of the bottom is defined by what the surface gave, so that a step conserves energy to
round-off however well the balance was solved. docs/theory/column.md has the equations.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from floeflow.column.ocean.slab import Sea, heat_to_ice, mix
from floeflow.column.params import ColumnParams
from floeflow.column.state import Array, ColumnFluxes, ColumnForcing, ColumnState
from floeflow.column.thermodynamics.surface import balance, ice_albedo, surface_fluxes
from floeflow.core.errors import FloeError


@dataclass(frozen=True)
class _Vertical:
    """Outcome of one step at top and bottom: volumes and terms per A (m), heat (J/m2)."""

    ice: Array
    snow: Array
    temperature: Array
    growth_base: Array
    melt_top: Array
    melt_base: Array
    sublimation_ice: Array
    sublimation_snow: Array
    snowfall: Array
    snow_melt: Array
    energy: Array  # from the atmosphere
    spare: Array  # found no ice to melt


def step(
    state: ColumnState, forcing: ColumnForcing, dt: float, params: ColumnParams
) -> tuple[ColumnState, ColumnFluxes]:
    """Advance columns over a sea that stays at its freezing point by one step.

    Parameters
    ----------
    state : ColumnState
        Columns at the start, (n, ncat); the first category is the thinnest.
    forcing : ColumnForcing
        Mean weather of the step, (n,).
    dt : float
        Step (s).
    params : ColumnParams
        Constants.

    Returns
    -------
    tuple of ColumnState and ColumnFluxes
        Columns at the end, and the terms of the budgets.

    Raises
    ------
    FloeError
        Where a category has ice but no area.
    """
    after, _, fluxes = step_with_sea(state, None, forcing, dt, params)
    return after, fluxes


def step_with_sea(
    state: ColumnState, sea: Sea | None, forcing: ColumnForcing, dt: float, params: ColumnParams
) -> tuple[ColumnState, Sea | None, ColumnFluxes]:
    """Advance columns by one step, with a mixed layer where one is given; see `step`.

    A mixed layer takes what air and ice give it and keeps it: `energy_to_ocean` is zero then, and
    `energy_ocean` is what comes from below the layer.

    Parameters
    ----------
    state : ColumnState
        Columns at the start, (n, ncat).
    sea : Sea or None
        Mixed layer at the start, (n,).
    forcing : ColumnForcing
        Mean weather of the step, (n,).
    dt : float
        s.
    params : ColumnParams
        Constants.

    Returns
    -------
    state : ColumnState
        Columns at the end, (n, ncat).
    sea : Sea or None
        Mixed layer at the end, (n,); None where none was given.
    fluxes : ColumnFluxes
        Budget terms of the step, over the element's area, (n,) each.

    Raises
    ------
    FloeError
        Where a category has ice but no area.
    """
    lost = (state.ice_volume > 0.0) & ~(state.ice_fraction > 0.0)
    if lost.any():
        element, category = np.argwhere(lost)[0]
        raise FloeError(f"column: element {element} has ice without area in category {category}")

    area = np.where(state.ice_volume > 0.0, state.ice_fraction, 0.0)
    open_water = np.maximum(1.0 - area.sum(axis=1), 0.0)
    whole = area.sum(axis=1) + open_water
    water_temperature = np.full(len(open_water), params.freezing_temperature)
    bottom, side = forcing.ocean_heat_flux, np.zeros(len(open_water))
    if sea is not None:
        stored = _melting_energy(state.ice_volume, state.snow_volume, params)
        bottom, side = heat_to_ice(sea, forcing.friction_velocity, stored, dt, params)
        water_temperature = sea.temperature

    vertical = _top_and_bottom(state, area, bottom, forcing, dt, params)
    exists = vertical.ice > 0.0
    area = np.where(exists, area, 0.0)
    # Snow whose ice is gone melts in the sea and takes its heat.
    drowned = np.where(exists, 0.0, vertical.snow)
    snow = vertical.snow - drowned
    to_sea = (vertical.spare - params.snow_energy * drowned).sum(axis=1)

    albedo = params.keys.albedo_ocean
    lead = surface_fluxes(water_temperature[:, None], forcing, albedo, False, params)
    lead_net = lead.net[:, 0]
    lead_heat = (lead_net - params.latent_fusion * forcing.snowfall) * open_water * dt
    if sea is None:
        lead_heat = lead_heat + forcing.ocean_heat_flux * open_water * dt
        lack = np.maximum(-lead_heat, 0.0)
        share, unused = _lateral_share(np.maximum(lead_heat, 0.0), vertical.ice, snow, params)
        to_sea = to_sea + unused - (0.0 if params.frazil else lack)
    else:
        lack, share = sea.pending_freeze, (1.0 - side)[:, None]

    ice, snow_left, area = vertical.ice * share, snow * share, area * share
    melt_lateral, snow_lateral = vertical.ice - ice, snow - snow_left
    new_ice, born = _freeze(lack, area, params)
    ice, total = ice + new_ice, area + born
    # Ice that is born where no water is left free only thickens what is there.
    warmth = area * vertical.temperature + born * params.freezing_temperature
    temperature = np.where(
        ice > 0.0, warmth / np.where(total > 0.0, total, 1.0), params.freezing_temperature
    )
    temperature = np.minimum(temperature, params.melting_temperature)

    seconds = dt * whole
    deep = forcing.ocean_heat_flux * seconds
    if sea is not None:
        given = bottom * (whole - open_water) * dt
        melted = _melting_energy(melt_lateral, snow_lateral, params)
        heat = lead_heat + to_sea - given - melted
        sea, deep = mix(sea, heat, forcing.ocean_heat_flux, dt, params)
        to_sea = np.zeros_like(to_sea)
    after = ColumnState(np.minimum(total, 1.0), ice, snow_left, temperature)
    fluxes = ColumnFluxes(
        energy_atmosphere=vertical.energy.sum(axis=1) + lead_net * open_water * dt,
        energy_ocean=deep,
        energy_snowfall=-params.latent_fusion * forcing.snowfall * seconds,
        energy_to_ocean=to_sea,
        growth_base=vertical.growth_base,
        new_ice=new_ice,
        melt_top=vertical.melt_top,
        melt_base=vertical.melt_base,
        melt_lateral=melt_lateral,
        sublimation_ice=vertical.sublimation_ice,
        sublimation_snow=vertical.sublimation_snow,
        snowfall=vertical.snowfall,
        snow_melt=vertical.snow_melt + drowned + snow_lateral,
    )
    return after, sea, fluxes


def _melting_energy(ice: Array, snow: Array, params: ColumnParams) -> Array:
    """Energy that melts all ice and snow (J/m2), (n,)."""
    return np.asarray((params.ice_energy * ice + params.snow_energy * snow).sum(axis=1))


def _freeze(lack: Array, area: Array, params: ColumnParams) -> tuple[Array, Array]:
    """Volume and area of the ice that a lack of heat (J/m2) makes in the thinnest category."""
    new_ice, born = np.zeros_like(area), np.zeros_like(area)
    if params.frazil:
        new_ice[:, 0] = lack / params.ice_energy
        free = np.maximum(1.0 - area.sum(axis=1), 0.0)
        born[:, 0] = np.minimum(new_ice[:, 0] / params.new_ice_thickness, free)
    return new_ice, born


def _top_and_bottom(
    state: ColumnState,
    area: Array,
    ocean: Array,
    forcing: ColumnForcing,
    dt: float,
    params: ColumnParams,
) -> _Vertical:
    """Grow, snow, sublimate and melt each category, in this order, within its own area."""
    exists = area > 0.0
    per_area = 1.0 / np.where(exists, area, 1.0)
    # A stand-in of 1 m where there is no ice: its fluxes are multiplied by no area.
    h_ice = np.where(exists, state.ice_volume * per_area, 1.0)
    h_snow = np.where(exists, state.snow_volume * per_area, 0.0)
    albedo = ice_albedo(h_ice, h_snow, state.surface_temperature, params)
    keys = params.keys
    conductance = 1.0 / (h_ice / keys.ice_conductivity + h_snow / keys.snow_conductivity)
    temperature, excess, flux = balance(
        state.surface_temperature, conductance, forcing, albedo, params
    )
    conducted = excess - flux.net  # upward, W/m2
    bottom = (ocean[:, None] - conducted) * dt * area
    heat = excess * dt * area
    vapour = flux.vapour * dt * area

    growth_base = np.maximum(-bottom, 0.0) / params.ice_energy
    snowfall = forcing.snowfall[:, None] / params.snow_density * dt * area
    ice = state.ice_volume + growth_base
    snow = state.snow_volume + snowfall

    leaves, arrives = np.maximum(vapour, 0.0), np.maximum(-vapour, 0.0)
    snow_gone = np.minimum(leaves / params.snow_density, snow)
    leaves = np.maximum(leaves - snow_gone * params.snow_density, 0.0)
    ice_gone = np.minimum(leaves / params.ice_density, ice)
    leaves = np.maximum(leaves - ice_gone * params.ice_density, 0.0)
    # Vapour for which no ice is left comes from the sea and needs no heat of fusion.
    heat = heat + params.latent_fusion * leaves
    hoar = snow > 0.0
    sublimation_snow = snow_gone - np.where(hoar, arrives / params.snow_density, 0.0)
    sublimation_ice = ice_gone - np.where(hoar, 0.0, arrives / params.ice_density)
    # Subtracted term by term: what is taken whole leaves an exact zero.
    snow = snow - snow_gone + np.where(hoar, arrives / params.snow_density, 0.0)
    ice = ice - ice_gone + np.where(hoar, 0.0, arrives / params.ice_density)

    snow_melt, heat = _melt(heat, snow, params.snow_energy)
    snow = snow - snow_melt
    melt_top, heat = _melt(heat, ice, params.ice_energy)
    ice = ice - melt_top
    heat = heat + np.maximum(bottom, 0.0)
    melt_base, spare = _melt(heat, ice, params.ice_energy)
    ice = ice - melt_base

    return _Vertical(
        ice=ice,
        snow=snow,
        temperature=temperature,
        growth_base=growth_base,
        melt_top=melt_top,
        melt_base=melt_base,
        sublimation_ice=sublimation_ice,
        sublimation_snow=sublimation_snow,
        snowfall=snowfall,
        snow_melt=snow_melt,
        energy=flux.net * dt * area + params.latent_fusion * vapour,
        spare=spare,
    )


def _melt(heat: Array, volume: Array, energy: float) -> tuple[Array, Array]:
    """Volume that heat (J/m2) melts of what is there, and the heat left over."""
    melted = np.minimum(heat / energy, volume)
    return melted, np.maximum(heat - melted * energy, 0.0)


def _lateral_share(
    heat: Array, ice: Array, snow: Array, params: ColumnParams
) -> tuple[Array, Array]:
    """Share of every category that the heat of the lead leaves, (n, 1), and the heat unused.

    The sides melt at constant thickness: area, ice and snow go in one proportion.
    """
    if not params.lateral_melt:
        return np.ones((len(heat), 1)), heat
    stored = _melting_energy(ice, snow, params)
    gone = np.where(heat < stored, heat / np.where(stored > 0.0, stored, 1.0), 1.0)
    return (1.0 - gone)[:, None], np.maximum(heat - stored, 0.0)
