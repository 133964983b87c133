# SPDX-License-Identifier: GPL-2.0-or-later
"""The slab mixed layer under zero-layer ice, as arrays over elements.

The same equations as `floeflow.column.ocean.ocean` has for one layered column, with its constants
(Hunke et al. 2015): ice in layers and ice without float on the same sea.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from floeflow.column.params import ColumnParams
from floeflow.column.physics import TINY, Physics
from floeflow.column.state import Array

OCEAN = Physics()


@dataclass(frozen=True)
class Sea:
    """Mixed layer of n elements.

    Parameters
    ----------
    temperature : ndarray
        K, (n,).
    pending_freeze : ndarray
        Heat that it lacks, of which the next step makes ice (J/m2), (n,).
    """

    temperature: Array
    pending_freeze: Array


def heat_capacity(params: ColumnParams) -> float:
    """Heat that warms the mixed layer by one kelvin (J/m2/K).

    Parameters
    ----------
    params : ColumnParams
        Depth (m), density (kg/m3) and heat capacity (J/kg/K) of the mixed layer.

    Returns
    -------
    float
        J/m2/K.
    """
    return OCEAN.heat_water * OCEAN.water_density * params.mixed_layer_depth


def sea_energy(sea: Sea, params: ColumnParams) -> Array:
    """Heat of the mixed layer above its freezing point, less what it lacks (J/m2), (n,).

    Parameters
    ----------
    sea : Sea
        Mixed layer, (n,).
    params : ColumnParams
        Its depth, and the freezing point.

    Returns
    -------
    ndarray
        (n,).
    """
    warmer = sea.temperature - params.freezing_temperature
    return np.asarray(heat_capacity(params) * warmer - sea.pending_freeze)


def heat_to_ice(
    sea: Sea, friction: Array, stored: Array, dt: float, params: ColumnParams
) -> tuple[Array, Array]:
    """Heat into the ice's bottom (W/m2) and the share of the ice that melts from its sides.

    Maykut and McPhee (1995), Maykut and Perovich (1987), Steele (1992); theory of the layered
    column, eqs. 20 to 22: together no more than the mixed layer has.

    Parameters
    ----------
    sea : Sea
        Mixed layer.
    friction : ndarray
        Friction velocity under the ice (m/s), (n,).
    stored : ndarray
        Energy that melts all ice and snow (J/m2), (n,).
    dt : float
        s.
    params : ColumnParams
        Constants.

    Returns
    -------
    bottom, side : ndarray
        Heat flux into the bottom, W/m2 of ice, and the share of the ice (0..1) that the step melts
        from its sides, (n,) each.
    """
    warmer = np.maximum(sea.temperature - params.freezing_temperature, 0.0)
    most = np.minimum(warmer * heat_capacity(params) / dt, OCEAN.largest_potential)
    most = np.where(sea.pending_freeze > 0.0, 0.0, most)
    speed = np.maximum(friction, OCEAN.least_friction_velocity)
    exchange = OCEAN.heat_water * OCEAN.water_density * params.keys.ocean_transfer * speed
    bottom = np.minimum(exchange * warmer, most)
    if not params.lateral_melt:
        return bottom, np.zeros_like(bottom)
    rate = OCEAN.lateral_rate * warmer**OCEAN.lateral_power
    side = np.minimum(rate * dt * np.pi / (OCEAN.floe_shape * params.keys.floe_diameter), 1.0)
    side = np.where(most > 0.0, side, 0.0)
    share = np.minimum(most / (bottom + side * stored / dt + TINY), 1.0)
    return bottom * share, side * share


def mix(sea: Sea, heat: Array, deep: Array, dt: float, params: ColumnParams) -> tuple[Sea, Array]:
    """Advance the mixed layer (theory of the layered column, eqs. 25 and 26).

    Parameters
    ----------
    sea : Sea
        Mixed layer, whose pending freeze has become ice.
    heat : ndarray
        From air and ice (J/m2), (n,).
    deep : ndarray
        From below (W/m2), (n,).
    dt : float
        s.
    params : ColumnParams
        Constants.

    Returns
    -------
    tuple of Sea and ndarray
        Mixed layer, and the heat that came from below (J/m2).
    """
    capacity, freezing = heat_capacity(params), params.freezing_temperature
    temperature = sea.temperature + heat / capacity
    # Warm water is mixed down; where there is none left, none is, and no ice is made of it.
    most = np.minimum(freezing - temperature, 0.0) * capacity
    taken = np.where(deep < 0.0, np.maximum(deep * dt, most), deep * dt)
    temperature = temperature + taken / capacity
    lacking = (freezing - temperature) * capacity
    pending = np.clip(lacking, 0.0, OCEAN.largest_potential * dt)
    # What exceeds the largest potential stays in the water as supercooling.
    temperature = np.where(pending > 0.0, freezing - (lacking - pending) / capacity, temperature)
    if not params.frazil:
        # No ice may be made of it: the heat comes from below.
        taken, pending = taken + pending, np.zeros_like(pending)
    return Sea(temperature, pending), taken


def chill(sea: Sea, energy: Array, capacity: float, freezing: float) -> Sea:
    """Take energy (J/m2, not negative) from the mixed layer: what it lacks will freeze.

    Parameters
    ----------
    sea : Sea
        Mixed layer.
    energy : ndarray
        J/m2, (n,).
    capacity : float
        `heat_capacity` (J/m2/K).
    freezing : float
        Freezing point (K).

    Returns
    -------
    Sea
        Not below the freezing point; what was lacking is added to its pending freeze (J/m2).
    """
    temperature = sea.temperature - energy / capacity
    lacking = np.where(energy > 0.0, np.maximum(freezing - temperature, 0.0), 0.0)
    return Sea(temperature + lacking, sea.pending_freeze + lacking * capacity)
