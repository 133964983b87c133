# SPDX-License-Identifier: GPL-2.0-or-later
"""Temperature and salinity of the sea at the scene's start, read to the mask grid."""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.core import area_means, fields, interpolate
from floeflow.core import cf_reading as cf
from floeflow.core.errors import FloeError
from floeflow.core.grids import mask_grid, scene_crs, to_lonlat
from floeflow.core.input_files import Hints
from floeflow.forcings import cf_variables
from floeflow.masks.mask_file import nearest_time
from floeflow.scene.blocks import Scene

Array = NDArray[np.float64]

log = logging.getLogger(__name__)

SALT_UNITS = ("", "1e-3", "psu", "pss", "pss-78", "1", "0.001", "g kg-1", "g/kg", "ppt")
# No sea is as fresh as this everywhere (1e-3).
FRESHEST = 0.5
# Name in the mask's file, quantity, key of the scene.
SEA_FIELDS = (
    ("sst", "sea_surface_temperature", "temperature"),
    ("sss", "sea_surface_salinity", "salinity"),
)


def sea_path(scene: Scene) -> Path:
    """File that holds the sea at the start.

    Parameters
    ----------
    scene : Scene
        Its keys.

    Returns
    -------
    Path
        That of ``sea.file``, else that of ``mask.file``.
    """
    return Path(scene.sea.file or scene.mask.file)


def sea_hints(scene: Scene) -> Hints:
    """What the scene says of that file: where it is the mask's, its projection.

    Parameters
    ----------
    scene : Scene
        Its keys.

    Returns
    -------
    Hints
        Without a projection where the sea has a file of its own.
    """
    return Hints("mask", "" if scene.sea.file else scene.mask.crs)


def find_sea(
    variables: dict[str, cf.Variable], scene: Scene, quantity: str, key: str
) -> cf.Variable | None:
    """The variable of a quantity of the sea: the one asked for, else by standard name, or None.

    Parameters
    ----------
    variables : dict of cf.Variable
        Of the file, by name.
    scene : Scene
        Block ``sea``.
    quantity : str
        By the names of the forcing.
    key : str
        Key of the block that names the variable.

    Returns
    -------
    Variable or None
        None where the file has none and the scene names none.

    Raises
    ------
    FloeError
        Where the file has none of the name asked for, or several of the standard name.
    """
    path, asked = sea_path(scene), getattr(scene.sea, key)
    if asked:
        return cf.named(variables, asked, path, f"sea.{key}")
    standard = cf_variables.QUANTITIES[quantity].standard[0]
    found = cf.by_standard_name(variables, standard)
    if len(found) > 1:
        listed = ", ".join(item.name for item in found)
        raise FloeError(
            f"{path}: {listed} all have standard_name {standard}: name one in sea.{key}"
        )
    return found[0] if found else None


def sea_fields(
    scene: Scene, lon: Array, lat: Array
) -> dict[str, tuple[tuple[str, str], Array, dict[str, str]]]:
    """Fields of the sea at places, (rows, columns), in SI units; none that the file lacks.

    They are ``sst`` (K) and ``sss`` (1e-3).

    Off the file's grid, and further from known values than ``mask.fill_reach``, the sea is at its
    freezing point: NaN is not known, and stays NaN.

    Parameters
    ----------
    scene : Scene
        Block ``sea``.
    lon : ndarray
        Degrees, (rows, columns).
    lat : ndarray
        Degrees, (rows, columns).

    Returns
    -------
    dict
        Dimensions, values (rows, columns) and attributes by name.

    Raises
    ------
    FloeError
        For units that are not known, or values that cannot be.
    """
    path = sea_path(scene)
    made = {}
    with fields.open_file(path, sea_hints(scene)) as data:
        variables = cf.variables_of(data)
        for name, quantity, key in SEA_FIELDS:
            variable = find_sea(variables, scene, quantity, key)
            if variable is None:
                log.info("%s holds no %s: see sea.%s", path, quantity.replace("_", " "), key)
                continue
            rule = cf_variables.QUANTITIES[quantity]
            factor, offset = units_of(variable, rule.si, path)
            layout = cf.layout(variables, variable, path)
            source = fields.source_grid(variables, variable, layout, data, path)
            index, _ = nearest_time(data, variables, layout, scene, path)
            raw = fields.read_values(data, variable.name, layout, source, np.array([index]), path)
            values = factor * raw[0] + offset
            _check_range(values, variable, rule, path)
            # What lies beyond the reach comes back as 0, which this makes no value that can be.
            raised = values - rule.low + 1.0
            filled = interpolate.fill_nearest(raised, source, scene.mask.fill_reach)
            found = _to_places(filled, source, scene, lon, lat)
            found = np.where(found >= 1.0 - 1e-9, found + rule.low - 1.0, np.nan)
            attrs = {"units": rule.si, "standard_name": rule.standard[0]}
            made[name] = (("y", "x"), found.reshape(lon.shape), attrs)
    return made


