# SPDX-License-Identifier: GPL-2.0-or-later
"""Which variable of a user's file is which: CF standard names first, common names after.

Tables of names and units, and the search through a file's variables with them.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from floeflow.core import cf_reading as cf
from floeflow.core.errors import FloeError

_KELVIN = {
    "k": (1.0, 0.0),
    "kelvin": (1.0, 0.0),
    "degc": (1.0, 273.15),
    "c": (1.0, 273.15),
    "celsius": (1.0, 273.15),
    "degree_c": (1.0, 273.15),
    "degrees_c": (1.0, 273.15),
    "degree_celsius": (1.0, 273.15),
    "degrees_celsius": (1.0, 273.15),
}
_SPEED = {name: (1.0, 0.0) for name in ("m s-1", "m/s", "m s**-1", "meter second-1", "ms-1")}
_SPEED |= {"cm s-1": (0.01, 0.0), "cm/s": (0.01, 0.0)}
_SPEED |= {name: (1852.0 / 3600.0, 0.0) for name in ("knot", "knots", "kt")}
_FLUX = {name: (1.0, 0.0) for name in ("w m-2", "w/m2", "w/m^2", "w m**-2", "wm-2")}
_SHARE = {name: (1.0, 0.0) for name in ("1", "kg kg-1", "kg/kg", "kg kg**-1")}
_SHARE |= {"g kg-1": (1e-3, 0.0), "g/kg": (1e-3, 0.0)}
_RATE = {name: (1.0, 0.0) for name in ("kg m-2 s-1", "kg/m2/s", "kg m**-2 s**-1", "mm s-1")}
_RATE |= {name: (1.0 / 86400.0, 0.0) for name in ("mm day-1", "mm/day", "kg m-2 day-1")}
# Sums over time, and what a second's share of them is in SI.
_ENERGY_SUM = {name: 1.0 for name in ("j m-2", "j m**-2", "j/m2", "j/m^2")}
_WATER_SUM = {name: 1000.0 for name in ("m", "m of water equivalent")}
_WATER_SUM |= {name: 1.0 for name in ("kg m-2", "kg m**-2", "kg/m2", "mm")}
_PRESSURE = {"pa": (1.0, 0.0), "hpa": (100.0, 0.0), "mbar": (100.0, 0.0), "millibar": (100.0, 0.0)}


@dataclass(frozen=True)
class Quantity:
    """A forcing variable: its names in files, units (factor, offset to SI) and sane range.

    ``sums`` are units of its sum over time, with the factor that brings a second's share to SI.
    """

    standard: tuple[str, ...]
    common: tuple[str, ...]
    units: dict[str, tuple[float, float]]
    si: str
    low: float
    high: float
    ocean: bool = False
    sums: dict[str, float] = field(default_factory=dict)


QUANTITIES: dict[str, Quantity] = {
    "air_temperature": Quantity(
        ("air_temperature",), ("t2m", "tas", "T2m", "2t", "air"), _KELVIN, "K", 150.0, 350.0
    ),
    "specific_humidity": Quantity(
        ("specific_humidity",), ("huss", "q2m", "shum", "q"), _SHARE, "kg kg-1", 0.0, 0.1
    ),
    "dew_point": Quantity(
        ("dew_point_temperature",), ("d2m", "tdps", "2d"), _KELVIN, "K", 100.0, 350.0
    ),
    "air_pressure": Quantity(
        ("air_pressure_at_mean_sea_level", "air_pressure_at_sea_level", "surface_air_pressure"),
        ("msl", "psl", "sp", "ps", "slp"),
        _PRESSURE,
        "Pa",
        5.0e4,
        1.2e5,
    ),
    "shortwave_down": Quantity(
        ("surface_downwelling_shortwave_flux_in_air",),
        ("rsds", "msdwswrf", "avg_sdswrf", "dswrf", "ssrd"),
        _FLUX,
        "W m-2",
        0.0,
        1500.0,
        sums=_ENERGY_SUM,
    ),
    "longwave_down": Quantity(
        ("surface_downwelling_longwave_flux_in_air",),
        ("rlds", "msdwlwrf", "avg_sdlwrf", "dlwrf", "strd"),
        _FLUX,
        "W m-2",
        0.0,
        1000.0,
        sums=_ENERGY_SUM,
    ),
    "snowfall": Quantity(
        ("snowfall_flux", "lwe_thickness_of_snowfall_amount"),
        ("prsn", "msr", "avg_tsrwe", "sf"),
        _RATE,
        "kg m-2 s-1",
        0.0,
        0.1,
        sums=_WATER_SUM,
    ),
    "precipitation": Quantity(
        ("precipitation_flux", "lwe_thickness_of_precipitation_amount"),
        ("pr", "mtpr", "avg_tprate", "tp"),
        _RATE,
        "kg m-2 s-1",
        0.0,
        0.1,
        sums=_WATER_SUM,
    ),
    "ocean_heat_flux": Quantity(
        ("upward_sea_ice_basal_heat_flux",),
        ("fsitherm", "ocean_heat_flux"),
        _FLUX,
        "W m-2",
        -500.0,
        5.0e3,
        True,
    ),
}


@dataclass(frozen=True)
class Pair:
    """A vector: names of its two components, by what they point along."""

    east_north: tuple[tuple[str, str], ...]
    map_axes: tuple[tuple[str, str], ...]
    common: tuple[tuple[str, str], ...]
    high: float
    ocean: bool = False


VECTORS: dict[str, Pair] = {
    "wind": Pair(
        (("eastward_wind", "northward_wind"),),
        (("x_wind", "y_wind"), ("grid_eastward_wind", "grid_northward_wind")),
        (("u10", "v10"), ("uas", "vas"), ("10u", "10v")),
        150.0,
    ),
    "ocean": Pair(
        (
            ("eastward_sea_water_velocity", "northward_sea_water_velocity"),
            ("surface_eastward_sea_water_velocity", "surface_northward_sea_water_velocity"),
        ),
        (
            ("sea_water_x_velocity", "sea_water_y_velocity"),
            ("x_sea_water_velocity", "y_sea_water_velocity"),
        ),
        (("uo", "vo"), ("water_u", "water_v")),
        10.0,
        True,
    ),
}
VECTOR_UNITS = _SPEED


@dataclass(frozen=True)
class FoundVector:
    """The two components of a vector in a file, and whether they point east and north."""

    u: cf.Variable
    v: cf.Variable
    east_north: bool


def find_scalar(
    variables: dict[str, cf.Variable], name: str, path: str | Path
) -> cf.Variable | None:
    """The variable that holds a quantity, or None.

    Raises
    ------
    FloeError
        Where several carry its standard name.
    """
    quantity = QUANTITIES[name]
    for standard in quantity.standard:
        found = _surface(cf.by_standard_name(variables, standard), quantity.common)
        if len(found) > 1:
            raise FloeError(f"{path}: {_quoted(found)} all have standard_name {standard}")
        if found:
            return found[0]
    return next((variables[item] for item in quantity.common if item in variables), None)


def _surface(found: list[cf.Variable], common: Iterable[str]) -> list[cf.Variable]:
    """Of several with one standard name, the one with a common name of the surface's."""
    usual = [item for item in found if item.name in common]
    return usual if len(found) > 1 and usual else found


