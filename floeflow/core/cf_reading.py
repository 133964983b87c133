# SPDX-License-Identifier: GPL-2.0-or-later
"""What is in a NetCDF file: variables by CF standard name, dimensions by their role, projection.

Only attributes are read here, with netCDF4 alone: the front door calls this before any job.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import netCDF4
import pyproj
from pyproj.exceptions import CRSError

from floeflow.core.errors import FloeError

_LAT_UNITS = {"degrees_north", "degree_north", "degrees_n", "degree_n", "degreen", "degreesn"}
_LON_UNITS = {"degrees_east", "degree_east", "degrees_e", "degree_e", "degreee", "degreese"}
_LENGTHS = {"m": 1.0, "metre": 1.0, "meter": 1.0, "metres": 1.0, "meters": 1.0, "": 1.0}
_LENGTHS |= {"km": 1e3, "kilometre": 1e3, "kilometer": 1e3, "kilometres": 1e3, "kilometers": 1e3}
_VERTICAL = {"depth", "height", "altitude", "air_pressure", "ocean_s_coordinate"}


@dataclass(frozen=True)
class Variable:
    """A variable's name, dimensions, shape and attributes."""

    name: str
    dims: tuple[str, ...]
    shape: tuple[int, ...]
    attrs: dict[str, Any]

    def text(self, attribute: str) -> str:
        """An attribute as stripped text, empty where there is none."""
        return str(self.attrs.get(attribute, "")).strip()


@dataclass(frozen=True)
class Layout:
    """Roles of a variable's dimensions.

    Parameters
    ----------
    x, y : str
        Names of the horizontal coordinate variables: longitude and latitude, or projected.
    lonlat : bool
        Whether they are longitude and latitude.
    time, level : str
        Names of the time and vertical dimension, empty where there is none.
    scale : float
        Metres in the unit of a projected coordinate.
    """

    x: str
    y: str
    lonlat: bool
    time: str
    level: str
    scale: float = 1.0


def describe(path: str | Path) -> dict[str, Variable]:
    """Variables of a NetCDF file.

    Raises
    ------
    FloeError
        Where the file is missing or cannot be read as NetCDF.
    """
    path = Path(path)
    if not path.is_file():
        raise FloeError(f"{path}: there is no such file")
    try:
        with netCDF4.Dataset(path) as file:
            return {
                name: Variable(
                    name,
                    tuple(variable.dimensions),
                    tuple(variable.shape),
                    {key: variable.getncattr(key) for key in variable.ncattrs()},
                )
                for name, variable in file.variables.items()
            }
    except Exception as error:  # a damaged HDF5 file raises whatever its bytes lead to
        raise FloeError(f"{path}: cannot be read as NetCDF ({type(error).__name__})") from None


def named(variables: dict[str, Variable], name: str, path: str | Path, key: str) -> Variable:
    """The variable of this name.

    Raises
    ------
    FloeError
        Where there is none; names the nearest one and the scene's key that asked for it.
    """
    if name in variables:
        return variables[name]
    near = get_close_matches(name, variables, n=1)
    hint = f"did you mean '{near[0]}'?" if near else "it has " + _listed(variables)
    raise FloeError(f"{path}: {key} asks for variable '{name}', which is not there; {hint}")


def _listed(variables: Iterable[str]) -> str:
    names = list(variables)
    return ", ".join(names[:12]) + (" ..." if len(names) > 12 else "")


def by_standard_name(variables: dict[str, Variable], standard_name: str) -> list[Variable]:
    """Variables that carry this CF standard name."""
    return [item for item in variables.values() if item.text("standard_name") == standard_name]


