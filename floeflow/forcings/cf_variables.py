# SPDX-License-Identifier: GPL-2.0-or-later
"""Which variable of a user's file is which: CF standard names first, common names after.

Tables of names and units, and the search through a file's variables with them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

from floeflow.core import cf_reading as cf
from floeflow.core import units
from floeflow.core.errors import FloeError

# Water as a depth, and what a second's share of a depth is in SI (density of fresh water, kg/m3).
_WATER = 1000.0


@dataclass(frozen=True)
class Quantity:
    """A forcing variable: its names in files, its units and its sane range.

    ``also`` are other kinds of units that it comes in, ``sums`` those of its sum over time, each
    with the factor that brings it, or a second's share of it, to SI.
    """

    standard: tuple[str, ...]
    common: tuple[str, ...]
    si: str
    low: float
    high: float
    ocean: bool = False
    also: tuple[tuple[str, float], ...] = ()
    sums: tuple[tuple[str, float], ...] = ()


QUANTITIES: dict[str, Quantity] = {
    "air_temperature": Quantity(
        ("air_temperature",),
        ("t2m", "tas", "T2m", "2t", "air", "tas_10m", "TMP_2maboveground", "T_10", "T2M"),
        "K",
        150.0,
        350.0,
    ),
    "specific_humidity": Quantity(
        ("specific_humidity",),
        ("huss", "q2m", "shum", "q", "huss_10m", "Q_10", "QV2M"),
        "kg kg-1",
        0.0,
        0.1,
    ),
    "dew_point": Quantity(("dew_point_temperature",), ("d2m", "tdps", "2d"), "K", 100.0, 350.0),
    "air_pressure": Quantity(
        ("air_pressure_at_mean_sea_level", "air_pressure_at_sea_level", "surface_air_pressure"),
        ("msl", "psl", "sp", "ps", "slp", "SLP"),
        "Pa",
        5.0e4,
        1.2e5,
    ),
    "shortwave_down": Quantity(
        ("surface_downwelling_shortwave_flux_in_air",),
        ("rsds", "msdwswrf", "avg_sdswrf", "dswrf", "ssrd", "SWGDN"),
        "W m-2",
        0.0,
        1500.0,
        sums=(("J m-2", 1.0),),
    ),
    "longwave_down": Quantity(
        ("surface_downwelling_longwave_flux_in_air",),
        ("rlds", "msdwlwrf", "avg_sdlwrf", "dlwrf", "strd", "LWGAB"),
        "W m-2",
        0.0,
        1000.0,
        sums=(("J m-2", 1.0),),
    ),
    "snowfall": Quantity(
        ("snowfall_flux", "lwe_snowfall_rate", "lwe_thickness_of_snowfall_amount"),
        ("prsn", "msr", "avg_tsrwe", "sf", "PRECSNO"),
        "kg m-2 s-1",
        0.0,
        0.1,
        also=(("m s-1", _WATER),),
        sums=(("kg m-2", 1.0), ("m", _WATER)),
    ),
    "precipitation": Quantity(
        (
            "precipitation_flux",
            "lwe_precipitation_rate",
            "lwe_thickness_of_precipitation_amount",
        ),
        ("pr", "mtpr", "avg_tprate", "tp", "prate"),
        "kg m-2 s-1",
        0.0,
        0.1,
        also=(("m s-1", _WATER),),
        sums=(("kg m-2", 1.0), ("m", _WATER)),
    ),
    "ocean_heat_flux": Quantity(
        ("upward_sea_ice_basal_heat_flux",),
        ("fsitherm", "ocean_heat_flux"),
        "W m-2",
        -500.0,
        5.0e3,
        True,
    ),
    "sea_surface_temperature": Quantity(
        ("sea_surface_temperature", "sea_surface_foundation_temperature"),
        ("sst", "tos", "analysed_sst"),
        "K",
        265.0,
        315.0,
        True,
    ),
    "sea_floor_depth": Quantity(
        (
            "sea_floor_depth_below_geoid",
            "sea_floor_depth_below_mean_sea_level",
            "sea_floor_depth_below_sea_surface",
            "model_sea_floor_depth_below_geoid",
            "sea_floor_depth",
        ),
        ("deptho", "bathymetry", "Bathymetry", "bathy", "h"),
        "m",
        0.0,
        1.2e4,
        True,
    ),
    # As of GEBCO and ETOPO: counted upwards from the sea's surface.
    "sea_floor_height": Quantity(
        ("height_above_mean_sea_level", "surface_altitude", "altitude"),
        ("elevation", "z", "Band1"),
        "m",
        -1.2e4,
        1.2e4,
        True,
    ),
    "sea_surface_salinity": Quantity(
        ("sea_surface_salinity",), ("sss", "sos"), "1e-3", 0.0, 50.0, True
    ),
}


@dataclass(frozen=True)
class Pair:
    """A vector: names of its two components, by what they point along.

    ``common`` are names that mean east and north on longitude and latitude, and nothing elsewhere;
    ``along_grid`` names of model histories whose components lie along the grid's own axes.
    """

    east_north: tuple[tuple[str, str], ...]
    map_axes: tuple[tuple[str, str], ...]
    common: tuple[tuple[str, str], ...]
    high: float
    ocean: bool = False
    along_grid: tuple[tuple[str, str], ...] = ()


VECTORS: dict[str, Pair] = {
    "wind": Pair(
        (("eastward_wind", "northward_wind"),),
        (("x_wind", "y_wind"), ("grid_eastward_wind", "grid_northward_wind")),
        (
            ("u10", "v10"),
            ("uas", "vas"),
            ("10u", "10v"),
            ("uwnd", "vwnd"),
            ("uas_10m", "vas_10m"),
            ("U_10", "V_10"),
            ("U10M", "V10M"),
        ),
        150.0,
        along_grid=(("uatm", "vatm"),),
    ),
    "ocean": Pair(
        (
            ("eastward_sea_water_velocity", "northward_sea_water_velocity"),
            ("surface_eastward_sea_water_velocity", "surface_northward_sea_water_velocity"),
        ),
        (
            ("sea_water_x_velocity", "sea_water_y_velocity"),
            ("x_sea_water_velocity", "y_sea_water_velocity"),
            ("surface_sea_water_x_velocity", "surface_sea_water_y_velocity"),
        ),
        (("uo", "vo"), ("water_u", "water_v")),
        10.0,
        True,
        (("vozocrtx", "vomecrty"), ("uocn", "vocn"), ("ssu_m", "ssv_m")),
    ),
}
VECTOR_UNITS = "m s-1"


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

    Parameters
    ----------
    variables : dict of cf.Variable
        Of the file, by name.
    name : str
        Of the quantity in the forcing.
    path : str or Path
        Of the file, for messages.

    Returns
    -------
    Variable or None
        By standard name, else by a name that is in use.

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
    variables: dict[str, cf.Variable],
    name: str,
    path: str | Path,
    on_lonlat: Callable[[cf.Variable], bool] | None = None,
) -> FoundVector | None:
    """The variables that hold a vector's components, or None.

    ``on_lonlat`` tells whether a variable lies on longitude and latitude, where the variables are
    those of several files.

    Parameters
    ----------
    variables : dict of cf.Variable
        Of the file, by name.
    name : str
        Of the vector in the forcing, such as ``wind``.
    path : str or Path
        Of the file, for messages.
    on_lonlat : callable, optional
        Whether a variable lies on longitude and latitude.

    Returns
    -------
    FoundVector or None
        Both components, and whether they point east and north or along the grid.

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
            lonlat = (
                on_lonlat(variables[u])
                if on_lonlat
                else cf.layout(variables, variables[u], path).lonlat
            )
            if not lonlat:
                raise FloeError(
                    f"{path}: '{u}' and '{v}' need standard_names that say whether they point "
                    "east and north or along the grid"
                )
            return FoundVector(variables[u], variables[v], True)
    for u, v in pair.along_grid:
        if u in variables and v in variables:
            return FoundVector(variables[u], variables[v], False)
    return None