def find_vector(
    variables: dict[str, cf.Variable], name: str, path: str | Path
) -> FoundVector | None:
    """The variables that hold a vector's components, or None.

    Raises
    ------
    FloeError
        Where a component is there twice or without the other, or where it is not said whether
        they point east and north.
    """
    pair = VECTORS[name]
    usual = [item for both in pair.common for item in both]
    for names, east_north in [(item, True) for item in pair.east_north] + [
        (item, False) for item in pair.map_axes
    ]:
        parts = [_surface(cf.by_standard_name(variables, item), usual) for item in names]
        if not parts[0] and not parts[1]:
            continue
        for part, standard in zip(parts, names, strict=True):
            if len(part) != 1:
                what = f"{_quoted(part)} all have" if part else "no variable has"
                raise FloeError(f"{path}: {what} standard_name {standard}")
        return FoundVector(parts[0][0], parts[1][0], east_north)
    for u, v in pair.common:
        if u in variables and v in variables:
            if not cf.layout(variables, variables[u], path).lonlat:
                raise FloeError(
                    f"{path}: '{u}' and '{v}' need standard_names that say whether they point "
                    "east and north or along the grid"
                )
            return FoundVector(variables[u], variables[v], True)
    return None


def _quoted(found: list[cf.Variable]) -> str:
    return ", ".join(f"'{item.name}'" for item in found)


def units_of(variable: cf.Variable) -> str:
    """Units of a variable in lower case, single blanks."""
    return " ".join(variable.text("units").split()).lower()


def conversion(
    variable: cf.Variable, units: dict[str, tuple[float, float]], si: str, path: str | Path
) -> tuple[float, float]:
    """Factor and offset that bring a variable to SI.

    Raises
    ------
    FloeError
        Where it has no units, or units that are not known for it.
    """
    if units_of(variable) in units:
        return units[units_of(variable)]
    given = variable.text("units")
    said = f"has units '{given}'" if given else "has no units"
    raise FloeError(f"{path}: variable '{variable.name}' {said}, not such as {si}")


def scalar_conversion(
    variable: cf.Variable, quantity: Quantity, path: str | Path
) -> tuple[float, float, bool]:
    """Factor and offset that bring a scalar, or a second's share of its sum, to SI; if it is a sum.

    Raises
    ------
    FloeError
        As `conversion`.
    """
    if units_of(variable) in quantity.sums:
        return quantity.sums[units_of(variable)], 0.0, True
    return *conversion(variable, quantity.units, quantity.si, path), False
