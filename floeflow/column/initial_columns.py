# SPDX-License-Identifier: GPL-2.0-or-later
"""Columns at a start, and the temperatures of their layers.

Ice goes into the categories that hold its thickness. Its layers and the snow on it have the
temperatures of steady conduction between the surface and the freezing sea.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba
import numpy as np

from floeflow.column.first_thickness import DISTRIBUTIONS, FirstIce
from floeflow.column.kernel import sources_digest
from floeflow.column.layered_run import freezing_point, layered_physics
from floeflow.column.params import Settings
from floeflow.column.physics import KELVIN, as_records
from floeflow.column.records import LEVEL
from floeflow.column.state import Array
from floeflow.column.thermodynamics.enthalpy import (
    ice_enthalpy,
    ice_temperature,
    salinity_profile,
    snow_enthalpy,
    snow_temperature,
)
from floeflow.column.thermodynamics.mush import liquid_fraction, mush_enthalpy, mush_temperature
from floeflow.column.thickness.categories import category_bounds

Columns = dict[str, Array]

SNOW_LAYERS = 1


def _build(digest: str) -> Callable[..., Any]:
    @numba.njit(cache=True, error_model="numpy")
    def convert(
        values: np.ndarray, salinity: np.ndarray, snow: bool, inverse: bool, constants: np.ndarray
    ) -> np.ndarray:
        """Enthalpies (J/m3) of layers of given temperatures (degC), or ``inverse``; (n,)."""
        digest  # noqa: B018  (part of the key under which Numba caches)
        p = constants[0]
        result = np.zeros_like(values)
        for k in range(values.size):
            value, salt = values[k], salinity[k]
            if snow:
                result[k] = snow_temperature(value, p) if inverse else snow_enthalpy(value, p)
            elif p.mushy:
                if inverse:
                    result[k] = mush_temperature(value, salt, p)
                else:
                    result[k] = mush_enthalpy(value, liquid_fraction(value, salt), p)
            elif inverse:
                result[k] = ice_temperature(value, -p.melting_slope * salt, p)
            else:
                result[k] = ice_enthalpy(value, -p.melting_slope * salt, p)
        return result

    return convert


_convert = _build(sources_digest())


def _layers(values: Array, salinity: Array, snow: bool, inverse: bool, p: Any) -> Array:
    salt = np.ascontiguousarray(np.broadcast_to(salinity, values.shape)).ravel()
    flat = _convert(np.ascontiguousarray(values).ravel(), salt, snow, inverse, as_records(p))
    return np.asarray(flat).reshape(values.shape)


def layer_temperatures(columns: Columns, settings: Settings) -> tuple[Array, Array]:
    """Temperatures (K) of snow and ice layers, top first, NaN where there is none.

    Parameters
    ----------
    columns : dict of ndarray
        By the names of the state's schema, layered.
    settings : Settings
        Scheme and layers.

    Returns
    -------
    tuple of ndarray
        (n, ncat, snow layers) and (n, ncat, ice layers).
    """
    p = layered_physics(settings)
    profile = salinity_profile(settings.layers, p)
    salinity = columns.get("ice_salinity", profile)
    ice = _layers(columns["ice_enthalpy"], salinity, False, True, p) + KELVIN
    ice[columns["ice_volume"] <= 0.0] = np.nan
    shape = (*ice.shape[:2], SNOW_LAYERS)
    snow = np.full(shape, np.nan)
    if "snow_enthalpy" in columns:
        snow = _layers(columns["snow_enthalpy"], np.zeros(1), True, True, p) + KELVIN
        snow[columns["snow_volume"] <= 0.0] = np.nan
    return snow, ice


# All ice of an element as thick as its mean, level, between open leads.
ONE_THICKNESS = FirstIce()
# Share of ice from which on open water counts as leads in a closed pack.
PACK = 0.8


def first_columns(
    fraction: Array,
    volume: Array,
    snow: Array,
    surface: float,
    settings: Settings,
    first: FirstIce = ONE_THICKNESS,
) -> Columns:
    """Columns of each element's ice, and of the young ice on its leads.

    Parameters
    ----------
    fraction, volume : ndarray
        Ice-covered share, and ice volume per area (m), (n,).
    snow : ndarray
        Snow thickness on the ice (m), (n,).
    surface : float
        Temperature of the surface (K), not above the freezing point.
    settings : Settings
        Which categories and layers there are, and which processes.
    first : FirstIce
        Distribution of the thickness, level share, and young ice on leads.

    Returns
    -------
    dict of ndarray
        All variables that columns can have, whether the settings ask for them or not.
    """
    thickness = np.divide(volume, fraction, out=np.zeros_like(volume), where=fraction > 0.0)
    spread = DISTRIBUTIONS[first.distribution](
        thickness, category_bounds(settings.categories), first.level_share
    )
    shape = (len(fraction), settings.categories)
    share = fraction[:, None] * spread.area
    ice_volume = volume[:, None] * spread.volume
    snow_volume = (snow * fraction)[:, None] * spread.area
    level_area, level_volume = spread.level_area, spread.level_volume
    if first.lead_ice > 0.0:
        leads = np.where(fraction >= PACK, 1.0 - fraction, 0.0)
        young = leads * first.lead_ice
        level_area = _with_level(level_area, share[:, 0], leads)
        level_volume = _with_level(level_volume, ice_volume[:, 0], young)
        share[:, 0] += leads
        ice_volume[:, 0] += young
    there = share > 0.0
    ice, cover = (
        np.divide(v, share, out=np.zeros(shape), where=there) for v in (ice_volume, snow_volume)
    )
    freezing = freezing_point(settings) + KELVIN
    top = np.full(shape, min(surface, freezing))
    columns = {
        "ice_fraction": share,
        "ice_volume": ice_volume,
        "snow_volume": snow_volume,
        "surface_temperature": top if settings.scheme != "zero_layer" else np.full(shape, freezing),
        "sea_temperature": np.full(shape[0], freezing),
        "pending_freeze": np.zeros(shape[0]),
    }
    if settings.scheme == "zero_layer":
        return columns
    columns |= dict.fromkeys(LEVEL, np.zeros(shape))
    columns |= {"level_area": level_area * there, "level_volume": level_volume * there}
    return columns | _first_layers(ice, cover, min(surface, freezing), settings)


def _with_level(level: Array, before: Array, added: Array) -> Array:
    """Level share of categories (1) after level ice was added to the first, (n, ncat)."""
    found, total = level.copy(), before + added
    np.divide(level[:, 0] * before + added, total, out=found[:, 0], where=total > 0.0)
    return found


def _first_layers(ice: Array, snow: Array, top: float, settings: Settings) -> Columns:
    p = layered_physics(settings)
    freezing = freezing_point(settings) + KELVIN
    through_ice = ice / p.fresh_conductivity
    through_snow = snow / p.snow_conductivity * settings.has("snow")
    whole = np.where(ice > 0.0, through_ice + through_snow, 1.0)
    middles = (np.arange(settings.layers) + 0.5) / settings.layers
    depth = through_snow[..., None] + through_ice[..., None] * middles
    ice_kelvin = top + (freezing - top) * depth / whole[..., None]
    snow_kelvin = top + (freezing - top) * (0.5 * through_snow / whole)[..., None]
    there = (ice > 0.0)[..., None]
    salinity = np.broadcast_to(salinity_profile(settings.layers, p), ice_kelvin.shape) * there
    none = np.zeros(1)
    return {
        "ice_enthalpy": _layers(ice_kelvin - KELVIN, salinity, False, False, p) * there,
        "ice_salinity": salinity,
        "snow_enthalpy": _layers(snow_kelvin - KELVIN, none, True, False, p)
        * (snow > 0.0)[..., None],
    }
