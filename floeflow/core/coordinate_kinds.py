# SPDX-License-Identifier: GPL-2.0-or-later
"""What a coordinate variable is, by its CF attributes, or by names that are in wide use."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from floeflow.core import units

LATITUDE_UNITS = {"degrees_north", "degree_north", "degrees_n", "degree_n", "degreen", "degreesn"}
LONGITUDE_UNITS = {"degrees_east", "degree_east", "degrees_e", "degree_e", "degreee", "degreese"}
VERTICAL = {
    *("depth", "height", "altitude", "air_pressure", "model_level_number", "ocean_layer"),
    *("atmosphere_sigma_coordinate", "atmosphere_hybrid_sigma_pressure_coordinate"),
    *("atmosphere_hybrid_height_coordinate", "atmosphere_sleve_coordinate"),
    *("atmosphere_ln_pressure_coordinate", "height_above_reference_ellipsoid"),
    *("ocean_s_coordinate", "ocean_s_coordinate_g1", "ocean_s_coordinate_g2"),
    *("ocean_sigma_coordinate", "ocean_sigma_z_coordinate", "ocean_double_sigma_coordinate"),
}
# Names of vertical axes that come without any attribute that tells what they are.
LEVEL_NAMES = {
    *("lev", "level", "levels", "plev", "pressure_level", "isobaricinhpa", "isobaric"),
    *(
        "model_level",
        "hybrid",
        "depth",
        "deptht",
        "depthu",
        "depthv",
        "z",
        "zlev",
        "s_rho",
        "sigma",
    ),
    *("heightaboveground", "height", "altitude", "alt"),
}
_SECONDS = {
    **dict.fromkeys(("second", "seconds", "sec", "secs", "s"), 1.0),
    **dict.fromkeys(("minute", "minutes", "min", "mins"), 60.0),
    **dict.fromkeys(("hour", "hours", "hr", "hrs", "h"), 3600.0),
    **dict.fromkeys(("day", "days", "d"), 86400.0),
}


def seconds_in(unit: str) -> float | None:
    """Seconds in a unit of time; None where it is none.

    Parameters
    ----------
    unit : str
        As in ``seconds since ...``, or alone.

    Returns
    -------
    float or None
        s.
    """
    return _SECONDS.get(unit.strip().lower())


def text(attrs: Mapping[str, Any], name: str) -> str:
    """An attribute as stripped text, empty where there is none.

    Parameters
    ----------
    attrs : mapping of object
        Attributes of a variable.
    name : str
        Of the attribute.

    Returns
    -------
    str
        Without blanks at its ends.
    """
    return str(attrs.get(name, "")).strip()


def kind_of(name: str, attrs: Mapping[str, Any]) -> str:
    """latitude, longitude, projected x or y, time, level, or empty.

    Parameters
    ----------
    name : str
        Of the variable.
    attrs : mapping
        Its attributes.

    Returns
    -------
    str
        One of these words; empty for any other variable.
    """
    standard, unit = text(attrs, "standard_name"), text(attrs, "units").lower()
    name = name.lower()
    if standard in ("grid_latitude", "grid_longitude"):
        return ""  # of a rotated pole, though many files give them the units of true ones
    if standard == "latitude" or unit in LATITUDE_UNITS or name in ("lat", "latitude"):
        return "latitude"
    if standard == "longitude" or unit in LONGITUDE_UNITS or name in ("lon", "longitude"):
        return "longitude"
    if standard in ("projection_x_coordinate", "projection_y_coordinate"):
        return f"projected {standard[11]}"
    if standard == "time" or " since " in unit or unit.startswith(("day as %", "days as %")):
        return "time"
    if standard in VERTICAL or text(attrs, "axis") == "Z" or "positive" in attrs:
        return "level"
    if unit and name in ("x", "xc", "y", "yc", "xgrid", "ygrid", "x_coord", "y_coord"):
        return f"projected {name[0]}" if units.is_length(unit) else ""
    if name in LEVEL_NAMES or (unit and name not in ("x", "y") and is_pressure(unit)):
        return "level"
    return ""


def is_pressure(unit: str) -> bool:
    """Whether these are units of pressure.

    Parameters
    ----------
    unit : str
        As in a file.

    Returns
    -------
    bool
        True for Pa, hPa, mbar and their names.
    """
    return unit.lower() in {
        *("pa", "pascal", "pascals", "hpa", "mb", "mbar", "millibar", "millibars", "hectopascals"),
    }


def standard_name(name: str, attrs: Mapping[str, Any]) -> str:
    """The CF standard name that says what `kind_of` found.

    Parameters
    ----------
    name : str
        Of the variable.
    attrs : mapping of object
        Its attributes.

    Returns
    -------
    str
        Empty where nothing tells.
    """
    found = kind_of(name, attrs)
    if found.startswith("projected"):
        return f"projection_{found[-1]}_coordinate"
    return text(attrs, "standard_name") or found
