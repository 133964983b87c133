# SPDX-License-Identifier: GPL-2.0-or-later
"""Fields of the forcing that do not change in time and belong to no source of weather.

An effect that reads another one names it in its ``forcing`` and adds one function here.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from floeflow.core import area_means as areas
from floeflow.core import cf_reading as cf
from floeflow.core import fields, interpolate
from floeflow.core.constants import EARTH_ROTATION
from floeflow.core.errors import FloeError
from floeflow.core.grids import scene_crs, scene_grid, to_lonlat
from floeflow.core.input_files import Hints
from floeflow.forcings import cf_variables
from floeflow.forcings.tracks import InputFile, open_files
from floeflow.scene.blocks import Domain, Scene

Array = NDArray[np.float64]

# By variable: field on the scene's grid, (ny, nx), and its unit.
FIXED: dict[str, tuple[Callable[[Scene], Array], str]] = {}

# Depths missing on land take the nearest known one, however far (m).
LAND_REACH = 1.0e8
# Area means where so many points of the file lie along the side of a cell.
FINER = 2.2


def fixed(name: str, unit: str) -> Callable[[Callable[[Scene], Array]], Callable[[Scene], Array]]:
    """Register the function that makes a fixed field of the forcing.

    Parameters
    ----------
    name : str
        Of the field.
    unit : str
        SI unit.

    Returns
    -------
    callable
        Decorator of a function from the scene to values on its grid, (ny, nx).
    """

    def register(function: Callable[[Scene], Array]) -> Callable[[Scene], Array]:
        FIXED[name] = function, unit
        return function

    return register


@fixed("coriolis", "s-1")
def coriolis(scene: Scene) -> Array:
    """Coriolis parameter on the scene's grid (1/s), (ny, nx).

    Parameters
    ----------
    scene : Scene
        Its keys.

    Returns
    -------
    ndarray
        1/s, negative in the southern hemisphere, (ny, nx).
    """
    _, lat = to_lonlat(scene_crs(scene.domain), *scene_grid(scene.domain).mesh())
    return 2.0 * EARTH_ROTATION * np.sin(np.radians(lat))


@fixed("sea_floor_depth", "m")
def sea_floor_depth(scene: Scene) -> Array:
    """Depth of the sea on the scene's grid (m, 0 on land), (ny, nx).

    Parameters
    ----------
    scene : Scene
        Its keys.

    Returns
    -------
    ndarray
        m, (ny, nx).

    Raises
    ------
    FloeError
        Where the file of ``grounding.file`` cannot be read, holds no depth, has values that cannot
        be, or does not cover the scene.
    """
    asked = scene.grounding
    if not asked.file:
        return np.full(scene_grid(scene.domain).shape, asked.depth)
    stamp = Path(asked.file).stat().st_mtime_ns if Path(asked.file).exists() else 0
    return _depth_of_file(asked.file, asked.variable, asked.crs, scene.domain, stamp).copy()


@functools.lru_cache(maxsize=2)
def _depth_of_file(file: str, variable: str, crs: str, domain: Domain, stamp: int) -> Array:
    """Depth of a file; ``stamp`` is the time of its last change, so that it is read once."""
    opened = open_files([Path(file)], Hints("grounding", crs))[0]
    try:
        return _read_depth(opened, variable, domain)
    finally:
        opened.data.close()


def _read_depth(file: InputFile, asked: str, domain: Domain) -> Array:
    path = file.path
    found, up = find_depth(file, asked)
    factor, offset = cf_variables.conversion(found, "m", path)
    layout, source = file.layout(found), file.source(found)
    once = np.zeros(1, np.int64)
    raw = fields.read_values(file.data, found.name, layout, source, once, path)
    values = factor * raw[0] + offset
    depth = np.maximum(-values, 0.0) if up else values
    low, high = float(np.nanmin(depth)), float(np.nanmax(depth))
    if low < 0.0 or high > 12_000.0 or high == 0.0:
        raise FloeError(
            f"{path}: '{found.name}' reaches from {np.nanmin(values):g} to "
            f"{np.nanmax(values):g} m, which is no {'height' if up else 'depth'} of a sea floor: "
            "check its units, its sign and its standard_name"
        )
    grid, scene_map = scene_grid(domain), scene_crs(domain)
    transfer = areas.transfer(source, grid, scene_map, *to_lonlat(scene_map, *grid.mesh()), FINER)
    if not transfer.inside.all():
        raise FloeError(f"{path}: '{found.name}' does not cover the scene")
    filled = interpolate.fill_nearest(depth[None], source, LAND_REACH)
    on_grid = transfer.of(filled)[0].reshape(grid.shape)
    if not np.isfinite(on_grid).all():
        raise FloeError(f"{path}: '{found.name}' is missing in a part of the scene")
    return np.maximum(on_grid, 0.0)


def find_depth(file: InputFile, asked: str) -> tuple[cf.Variable, bool]:
    """The variable of a file that tells the sea floor, and whether it counts upwards.

    Parameters
    ----------
    file : InputFile
        Bathymetry.
    asked : str
        Name of the variable; empty to look for its standard name.

    Returns
    -------
    variable : Variable
        Of the file.
    up : bool
        True for heights above the sea, False for depths below it.

    Raises
    ------
    FloeError
        Where there is none, or the one that was asked for is not there.
    """
    up = cf_variables.find_scalar(file.variables, "sea_floor_height", file.path)
    if asked:
        variable = cf.named(file.variables, asked, file.path, "grounding.variable")
        upward = variable.text("positive") == "up" or (up is not None and up.name == variable.name)
        return variable, upward
    down = cf_variables.find_scalar(file.variables, "sea_floor_depth", file.path)
    if down is not None:
        return down, False
    if up is not None:
        return up, True
    standard = cf_variables.QUANTITIES["sea_floor_depth"].standard[0]
    raise FloeError(
        f"{file.path}: has no depth of the sea: no standard_name {standard}; name its variable in "
        "grounding.variable"
    )
