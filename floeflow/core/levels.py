# SPDX-License-Identifier: GPL-2.0-or-later
"""Of several levels the one nearest the surface, by what the vertical axis says of itself.

The air's surface is its lowest level, the sea's is its highest; of heights above the ground in
metres it is the one that a quantity is wanted at, as of winds at 2 and 10 m. Which numbers lie
lower is told by ``positive``, by the standard name or by the units; where nothing tells, the file
is refused: the smallest number is the top of the atmosphere as often as its bottom.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floeflow.core import coordinate_kinds as kinds
from floeflow.core import units
from floeflow.core.errors import FloeError

Array = NDArray[np.float64]

# Air higher than this above the ground is no wind or temperature at the surface (m).
HIGHEST = 500.0
# Pressure at sea level and scale height of the standard atmosphere's lowest part (Pa, m).
SEA_LEVEL, SCALE_HEIGHT = 101325.0, 8434.0
DOWN = {
    *("air_pressure", "depth", "atmosphere_sigma_coordinate"),
    "atmosphere_hybrid_sigma_pressure_coordinate",
}
UP = {
    *("height", "altitude", "atmosphere_hybrid_height_coordinate"),
    *("ocean_s_coordinate", "ocean_s_coordinate_g1", "ocean_s_coordinate_g2"),
    "ocean_sigma_coordinate",
}


@dataclass(frozen=True)
class Level:
    """The level that is read.

    Parameters
    ----------
    index : int
        Along the axis.
    said : str
        The level, for people; empty where there is nothing to say.
    """

    index: int
    said: str


def surface(
    axis: str,
    attrs: Mapping[str, Any],
    values: Array,
    ocean: bool,
    what: str,
    wanted: float = 0.0,
) -> Level:
    """The level nearest the surface.

    Parameters
    ----------
    axis : str
        Name of the vertical axis.
    attrs : mapping
        Its attributes.
    values : ndarray
        Its values, (n,).
    ocean : bool
        Whether the quantity belongs to the sea, whose surface is at the top.
    what : str
        File and variable, for the sentence.
    wanted : float
        Height above the ground (m) at which a quantity of the air is wanted.

    Returns
    -------
    Level
        Index along the axis, and the level in words.

    Raises
    ------
    FloeError
        Where the axis does not say which of its ends is the surface, or where the lowest level is
        no surface.
    """
    values = np.atleast_1d(np.asarray(values, dtype=float))
    unit = kinds.text(attrs, "units")
    pressure = kinds.is_pressure(unit)
    length = units.is_length(unit) if unit else None
    if length is not None and (ocean or kinds.text(attrs, "standard_name") != "air_pressure"):
        # Heights and depths count from the surface, whatever their sign.
        index = int(np.argmin(np.abs(np.abs(values) * length - (0.0 if ocean else wanted))))
    elif values.size == 1:
        index = 0
    else:
        down = True if pressure else _positive_down(axis, attrs, what)
        lowest = int(np.argmax(values) if down else np.argmin(values))
        highest = int(np.argmin(values) if down else np.argmax(values))
        index = highest if ocean else lowest
    value = float(values[index])
    said = f"{axis} = {value:g} {unit}".strip()
    height = None if ocean else _height(value, unit, pressure, length, attrs)
    if height is None:
        return Level(index, said)
    if height > HIGHEST:
        raise FloeError(
            f"{what}: its lowest level is {said}, about {height:.0f} m above the ground: no air at "
            "the surface"
        )
    return Level(index, f"{said}, about {max(height, 0.0):.0f} m above the ground")


def _positive_down(axis: str, attrs: Mapping[str, Any], what: str) -> bool:
    positive = kinds.text(attrs, "positive").lower()
    standard = kinds.text(attrs, "standard_name")
    if positive in ("down", "up"):
        return positive == "down"
    if standard in DOWN or standard in UP:
        return standard in DOWN
    raise FloeError(
        f"{what}: its vertical axis '{axis}' does not say which end is the surface: give it the "
        "attribute positive ('up' or 'down')"
    )


def _height(
    value: float, unit: str, pressure: bool, length: float | None, attrs: Mapping[str, Any]
) -> float | None:
    """Height above the ground (m), in the standard atmosphere; None where it cannot be told."""
    if length is not None:
        return abs(value) * length
    if pressure:
        found = units.conversion(unit, "Pa")
        pascal = value * found[0] if found else value
        return SCALE_HEIGHT * math.log(SEA_LEVEL / pascal) if pascal > 0 else None
    if kinds.text(attrs, "standard_name") == "atmosphere_sigma_coordinate" and 0 < value <= 1:
        return SCALE_HEIGHT * math.log(1.0 / value)
    return None
