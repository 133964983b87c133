# SPDX-License-Identifier: GPL-2.0-or-later
"""What is in a file: variables by CF standard name, dimensions by their role, projection.

Only attributes and coordinates are read here: the workflow calls this before any job.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any, NoReturn

import pyproj
import xarray as xr
from pyproj.exceptions import CRSError

from floeflow.core import coordinate_kinds as kinds
from floeflow.core import units
from floeflow.core.errors import FloeError
from floeflow.core.input_files import Hints, open_input


@dataclass(frozen=True)
class Variable:
    """A variable's name, dimensions, shape, attributes, and kind of numbers (NumPy's letter)."""

    name: str
    dims: tuple[str, ...]
    shape: tuple[int, ...]
    attrs: dict[str, Any]
    kind: str = ""

    def text(self, attribute: str) -> str:
        """An attribute as stripped text, empty where there is none.

        Parameters
        ----------
        attribute : str
            Name of the attribute.

        Returns
        -------
        str
            The attribute, stripped.
        """
        return str(self.attrs.get(attribute, "")).strip()


@dataclass(frozen=True)
class Layout:
    """Roles of a variable's dimensions.

    Parameters
    ----------
    x, y : str
        Names of the horizontal dimensions: longitude and latitude, projected, or a grid's own.
    lonlat : bool
        Whether they are longitude and latitude.
    time, level : str
        Names of the time and vertical dimension, empty where there is none.
    scale : float
        Metres in the unit of a projected coordinate; 0 where it has none.
    places : tuple of str
        Names of two-dimensional longitudes and latitudes, where ``x`` and ``y`` are a grid's own.
    stamp : str
        Name of the one time of a variable without that dimension; empty where it has none.
    height : str
        Name of the one level of a variable without that dimension; empty where it has none.
    """

    x: str
    y: str
    lonlat: bool
    time: str
    level: str
    scale: float = 1.0
    places: tuple[str, str] | None = None
    stamp: str = ""
    height: str = ""


def describe(path: str | Path, hints: Hints | None = None) -> dict[str, Variable]:
    """Variables of a file.

    Parameters
    ----------
    path : str or Path
        File.
    hints : Hints, optional
        What the scene says of the file.

    Returns
    -------
    dict of Variable
        By name, as in the file.

    Raises
    ------
    FloeError
        Where the file is missing or cannot be read.
    """
    with open_input(path, hints) as data:
        return variables_of(data)


def variables_of(data: xr.Dataset) -> dict[str, Variable]:
    """Variables of an open file.

    Parameters
    ----------
    data : xarray.Dataset
        The open file, undecoded.

    Returns
    -------
    dict of Variable
        By name: dimensions, shape, attributes and kind of number.
    """
    return {
        str(name): Variable(
            str(name),
            tuple(map(str, item.dims)),
            tuple(item.shape),
            dict(item.attrs),
            item.dtype.kind,
        )
        for name, item in data.variables.items()
    }


def named(variables: dict[str, Variable], name: str, path: str | Path, key: str) -> Variable:
    """The variable of this name.

    Parameters
    ----------
    variables : dict of Variable
        Of the file, by name.
    name : str
        Name that is asked for.
    path : str or Path
        Of the file, for messages.
    key : str
        Key of the scene that asks.

    Returns
    -------
    Variable
        That of the name.

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
    """Variables that carry this CF standard name.

    Parameters
    ----------
    variables : dict of Variable
        Of the file, by name.
    standard_name : str
        CF standard name.

    Returns
    -------
    list of Variable
        In the order of the file.
    """
    return [item for item in variables.values() if item.text("standard_name") == standard_name]


