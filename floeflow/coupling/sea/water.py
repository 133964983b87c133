# SPDX-License-Identifier: GPL-2.0-or-later
"""The mixed layer as arrays over the cells of the scene's grid: heat, salt, freezing point.

A cell holds one amount of heat, counted from 0 degC. Above its freezing point that is warmth; what
it lacks to stay there is the heat of which ice will be made (pending freeze). Theory: docs/theory/
sea.md.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.column.params import Settings, zero_layer_params
from floeflow.column.physics import KELVIN, Physics
from floeflow.column.thermodynamics.mush import liquidus

Array = NDArray[np.float64]

OCEAN = Physics()
# Salinity of ice whose scheme keeps none of its own (1e-3; Hunke et al. 2015).
ICE_SALINITY = 4.0
DIMS = ("sea_y", "sea_x")


@dataclass(frozen=True)
class Water:
    """The mixed layer in the cells of the grid.

    Parameters
    ----------
    heat : ndarray
        J per m2 of sea, against water at 0 degC, (cells,).
    salinity, deep_salinity : ndarray
        Of the layer, and of the water below that is mixed into it (1e-3), (cells,).
    area : ndarray
        Of sea (m2), (cells,).
    settings : Settings
        Of the columns: depth of the layer, scheme.
    """

    heat: Array
    salinity: Array
    deep_salinity: Array
    area: Array
    settings: Settings

    @property
    def capacity(self) -> float:
        """Heat that warms it by one kelvin (J/m2/K)."""
        return heat_capacity(self.settings)

    @property
    def freezing(self) -> Array:
        """Freezing points (K), (cells,)."""
        return freezing_points(self.salinity, self.settings)

    @property
    def warmth(self) -> Array:
        """Heat above the freezing point, negative where it lacks some (J/m2), (cells,)."""
        return self.heat - self.capacity * (self.freezing - KELVIN)

    @property
    def total_heat(self) -> float:
        """Heat of the whole sea (J)."""
        return float(self.area @ self.heat)

    @property
    def total_salt(self) -> float:
        """Salt of the whole sea (kg)."""
        return float(self.area @ self.salinity) * 1e-3 * self.mass

    @property
    def mass(self) -> float:
        """Of the layer (kg/m2)."""
        return OCEAN.water_density * self.settings.mixed_layer_depth


def heat_capacity(settings: Settings) -> float:
    """Heat that warms the mixed layer by one kelvin (J/m2/K).

    Parameters
    ----------
    settings : Settings
        What the column is asked for.

    Returns
    -------
    float
        J/m2/K.
    """
    return OCEAN.heat_water * OCEAN.water_density * settings.mixed_layer_depth


def freezing_points(salinity: Array, settings: Settings) -> Array:
    """Freezing points of sea water (K) as the column's scheme has them.

    Zero-layer ice knows one salinity, that of the scene.

    Parameters
    ----------
    salinity : ndarray
        Of the water (1e-3).
    settings : Settings
        Scheme, and the salinity of the scene.

    Returns
    -------
    ndarray
        Of the shape of the salinity.
    """
    if settings.scheme == "zero_layer":
        return np.full_like(salinity, zero_layer_params(settings).freezing_temperature)
    if settings.scheme == "mushy":
        known, index = np.unique(salinity, return_inverse=True)
        points = np.array([liquidus.py_func(value) for value in known])
        return points[index].reshape(salinity.shape) + KELVIN
    return KELVIN - OCEAN.melting_slope * salinity


def split(warmth: Array, freezing: Array, capacity: float) -> tuple[Array, Array]:
    """Temperature (K) and heat that is lacking (J/m2) of water by its heat above freezing.

    Parameters
    ----------
    warmth : ndarray
        Heat above freezing (J/m2); negative where it is lacking.
    freezing : ndarray
        Freezing points (K).
    capacity : float
        Heat capacity of the mixed layer (J/m2/K).

    Returns
    -------
    tuple of ndarray
        Temperature (K) and lack (J/m2), of the shape of ``warmth``.
    """
    return freezing + np.maximum(warmth, 0.0) / capacity, np.maximum(-warmth, 0.0)


def read_water(state: xr.Dataset, area: Array, settings: Settings) -> Water:
    """The sea of a state.

    Parameters
    ----------
    state : xarray.Dataset
        With the variables of the mixed layer.
    area : ndarray
        Sea in the cells (m2), (ny, nx).
    settings : Settings
        Of the columns.

    Returns
    -------
    Water
        Heat (J/m2) above water at 0 degC, salinities (1e-3) and area (m2), (cells,) each.
    """
    temperature, pending, salinity, deep = (
        state[name].values.ravel()
        for name in ("sea_temperature", "pending_freeze", "sea_salinity", "deep_salinity")
    )
    heat = heat_capacity(settings) * (temperature - KELVIN) - pending
    return Water(heat, salinity, deep, area.ravel(), settings)


def with_water(state: xr.Dataset, water: Water) -> xr.Dataset:
    """State whose sea is this one.

    Parameters
    ----------
    state : xarray.Dataset
        Elements and sea.
    water : Water
        The sea, (cells,).

    Returns
    -------
    xarray.Dataset
        A new one; the sea's variables lie on (y, x).
    """
    temperature, pending = split(water.warmth, water.freezing, water.capacity)
    shape = state["sea_temperature"].shape
    values = {
        "sea_temperature": temperature,
        "pending_freeze": pending,
        "sea_salinity": water.salinity,
    }
    return state.assign({name: (DIMS, value.reshape(shape)) for name, value in values.items()})


def gain_heat(water: Water, amount: Array) -> Water:
    """The sea after it got heat (J), (cells,).

    Parameters
    ----------
    water : Water
        The sea, (cells,).
    amount : ndarray
        Heat by cell (J), negative where it is taken.

    Returns
    -------
    Water
        A new one; cells without sea stay.
    """
    safe = np.where(water.area > 0.0, water.area, 1.0)
    return replace(water, heat=water.heat + amount / safe)


def gain_salt(water: Water, amount: Array) -> Water:
    """The sea after it got salt (kg), (cells,).

    Parameters
    ----------
    water : Water
        The sea, (cells,).
    amount : ndarray
        Salt by cell (kg), negative where it is taken.

    Returns
    -------
    Water
        A new one; no salinity is below 0.
    """
    mass = np.where(water.area > 0.0, water.area, 1.0) * water.mass
    return replace(water, salinity=np.maximum(water.salinity + 1e3 * amount / mass, 0.0))


def relax_heat(water: Water, target: Array, seconds: float, time: float) -> tuple[Water, float]:
    """Draw the temperature towards a given one (K) with a time scale (s); heat that came (J).

    Parameters
    ----------
    water : Water
        The sea, (cells,).
    target : ndarray
        Temperature by cell (K), at least the freezing point is taken.
    seconds : float
        Length of the step (s).
    time : float
        Time scale (s).

    Returns
    -------
    tuple of Water and float
        The sea, and the heat that came in all cells (J).
    """
    part = -np.expm1(-seconds / time)
    wanted = water.capacity * (np.maximum(target, water.freezing) - KELVIN)
    gained = part * (wanted - water.heat) * water.area
    return gain_heat(water, gained), float(gained.sum())


def relax_salt(water: Water, seconds: float, time: float) -> tuple[Water, float]:
    """Mix in water from below with a time scale (s); salt that came with it (kg).

    Parameters
    ----------
    water : Water
        The sea, (cells,).
    seconds : float
        Length of the step (s).
    time : float
        Time scale (s).

    Returns
    -------
    tuple of Water and float
        The sea, and the salt that came in all cells (kg).
    """
    part = -np.expm1(-seconds / time)
    gained = part * (water.deep_salinity - water.salinity) * 1e-3 * water.mass * water.area
    return gain_salt(water, gained), float(gained.sum())
