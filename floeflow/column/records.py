# SPDX-License-Identifier: GPL-2.0-or-later
"""Names for what compiled functions pass around: one element's columns, scratch, and sums.

`FORCING` and `SUMS` name the last axis of the arrays of forcing and of budget terms; compiled code
uses the numbers below, everybody else the names.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from floeflow.column.physics import jit, jit_making

Array = NDArray[np.float64]

FORCING = (
    "potential_temperature",  # of the air (K)
    "humidity",  # kg/kg
    "density",  # of the air (kg/m3)
    "wind",  # m/s
    "longwave",  # downward (W/m2)
    "visible",  # short-wave radiation below 0.7 um, downward (W/m2)
    "infrared",  # above (W/m2)
    "snowfall",  # kg/m2/s
    "sea_salinity",  # 1e-3
    "deep_heat",  # from below the mixed layer, upward (W/m2)
    "mixed_depth",  # m
    "ocean_friction",  # friction velocity under the ice (m/s)
    "rain",  # kg/m2/s
    "diffuse_visible",  # share of the visible light
    "diffuse_infrared",  # share of the rest
    "sun_height",  # cosine of the sun's distance from the zenith
)
(
    POTENTIAL_TEMPERATURE,
    HUMIDITY,
    DENSITY,
    WIND,
    LONGWAVE,
    VISIBLE,
    INFRARED,
    SNOWFALL,
    SEA_SALINITY,
    DEEP_HEAT,
    MIXED_DEPTH,
    OCEAN_FRICTION,
    RAIN,
    DIFFUSE_VISIBLE,
    DIFFUSE_INFRARED,
    SUN_HEIGHT,
) = range(len(FORCING))

FORCING_DEFAULTS = {
    "rain": 0.0,
    "diffuse_visible": 0.24 / 0.52,
    "diffuse_infrared": 0.17 / 0.48,
    "sun_height": math.nan,
}
"""Forcing that may be left out. Shares of diffuse light are those of Icepack's forcing; the height
of the sun is asked for only by light of many directions."""

LEVEL = (
    "level_area",  # share of the ice area that no ridge covers
    "level_volume",  # share of the ice volume
    "pond_area",  # share of the level area under ponds
    "pond_depth",  # m of water
    "pond_lid",  # thickness of ice on ponds (m)
    "lid_snow",  # snow on the ice less snow on the lids, while lids gather snow (m)
    "lid_share",  # of the flux into the surface that melted lids in the last step
)
LEVEL_AREA, LEVEL_VOLUME, POND_AREA, POND_DEPTH, POND_LID, LID_SNOW, LID_SHARE = range(len(LEVEL))

SUMS = (
    "air_to_ice",  # light, long-wave, sensible heat; less what vapour carried off (J/m2)
    "ocean_to_ice",  # at the bottom, the sides, and for ice that is cleared away (J/m2)
    "snowfall_energy",  # of snow on ice, negative (J/m2)
    "new_ice_energy",  # of ice born in open water, negative (J/m2)
    "light_to_sea",  # through the ice (J/m2)
    "air_to_sea",  # in open water (J/m2)
    "deep_to_sea",  # from below (J/m2)
    "vapour_ice",  # leaving (kg/m2)
    "vapour_sea",  # leaving (kg/m2)
    "snowfall",  # on ice (m of snow)
    "growth",  # at the bottom (m)
    "snow_ice",  # made of flooded snow (m of ice)
    "flooded_snow",  # of which it was made (m of snow)
    "melt_top",  # m
    "melt_bottom",  # m
    "melt_lateral",  # m
    "new_ice",  # m
    "cleared_ice",  # of categories too small to keep, melted by the sea (m)
    "sublimation_ice",  # m
    "sublimation_snow",  # m of snow
    "melt_snow",  # at the surface, in the sea, beside leads (m of snow)
    "salt_to_ice",  # of mush: by growth, flooding, drainage and melt (1e-3 m)
    "sweeps",  # iterations of the temperatures
    "solves",  # temperature solves
    "rescued",  # of which the second method did
    "unconverged",  # of which did not come to their tolerance
    "failed",  # of which are too far from a solution to go on
    "pond_gain",  # melt water and rain that ponds caught (m of water)
    "pond_frozen",  # of pond water to lids, less what lids gave (m of water)
    "pond_drained",  # through the ice and its flaws (m of water)
    "pond_lost",  # over edges, with ice that melts; less what spreading ponds made (m of water)
    "light_absorbed",  # by snow, ice and ponds (J/m2)
)
(
    AIR_TO_ICE,
    OCEAN_TO_ICE,
    SNOWFALL_ENERGY,
    NEW_ICE_ENERGY,
    LIGHT_TO_SEA,
    AIR_TO_SEA,
    DEEP_TO_SEA,
    VAPOUR_ICE,
    VAPOUR_SEA,
    SNOWFALL_SUM,
    GROWTH,
    SNOW_ICE,
    FLOODED_SNOW,
    MELT_TOP,
    MELT_BOTTOM,
    MELT_LATERAL,
    NEW_ICE,
    CLEARED_ICE,
    SUBLIMATION_ICE,
    SUBLIMATION_SNOW,
    MELT_SNOW,
    SALT_TO_ICE,
    SWEEPS,
    SOLVES,
    RESCUED,
    UNCONVERGED,
    FAILED,
    POND_GAIN,
    POND_FROZEN,
    POND_DRAINED,
    POND_LOST,
    LIGHT_ABSORBED,
) = range(len(SUMS))


class Column(NamedTuple):
    """Views of one element's categories; volumes per effective area. Of n elements: (n, ...).

    Parameters
    ----------
    area, ice, snow, surface : ndarray
        Fraction, m, m, degC, (ncat,).
    ice_enthalpy, snow_enthalpy, salinity : ndarray
        J/m3, J/m3, 1e-3 of ice, (ncat, layers).
    level : ndarray
        What is in ``LEVEL``, (ncat, len(LEVEL)).
    """

    area: Array
    ice: Array
    snow: Array
    surface: Array
    ice_enthalpy: Array
    snow_enthalpy: Array
    salinity: Array
    level: Array


class Sea(NamedTuple):
    """Mixed layers of n elements.

    Parameters
    ----------
    temperature : ndarray
        degC, (n,).
    pending_freeze : ndarray
        Energy that the mixed layer lacks, of which the next step makes ice (J/m2), (n,).
    """

    temperature: Array
    pending_freeze: Array


class Thickness(NamedTuple):
    """Of the ice and of the snow of a category (m), where there is ice.

    Parameters
    ----------
    ice, snow : float
        m.
    """

    ice: float
    snow: float


class Water(NamedTuple):
    """What ice sees of the sea under it in a step.

    Parameters
    ----------
    freezing : float
        Freezing point, which is the temperature of the ice's bottom (degC).
    salinity : float
        1e-3.
    heat : float
        From the sea into the ice's bottom (W/m2, not negative).
    """

    freezing: float
    salinity: float
    heat: float


class Scratch(NamedTuple):
    """Work arrays of the thickness distribution; (ncat,), (ncat + 1,) or (ncat, layers).

    Parameters
    ----------
    moved : ndarray
        Shifted bounds (m), (ncat + 1,).
    area, volume : ndarray
        Transfers across bounds, upward, (ncat,); the first is not used.
    first_area, first_snow, before : ndarray
        Area and snow before a shift; thickness at the step's start.
    warmth, touched : ndarray
        Area times surface temperature; 1 where a shift took part.
    ice_energy, snow_energy, salt : ndarray
        Volume times enthalpy and salinity, (ncat, layers).
    level : ndarray
        The first five of ``LEVEL`` as amounts per area: level area and volume, pond area, water
        and lids, (ncat, 5).
    """

    moved: Array
    area: Array
    volume: Array
    first_area: Array
    first_snow: Array
    before: Array
    warmth: Array
    touched: Array
    ice_energy: Array
    snow_energy: Array
    salt: Array
    level: Array


@jit_making
def new_scratch(categories: int, ice_layers: int, snow_layers: int) -> Scratch:
    """Return work arrays for a number of categories and layers.

    Parameters
    ----------
    categories : int
        Numbers of categories, of ice layers and of snow layers in each.
    ice_layers : int
        Numbers of categories, of ice layers and of snow layers in each.
    snow_layers : int
        Numbers of categories, of ice layers and of snow layers in each.

    Returns
    -------
    Scratch
        Zeros.
    """
    return Scratch(
        np.zeros(categories + 1),
        np.zeros(categories),
        np.zeros(categories),
        np.zeros(categories),
        np.zeros(categories),
        np.zeros(categories),
        np.zeros(categories),
        np.zeros(categories),
        np.zeros((categories, ice_layers)),
        np.zeros((categories, snow_layers)),
        np.zeros((categories, ice_layers)),
        np.zeros((categories, 5)),
    )


@jit
def column_of(columns: Column, e: int) -> Column:
    """Column of element e among those of all elements, as views.

    For functions that count no references to arrays alone (`physics.jit`).

    Parameters
    ----------
    columns : Column
        Of n elements, (n, ncat) and (n, ncat, layers).
    e : int
        Row of the element.

    Returns
    -------
    Column
        Views, (ncat,) and (ncat, layers).
    """
    return Column(
        columns.area[e],
        columns.ice[e],
        columns.snow[e],
        columns.surface[e],
        columns.ice_enthalpy[e],
        columns.snow_enthalpy[e],
        columns.salinity[e],
        columns.level[e],
    )


@jit
def category_salt(c: Column, n: int) -> float:
    """Salt of category n (1e-3 m).

    Parameters
    ----------
    c : Column
        Categories of the element.
    n : int
        Category.

    Returns
    -------
    float
        Salinity times volume per area of the element.
    """
    salt = 0.0
    for k in range(c.salinity.shape[1]):
        salt += c.salinity[n, k] * c.ice[n] / c.salinity.shape[1]
    return salt


@jit
def category_energy(c: Column, n: int) -> float:
    """Energy of ice and snow of category n (J/m2, negative).

    Parameters
    ----------
    c : Column
        Categories of the element.
    n : int
        Category.

    Returns
    -------
    float
        Per area of the element.
    """
    energy = 0.0
    for k in range(c.ice_enthalpy.shape[1]):
        energy += c.ice_enthalpy[n, k] * c.ice[n] / c.ice_enthalpy.shape[1]
    for k in range(c.snow_enthalpy.shape[1]):
        energy += c.snow_enthalpy[n, k] * c.snow[n] / c.snow_enthalpy.shape[1]
    return energy


@jit
def level_amounts(c: Column, n: int, amounts: np.ndarray) -> None:
    """Level area and volume, pond area, water and lids of category n per area of the element.

    Parameters
    ----------
    c : Column
        Categories of the element.
    n : int
        Category.
    amounts : ndarray
        Filled with what `Scratch` names in ``level``, (5,); areas 1, volumes m.
    """
    area = c.area[n] * c.level[n, LEVEL_AREA]
    pond = area * c.level[n, POND_AREA]
    amounts[LEVEL_AREA] = area
    amounts[LEVEL_VOLUME] = c.ice[n] * c.level[n, LEVEL_VOLUME]
    amounts[POND_AREA] = pond
    amounts[POND_DEPTH] = pond * c.level[n, POND_DEPTH]
    amounts[POND_LID] = pond * c.level[n, POND_LID]


@jit
def unit_share(part: float, whole: float) -> float:
    """Share of a whole, between 0 and 1; 0 of nothing.

    Parameters
    ----------
    part : float
        In one unit; the whole may be 0.
    whole : float
        In one unit; the whole may be 0.

    Returns
    -------
    float
        part / whole.
    """
    return min(max(part / whole, 0.0), 1.0) if whole > 0.0 else 0.0


@jit
def level_shares(c: Column, n: int, amounts: np.ndarray) -> None:
    """Set what `level_amounts` gives back as shares and depths.

    Of a category that has nearly all gone, round-off may leave more level ice than ice.

    Parameters
    ----------
    c : Column
        Its category's ``level`` is set.
    n : int
        Category.
    amounts : ndarray
        Amounts per area of the element as `level_amounts` fills them, (5,).
    """
    area, pond = amounts[LEVEL_AREA], amounts[POND_AREA]
    c.level[n, LEVEL_AREA] = unit_share(area, c.area[n])
    c.level[n, LEVEL_VOLUME] = unit_share(amounts[LEVEL_VOLUME], c.ice[n])
    wet = area > 0.0 and pond > 0.0
    c.level[n, POND_AREA] = unit_share(pond, area) if wet else 0.0
    c.level[n, POND_DEPTH] = amounts[POND_DEPTH] / pond if wet else 0.0
    c.level[n, POND_LID] = amounts[POND_LID] / pond if wet else 0.0


@jit
def category_water(c: Column, n: int) -> float:
    """Water in the ponds of category n (m of water per area of the element).

    Parameters
    ----------
    c : Column
        Categories of the element.
    n : int
        Category.

    Returns
    -------
    float
        Depth times share of the element's area.
    """
    pond = c.area[n] * c.level[n, LEVEL_AREA] * c.level[n, POND_AREA]
    return pond * c.level[n, POND_DEPTH]


@jit
def pond_water(c: Column) -> float:
    """Water in the ponds of all categories (m of water per area of the element).

    Parameters
    ----------
    c : Column
        Categories of the element.

    Returns
    -------
    float
        m.
    """
    water = 0.0
    for n in range(c.area.size):
        water += category_water(c, n)
    return water