def layout(variables: dict[str, Variable], variable: Variable, path: str | Path) -> Layout:
    """Find which dimension of a variable is which.

    Parameters
    ----------
    variables : dict of Variable
        Of the file, by name.
    variable : Variable
        One of them.
    path : str or Path
        Of the file, for messages.

    Returns
    -------
    Layout
        Names of the dimensions of x, y, time and level, and how x and y are given.

    Raises
    ------
    FloeError
        Where two horizontal dimensions are not found, or others than time and level are longer
        than one.
    """
    roles = _roles(variables, variable, path)
    time, level, *single = own_axes(variables, variable, path)
    rest = [
        dim
        for dim, size in zip(variable.dims, variable.shape, strict=True)
        if size > 1 and dim not in (time, level)
    ]
    for y, x, lonlat in (("latitude", "longitude", True), ("projected y", "projected x", False)):
        if x in roles and y in roles and set(rest) <= {roles[x], roles[y]}:
            if not lonlat and not has_mapping(variables, variable):
                break
            scale = 1.0 if lonlat else _length(variables[roles[x]], path)
            return Layout(roles[x], roles[y], lonlat, time, level, scale, None, *single)
    places = _places(variables, variable, rest)
    if places is not None:
        return Layout(rest[1], rest[0], False, time, level, 1.0, places, *single)
    if "projected x" in roles and "projected y" in roles and set(rest) <= set(roles.values()):
        projection(variables, variable, path)
    _refuse_dims(variables, variable, path)


def own_axes(
    variables: dict[str, Variable], variable: Variable, path: str | Path
) -> tuple[str, str, str, str]:
    """Time and level of a variable as `Layout` has them: time, level, stamp and height.

    Parameters
    ----------
    variables : dict of Variable
        Of the file, by name.
    variable : Variable
        One of them.
    path : str or Path
        Of the file, for messages.

    Returns
    -------
    time, level, stamp, height : str
        Dimensions of time and level, else the scalar coordinates of both; empty where there is
        none.

    Raises
    ------
    FloeError
        Where two dimensions have one role.
    """
    roles = _roles(variables, variable, path)
    time, level = roles.get("time", ""), roles.get("level", "")
    stamp = "" if time else _single(variables, variable, "time")
    return time, level, stamp, "" if level else _single(variables, variable, "level")


def _roles(variables: dict[str, Variable], variable: Variable, path: str | Path) -> dict[str, str]:
    """Dimension of each role."""
    roles: dict[str, str] = {}
    for dim in variable.dims:
        role = dimension_kind(variables, dim)
        if role in roles:
            raise FloeError(f"{path}: variable '{variable.name}' has two dimensions of {role}")
        if role:
            roles[role] = dim
    return roles


def has_mapping(variables: dict[str, Variable], variable: Variable) -> bool:
    """Whether a variable names a grid mapping that is there.

    Parameters
    ----------
    variables : dict of Variable
        Of the file, by name.
    variable : Variable
        One of them.

    Returns
    -------
    bool
        False where it names none.
    """
    return variable.text("grid_mapping").split(":")[0] in variables


def _places(
    variables: dict[str, Variable], variable: Variable, rest: list[str]
) -> tuple[str, str] | None:
    """Names of the two-dimensional longitudes and latitudes of a variable, or None.

    Those that it names in ``coordinates`` come first; else they must be the only ones.
    """
    if len(rest) != 2:
        return None
    named = variable.text("coordinates").replace(",", " ").split()
    found: dict[str, list[str]] = {"longitude": [], "latitude": []}
    for name, item in variables.items():
        kind = kinds.kind_of(name, item.attrs) or _by_name(name)
        if kind in found and set(item.dims) == set(rest):
            found[kind].append(name)
    chosen = []
    for kind in ("longitude", "latitude"):
        first = [name for name in named if name in found[kind]] or found[kind]
        if len(first) != 1:
            return None
        chosen.append(first[0])
    return chosen[0], chosen[1]


def _by_name(name: str) -> str:
    """Kind of a two-dimensional variable by names that history files use."""
    lower = name.lower()
    for kind, word in (("longitude", "lon"), ("latitude", "lat")):
        if lower in (f"t{word}", f"u{word}", f"nav_{word}", f"g{word}t", f"plat{word}", f"x{word}"):
            return kind
    return ""