EXTREMES = (
    "maximum",
    "minimum",
    "range",
    "standard_deviation",
    "variance",
    "maximum_absolute_value",
)


def refuse_extremes(variable: cf.Variable, path: str | Path) -> None:
    """Refuse a day's maximum and the like, which has the standard name of the quantity itself.

    Parameters
    ----------
    variable : cf.Variable
        One of them.
    path : str or Path
        Of the file, for messages.

    Raises
    ------
    FloeError
        Where the cell methods say so.
    """
    words = variable.text("cell_methods").replace(":", " ").split()
    found = next((word for word in words if word in EXTREMES), "")
    if found:
        raise FloeError(
            f"{path}: variable '{variable.name}' is a {found.replace('_', ' ')} by its "
            "cell_methods, no value at a time and no mean"
        )


def _quoted(found: list[cf.Variable]) -> str:
    return ", ".join(f"'{item.name}'" for item in found)


def conversion(variable: cf.Variable, si: str, path: str | Path) -> tuple[float, float]:
    """Factor and offset that bring a variable to SI.

    Parameters
    ----------
    variable : cf.Variable
        One of them.
    si : str
        SI unit.
    path : str or Path
        Of the file, for messages.

    Returns
    -------
    factor, offset : float
        SI value = factor times stored value, plus offset.

    Raises
    ------
    FloeError
        Where it has no units, or units that are not known for it.
    """
    found = _conversion(variable, si)
    if found is None:
        _refuse_units(variable, si, path)
    return found


def _conversion(variable: cf.Variable, si: str) -> tuple[float, float] | None:
    given = variable.text("units")
    return units.conversion(given, si) if given else None


def _refuse_units(variable: cf.Variable, si: str, path: str | Path) -> NoReturn:
    given = variable.text("units")
    said = f"has units '{given}'" if given else "has no units"
    raise FloeError(f"{path}: variable '{variable.name}' {said}, not such as {si}")


def scalar_conversion(
    variable: cf.Variable, quantity: Quantity, path: str | Path
) -> tuple[float, float, bool]:
    """Factor and offset that bring a scalar, or a second's share of its sum, to SI; if it is a sum.

    Parameters
    ----------
    variable : cf.Variable
        One of them.
    quantity : Quantity
        Its SI unit, and others that are taken.
    path : str or Path
        Of the file, for messages.

    Returns
    -------
    factor, offset : float
        SI value = factor times stored value, plus offset.
    summed : bool
        True where the variable is a sum over time.

    Raises
    ------
    FloeError
        As `conversion`.
    """
    found = _conversion(variable, quantity.si)
    if found is not None:
        return *found, False
    for kinds, summed in ((quantity.also, False), (quantity.sums, True)):
        for si, factor in kinds:
            found = _conversion(variable, si)
            if found is not None and found[1] == 0.0:
                return factor * found[0], 0.0, summed
    _refuse_units(variable, quantity.si, path)
