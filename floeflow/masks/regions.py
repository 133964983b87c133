# SPDX-License-Identifier: GPL-2.0-or-later
"""Regions that cut a scene: named seas, and polygons of the user's.

Named seas are boxes in longitude and latitude, drawn after the regions in which ice extent is
commonly told. They are no legal limits; a polygon of one's own is one file away.
"""

from __future__ import annotations

from difflib import get_close_matches

import numpy as np
import shapely
from numpy.typing import NDArray

from floeflow.core.errors import FloeError
from floeflow.core.grids import Grid, mask_grid
from floeflow.core.polygon_file import project, read_polygons, within
from floeflow.core.polygon_names import is_polygon_file
from floeflow.scene import Scene

Flags = NDArray[np.bool_]

# West, east (degrees east, east of west), south, north.
SEAS = {
    "baffin_bay": (-82.0, -48.0, 60.0, 80.0),
    "barents_sea": (15.0, 55.0, 66.0, 82.0),
    "beaufort_sea": (-156.0, -120.0, 68.0, 77.0),
    "bellingshausen_sea": (-100.0, -60.0, -76.0, -60.0),
    "bering_sea": (162.0, 203.0, 51.0, 66.0),
    "canadian_archipelago": (-125.0, -82.0, 66.0, 82.0),
    "central_arctic": (0.0, 360.0, 80.0, 90.0),
    "chukchi_sea": (180.0, 204.0, 66.0, 77.0),
    "east_siberian_sea": (145.0, 180.0, 68.0, 80.0),
    "fram_strait": (-20.0, 15.0, 76.0, 82.0),
    "greenland_sea": (-44.0, 15.0, 66.0, 82.0),
    "hudson_bay": (-95.0, -65.0, 51.0, 66.0),
    "kara_sea": (55.0, 100.0, 66.0, 82.0),
    "laptev_sea": (100.0, 145.0, 70.0, 82.0),
    "okhotsk_sea": (135.0, 162.0, 43.0, 62.0),
    "ross_sea": (160.0, 230.0, -79.0, -60.0),
    "weddell_sea": (-62.0, 20.0, -79.0, -60.0),
}


def check_regions(scene: Scene) -> None:
    """Refuse a region or shoreline that the mask stage could not use.

    Parameters
    ----------
    scene : Scene
        Blocks ``domain`` and ``mask``.

    Raises
    ------
    FloeError
        As `region_cells` and `shore_cells`.
    """
    grid = mask_grid(scene.domain, scene.mask.refine)
    if scene.mask.region:
        region_cells(scene.mask.region, grid, scene.domain.crs)
    if scene.mask.shoreline:
        shore_cells(scene.mask.shoreline, grid, scene.domain.crs)


def region_cells(region: str, grid: Grid, crs: str) -> Flags:
    """Cells of a grid whose centres lie in a region.

    Parameters
    ----------
    region : str
        Name of a sea, or a file of polygons (GeoJSON, shapefile).
    grid : Grid
        The mask grid.
    crs : str
        Its projection (pyproj name).

    Returns
    -------
    ndarray
        (ny, nx).

    Raises
    ------
    FloeError
        Where it is no sea and no file, or lies wholly outside of the grid.
    """
    if region in SEAS:
        west, east, south, north = SEAS[region]
        polygons = [project(_box(west, east, south, north), crs, f"mask.region: {region}")]
    elif is_polygon_file(region):
        polygons = [polygon for polygon, _ in read_polygons(region, crs)]
    else:
        near = get_close_matches(region, SEAS, n=1)
        hint = f"did you mean '{near[0]}'?" if near else "known are " + ", ".join(SEAS)
        raise FloeError(
            f"mask.region: '{region}' is neither a named sea nor a file of polygons (.json, "
            f".geojson, .shp); {hint}"
        )
    inside = polygon_cells(polygons, grid)
    if not inside.any():
        raise FloeError(f"mask.region: '{region}' lies wholly outside of the scene (domain)")
    return inside


def _box(west: float, east: float, south: float, north: float) -> shapely.Polygon:
    """Box in longitude and latitude; all round the pole it is what lies within its parallel."""
    if east - west == 360.0:
        longitude = np.linspace(west, east, 361)
        return shapely.Polygon(np.stack([longitude, np.full(361, south)], axis=1))
    # Corners nearer than half a turn, or a side would go the other way.
    longitude = np.linspace(west, east, 5)
    low = np.stack([longitude, np.full(5, south)], axis=1)
    return shapely.Polygon(np.concatenate([low, np.stack([longitude, np.full(5, north)], 1)[::-1]]))


def polygon_cells(polygons: list[shapely.Geometry], grid: Grid) -> Flags:
    """Cells of a grid whose centres lie in one of some polygons (m), (ny, nx).

    Parameters
    ----------
    polygons : list of shapely.Geometry
        m, in the projection of the grid.
    grid : Grid
        Cells.

    Returns
    -------
    Flags
        bool.
    """
    inside = np.zeros(grid.shape, dtype=bool)
    for polygon in polygons:
        inside |= within(polygon, *grid.mesh())
    return inside


def shore_cells(path: str, grid: Grid, crs: str) -> Flags:
    """Cells of land by a shoreline of the user's: polygons of a file, (ny, nx).

    Parameters
    ----------
    path : str
        File of polygons.
    grid : Grid
        Cells.
    crs : str
        Projection of the grid.

    Returns
    -------
    ndarray of bool
        (ny, nx).

    Raises
    ------
    FloeError
        For a file that cannot be read, or holds no polygons; where none of them covers the centre
        of a cell.
    """
    polygons = [polygon for polygon, _ in read_polygons(path, crs)]
    inside = polygon_cells(polygons, grid)
    if not inside.any():
        x, y = grid.x_edges, grid.y_edges
        domain = shapely.box(x[0], y[0], x[-1], y[-1])
        if any(shapely.intersects(domain, polygon) for polygon in polygons):
            why = (
                f"is narrower than the mask's cells of {grid.spacing:g} m and adds no land: take a "
                "finer mask (domain.spacing, mask.refine) or leave the key out"
            )
        else:
            why = (
                "lies wholly outside of the scene (domain): check its coordinates, or leave the "
                "key out"
            )
        raise FloeError(f"mask.shoreline: '{path}' {why}")
    return inside