def units_of(variable: cf.Variable, si: str, path: Path) -> tuple[float, float]:
    """Factor and offset to SI; salinity without units is in 1e-3, as all scales of it are.

    Parameters
    ----------
    variable : cf.Variable
        One of them.
    si : str
        SI unit.
    path : Path
        Of the file, for messages.

    Returns
    -------
    factor, offset : float
        SI value = factor times stored value, plus offset.

    Raises
    ------
    FloeError
        For units that are not known.
    """
    if si == "1e-3" and variable.text("units").lower() in SALT_UNITS:
        return 1.0, 0.0
    return cf_variables.conversion(variable, si, path)


def _check_range(
    values: Array, variable: cf.Variable, rule: cf_variables.Quantity, path: Path
) -> None:
    known = values[np.isfinite(values)]
    if not known.size:
        raise FloeError(f"{path}: variable '{variable.name}' has no value that is not missing")
    # Salinity in kg/kg lies inside of the range of 1e-3, far below any sea.
    low = FRESHEST if rule.si == "1e-3" else rule.low
    if known.min() < rule.low or not low <= known.max() <= rule.high:
        raise FloeError(
            f"{path}: '{variable.name}' reaches from {known.min():g} to {known.max():g} "
            f"{rule.si}, outside {rule.low:g} to {rule.high:g} {rule.si}: check its units"
        )


def _to_places(
    filled: Array, source: fields.AnySource, scene: Scene, lon: Array, lat: Array
) -> Array:
    """At places of the mask grid, as the mask is brought there; 0 off the file's grid."""
    grid, crs = mask_grid(scene.domain, scene.mask.refine), scene_crs(scene.domain)
    found = area_means.transfer(source, grid, crs, lon, lat)
    return np.where(found.inside, found.of(filled), 0.0)


def with_sea(scene: Scene, mask: xr.Dataset) -> xr.Dataset:
    """Mask with the sea's temperature and salinity at the start, where a file has them.

    Parameters
    ----------
    scene : Scene
        Grid and block ``sea``.
    mask : xarray.Dataset
        On that grid.

    Returns
    -------
    xarray.Dataset
        The mask with ``sst`` (K) and ``sss`` (1e-3) on its grid, as far as the file has them.

    Raises
    ------
    FloeError
        As `sea_fields`.
    """
    grid = mask_grid(scene.domain, scene.mask.refine)
    lon, lat = to_lonlat(scene_crs(scene.domain), *grid.mesh())
    return mask.assign(sea_fields(scene, lon, lat))


def check_sea_file(scene: Scene) -> None:
    """Refuse a file of the sea that the scene's mixed layer could not start from.

    Parameters
    ----------
    scene : Scene
        Its keys.

    Raises
    ------
    FloeError
        One sentence: no file, no NetCDF, no such variable, units unknown.
    """
    path = sea_path(scene)
    with fields.open_file(path, sea_hints(scene)) as data:
        variables = cf.variables_of(data)
    for _, quantity, key in SEA_FIELDS:
        variable = find_sea(variables, scene, quantity, key)
        if variable is not None:
            units_of(variable, cf_variables.QUANTITIES[quantity].si, path)
            cf.layout(variables, variable, path)
