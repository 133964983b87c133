# SPDX-License-Identifier: GPL-2.0-or-later
"""How large elements are where: finer at coasts, at the ice edge, in straits, inside polygons.

A size is relative: 1 far from all that refines. It is the least of what each rule asks for, each
growing from its own size to 1 over `reach`, so that neighbours never differ much.
"""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from floeflow.core.errors import FloeError
from floeflow.core.grids import Grid
from floeflow.core.polygon_file import read_polygons, within
from floeflow.scene.blocks import Sizes

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

# Widths of straits are told apart to this factor.
WIDTH_STEP = 1.25


def relative_size(
    grid: Grid, ice: Flags, land: Flags, keys: Sizes, coarse: float, crs: str
) -> Array:
    """Relative diameter of elements on the mask grid.

    Parameters
    ----------
    grid : Grid
        The mask grid.
    ice, land : ndarray
        Cells with ice and cells of land, (ny, nx).
    keys : Sizes
        The scene's block.
    coarse : float
        Diameter of an element of size 1 (m), for straits.
    crs : str
        Projection of the scene, for polygons.

    Returns
    -------
    ndarray
        (ny, nx), between `keys.smallest` and 1; defined over land and water too.

    Raises
    ------
    FloeError
        For a polygon without a size above 0 and up to 1.
    """
    size = np.ones(grid.shape)
    if keys.coast < 1 and land.any():
        size = np.minimum(size, _grown(_away(grid, land), keys.coast, keys.reach))
    water = ~ice & ~land
    if keys.edge < 1 and water.any():
        size = np.minimum(size, _grown(_away(grid, water), keys.edge, keys.reach))
    if keys.across and land.any():
        narrow = strait_width(grid, land) / (keys.across * coarse)
        size = np.minimum(size, np.maximum(narrow, keys.smallest))
    if keys.polygons:
        for polygon, wanted in sized_polygons(keys.polygons, crs):
            inside = within(polygon, *grid.mesh())
            if inside.any():
                size = np.minimum(size, _grown(_away(grid, inside), wanted, keys.reach))
    return np.maximum(size, keys.smallest)


def sized_polygons(path: str, crs: str) -> list[tuple[shapely.Geometry, float]]:
    """Polygons of a file, each with the relative size of elements in it.

    Parameters
    ----------
    path : str
        GeoJSON file.
    crs : str
        Projection to bring them to (pyproj name).

    Returns
    -------
    list of (shapely.Geometry, float)
        Polygons in projected metres, and their sizes.

    Raises
    ------
    FloeError
        For a file that cannot be read, or a polygon without a size above 0 and up to 1.
    """
    found = []
    for polygon, properties in read_polygons(path, crs):
        wanted = properties.get("size")
        truth = isinstance(wanted, bool)
        if truth or not isinstance(wanted, int | float) or not 0 < wanted <= 1:
            raise FloeError(
                f"{path}: each polygon needs a property 'size' above 0 and up to 1, "
                f"the relative size of elements in it (got {wanted!r})"
            )
        found.append((polygon, float(wanted)))
    return found


def _away(grid: Grid, flags: Flags) -> Array:
    """Distance (m) of the centres of cells from the nearest cell with the flag."""
    return np.asarray(distance_transform_edt(~flags) * grid.spacing)


def _grown(away: Array, size: float, reach: float) -> Array:
    return np.asarray(size + (1.0 - size) * np.clip(away / reach, 0.0, 1.0))


def strait_width(grid: Grid, land: Flags) -> Array:
    """Width of the water at each place: the diameter of the largest disc at sea that covers it.

    Parameters
    ----------
    grid, land
        Mask grid and its cells of land, (ny, nx).

    Returns
    -------
    ndarray
        Metres, (ny, nx), to a factor of `WIDTH_STEP` below; infinite over land.
    """
    away = _away(grid, land)
    width = np.full(grid.shape, grid.spacing)
    radius = grid.spacing
    while radius < away.max():
        reached = _away(grid, away >= radius) < radius
        width[reached] = 2.0 * radius
        radius *= WIDTH_STEP
    return np.where(land, np.inf, width)