def layout(variables: dict[str, Variable], variable: Variable, path: str | Path) -> Layout:
    """Find which dimension of a variable is which.

    Raises
    ------
    FloeError
        Where two horizontal dimensions are not found, or others than time and level are longer
        than one.
    """
    roles: dict[str, str] = {}
    for dim in variable.dims:
        role = dimension_kind(variables, dim)
        if role in roles:
            raise FloeError(f"{path}: variable '{variable.name}' has two dimensions of {role}")
        if role:
            roles[role] = dim
    for dim, size in zip(variable.dims, variable.shape, strict=True):
        if size > 1 and dim not in roles.values():
            _refuse_dims(variables, variable, path)
    for y, x, lonlat in (("latitude", "longitude", True), ("projected y", "projected x", False)):
        if x in roles and y in roles:
            scale = 1.0 if lonlat else _length(variables[roles[x]], path)
            time, level = roles.get("time", ""), roles.get("level", "")
            return Layout(roles[x], roles[y], lonlat, time, level, scale)
    _refuse_dims(variables, variable, path)
    raise AssertionError  # not reached


def _refuse_dims(variables: dict[str, Variable], variable: Variable, path: str | Path) -> None:
    dims = ", ".join(variable.dims)
    said = f"{path}: variable '{variable.name}' has dimensions ({dims})"
    if "latitude" in {_kind(item) for item in variables.values() if len(item.dims) == 2}:
        raise FloeError(
            f"{said} on a curvilinear grid, whose latitudes are two-dimensional; put it on a grid "
            "of longitude and latitude, or of projected x and y, first"
        )
    raise FloeError(f"{said}, which are not longitude and latitude, or projected x and y")


def dimension_kind(variables: dict[str, Variable], dim: str) -> str:
    """What a dimension is: latitude, longitude, projected x or y, time, level; or empty."""
    coordinate = variables.get(dim)
    if coordinate is None or coordinate.dims != (dim,):
        return ""
    return _kind(coordinate)


def _kind(item: Variable) -> str:
    standard, units = item.text("standard_name"), item.text("units").lower()
    name = item.name.lower()
    if standard == "latitude" or units in _LAT_UNITS or name in ("lat", "latitude"):
        return "latitude"
    if standard == "longitude" or units in _LON_UNITS or name in ("lon", "longitude"):
        return "longitude"
    if standard == "projection_x_coordinate":
        return "projected x"
    if standard == "projection_y_coordinate":
        return "projected y"
    if standard == "time" or " since " in units:
        return "time"
    if standard in _VERTICAL or item.text("axis") == "Z" or "positive" in item.attrs:
        return "level"
    if units in _LENGTHS and units and name in ("x", "xc", "y", "yc"):
        return f"projected {name[0]}"
    return ""


def _length(coordinate: Variable, path: str | Path) -> float:
    units = coordinate.text("units")
    if units.lower() not in _LENGTHS:
        raise FloeError(f"{path}: coordinate '{coordinate.name}' has units '{units}', not m or km")
    return _LENGTHS[units.lower()]


def projection(variables: dict[str, Variable], variable: Variable, path: str | Path) -> pyproj.CRS:
    """Projection of a variable on projected coordinates, from its CF grid mapping.

    A WKT or PROJ text is taken before the CF parameters, which more often leave out the earth's
    figure.

    Raises
    ------
    FloeError
        Where it has none, or none that makes sense.
    """
    name = variable.text("grid_mapping").split(":")[0]
    if name not in variables:
        raise FloeError(
            f"{path}: variable '{variable.name}' lies on projected coordinates but has no "
            "grid_mapping"
        )
    mapping = variables[name]
    try:
        for attribute in ("crs_wkt", "spatial_ref", "proj4_string", "proj4text", "proj4"):
            if mapping.text(attribute):
                crs = pyproj.CRS.from_user_input(mapping.text(attribute))
                break
        else:
            crs = pyproj.CRS.from_cf(mapping.attrs)
    except (CRSError, KeyError, TypeError, ValueError):
        raise FloeError(f"{path}: the grid mapping '{name}' names no known projection") from None
    if not crs.is_projected:
        raise FloeError(f"{path}: the grid mapping '{name}' is no projection in metres")
    return crs
