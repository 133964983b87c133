# SPDX-License-Identifier: GPL-2.0-or-later
"""Where the sea is: its area in the cells of the scene's grid, and places where ice can float."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from floeflow.core.grids import scene_grid
from floeflow.coupling.sea.shares import balanced_pull
from floeflow.scene.blocks import Scene
from floeflow.state import read_dataset
from floeflow.transfer import Grid

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True)
class SeaPlaces:
    """The sea of a scene.

    Parameters
    ----------
    grid : Grid
        The scene's grid.
    area : ndarray
        Sea in its cells (m2), (ny, nx).
    x, y : ndarray
        Centres of the mask's cells that are sea (m), (m,).
    cell : ndarray
        Flat index of the grid's cell in which each lies, (m,).
    shore : ndarray
        Distance from each to land (m), (m,); infinite where there is none.
    concentration, thickness : ndarray
        Of the mask's ice (1, m), (m,).
    pull : ndarray
        Of the grid's cells, (cells,): `floeflow.coupling.sea.shares.balanced_pull`.
    """

    grid: Grid
    area: Array
    x: Array
    y: Array
    cell: Index
    shore: Array
    concentration: Array
    thickness: Array
    pull: Array


def sea_places(mask: xr.Dataset, x: Array, y: Array) -> SeaPlaces:
    """Find the sea of a scene.

    Parameters
    ----------
    mask : xarray.Dataset
        land and cell_area (m2) on the mask grid.
    x, y : ndarray
        Nodes of the scene's grid (m).

    Returns
    -------
    SeaPlaces
        Area of sea in each cell (m2), the places at sea (m), their cells, distance from the shore,
        concentration (1), thickness (m), and the cells' pulls (1).
    """
    grid = Grid(x, y)
    across, up = np.meshgrid(mask["x"].values, mask["y"].values)
    land = mask["land"].values != 0
    px, py = across[~land], up[~land]
    cell, wet = grid.cell_of(px, py), mask["cell_area"].values[~land].astype(np.float64)
    area = np.bincount(cell, wet, x.size * y.size).astype(np.float64)
    shore = np.full(px.size, np.inf)
    if land.any():
        spacing = float(mask["x"].values[1] - mask["x"].values[0])
        tree = cKDTree(np.stack([across[land], up[land]], axis=1))
        away = tree.query(np.stack([px, py], axis=1))[0]
        shore = np.asarray(away - 0.5 * spacing)
    concentration, thickness = (mask[name].values[~land] for name in ("siconc", "sithick"))
    pull = balanced_pull(px, py, wet, grid)
    sea = area.reshape(grid.shape)
    return SeaPlaces(grid, sea, px, py, cell, shore, concentration, thickness, pull)


def read_places(scene: Scene, path: str) -> SeaPlaces:
    """The sea of a scene from the file of its mask.

    Parameters
    ----------
    scene : Scene
        Its grid.
    path : str
        NetCDF file of the mask.

    Returns
    -------
    SeaPlaces
        Cells, their area of sea (m2) and their places.

    Raises
    ------
    FloeError
        For a file that cannot be read.
    """
    grid = scene_grid(scene.domain)
    return sea_places(read_dataset(path), grid.x, grid.y)


def cell_means(places: SeaPlaces, mask: xr.Dataset, field: Array, weight: Array) -> Array:
    """Means of a field of the mask grid over the sea in the scene's cells.

    Parameters
    ----------
    places : SeaPlaces
        The sea.
    mask : xarray.Dataset
        land and cell_area (m2) on the mask grid.
    field, weight : ndarray
        On the mask grid, (rows, columns); the weight is multiplied by the area.

    Returns
    -------
    ndarray
        (ny, nx), NaN where nothing that is known has weight.
    """
    sea = mask["land"].values == 0
    known = np.isfinite(field[sea])
    amount = np.where(known, mask["cell_area"].values[sea] * weight[sea], 0.0)
    count = places.area.size
    total = np.bincount(places.cell, amount, count)
    found = np.bincount(places.cell, amount * np.where(known, field[sea], 0.0), count)
    mean = np.divide(found, total, out=np.full(count, np.nan), where=total > 0.0)
    return mean.reshape(places.area.shape)