def _single(variables: dict[str, Variable], variable: Variable, kind: str) -> str:
    """Name of the one time or level of a variable that has no such dimension, or empty."""
    named = variable.text("coordinates").replace(",", " ").split()
    singles = [
        name
        for name, item in variables.items()
        if all(size == 1 for size in item.shape) and kinds.kind_of(name, item.attrs) == kind
    ]
    listed = [name for name in named if name in singles]
    if kind == "time":
        # A forecast's start is no time that a field is valid at.
        valid = [
            name
            for name in listed or singles
            if variables[name].text("standard_name") != "forecast_reference_time"
            and " since " in variables[name].text("units")
        ]
        return "valid_time" if "valid_time" in valid else (valid[0] if valid else "")
    return listed[0] if listed else ""


def _refuse_dims(variables: dict[str, Variable], variable: Variable, path: str | Path) -> NoReturn:
    dims = ", ".join(variable.dims)
    said = f"{path}: variable '{variable.name}' has dimensions ({dims})"
    if "latitude" in {
        kinds.kind_of(name, item.attrs) for name, item in variables.items() if len(item.dims) == 2
    }:
        raise FloeError(
            f"{said} on a curvilinear grid, but the file does not have two-dimensional longitudes "
            "and latitudes on these dimensions, one of each: name them in its 'coordinates'"
        )
    for dim in variable.dims:
        axis = variables.get(dim)
        timely = dim.lower() in ("time", "t", "month", "day", "step", "time_counter")
        if timely and not dimension_kind(variables, dim):
            given = axis.text("units") if axis is not None and axis.kind in "iuf" else ""
            has = f"has units '{given}'" if given else "has no units"
            raise FloeError(
                f"{path}: '{dim}' of variable '{variable.name}' {has}, not such as "
                "'days since 1981-12-31', so its times are not known"
            )
    known = {dim for dim in variable.dims if dimension_kind(variables, dim)}
    kinds_found = {dimension_kind(variables, dim) for dim in known}
    more = [
        (dim, size)
        for dim, size in zip(variable.dims, variable.shape, strict=True)
        if size > 1 and dim not in known
    ]
    if more and ({"latitude", "longitude"} <= kinds_found):
        raise FloeError(
            f"{path}: variable '{variable.name}' has {more[0][1]} values along '{more[0][0]}', "
            "which is no time, level, longitude or latitude: keep one of them in the file"
        )
    bare = {dim[:1].lower() for dim, _ in more} >= {"x", "y"}
    raise FloeError(
        f"{said}, which are not longitude and latitude, or projected x and y"
        + (": name their projection in mask.crs or forcing.crs" if bare else "")
    )


def dimension_kind(variables: dict[str, Variable], dim: str) -> str:
    """What a dimension is: latitude, longitude, projected x or y, time, level; or empty.

    Parameters
    ----------
    variables : dict of Variable
        Of the file, by name.
    dim : str
        Name of the dimension.

    Returns
    -------
    str
        As `coordinate_kinds.kind_of` says it.
    """
    coordinate = variables.get(dim)
    if coordinate is None or coordinate.dims != (dim,):
        return ""
    return kinds.kind_of(dim, coordinate.attrs)


def _length(coordinate: Variable, path: str | Path) -> float:
    given = coordinate.text("units")
    if not given:
        return 0.0  # those of the projection's axes
    metres = units.is_length(given)
    if metres is None:
        raise FloeError(f"{path}: coordinate '{coordinate.name}' has units '{given}', not m or km")
    return metres


def projection(variables: dict[str, Variable], variable: Variable, path: str | Path) -> pyproj.CRS:
    """Projection of a variable on projected coordinates, from its CF grid mapping.

    A WKT or PROJ text is taken before the CF parameters, which more often leave out the earth's
    figure.

    Parameters
    ----------
    variables : dict of Variable
        Of the file, by name.
    variable : Variable
        One of them.
    path : str or Path
        Of the file, for messages.

    Returns
    -------
    pyproj.CRS
        Projected, its axes in metres.

    Raises
    ------
    FloeError
        Where it has none, or none that makes sense.
    """
    name = variable.text("grid_mapping").split(":")[0]
    if name not in variables:
        raise FloeError(
            f"{path}: variable '{variable.name}' lies on projected coordinates but has no "
            "grid_mapping: name the projection in mask.crs or forcing.crs"
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
        raise FloeError(f"{path}: the grid mapping '{name}' is not a projection in metres")
    return crs
