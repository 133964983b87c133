# SPDX-License-Identifier: GPL-2.0-or-later
"""Share of land in each mask cell, from the 1 km mask of global-land-mask.

Importing that package takes two seconds and 940 MB, so this one rule does it, cuts the scene out
of it, and nobody else imports it.
"""

import logging

import numpy as np
import pyproj
import xarray as xr
from numpy.typing import NDArray

from floeflow.core.grids import Grid, mask_grid, scene_crs, to_lonlat
from floeflow.scene.blocks import Scene

Array = NDArray[np.float64]

log = logging.getLogger(__name__)

# Samples per mask cell, each way; at least one a kilometre is not worth more.
MOST_SAMPLES, SAMPLE_SPACING = 25, 1000.0


def samples_per_side(spacing: float) -> int:
    """Samples along the side of a cell: about one a kilometre, from 5 to 25."""
    return int(np.clip(round(spacing / SAMPLE_SPACING), 5, MOST_SAMPLES))


def land_share(grid: Grid, crs: pyproj.CRS) -> Array:
    """Share of land in the cells of a grid.

    Parameters
    ----------
    grid : Grid
        The mask grid.
    crs : pyproj.CRS
        Its projection.

    Returns
    -------
    ndarray
        Land fraction from regularly spaced samples, (ny, nx), 0..1.
    """
    from global_land_mask import globe

    count = samples_per_side(grid.spacing)
    offsets = ((np.arange(count) + 0.5) / count - 0.5) * grid.spacing
    share = np.empty(grid.shape)
    for row, y in enumerate(grid.y):
        # One row of cells at a time keeps the samples of a large scene out of memory.
        x_at = (grid.x[:, None] + offsets).ravel()
        x, y_at = np.meshgrid(x_at, y + offsets)
        lon, lat = to_lonlat(crs, x, y_at)
        lon = np.clip(np.mod(lon + 180.0, 360.0) - 180.0, -180.0, 180.0)
        land = globe.is_land(np.clip(lat, -90.0, 90.0), lon)
        share[row] = land.reshape(count, grid.x.size, count).mean(axis=(0, 2))
    return share


def make_land(scene: Scene) -> xr.Dataset:
    """Share of land, land_fraction(y, x), on the mask grid of a scene."""
    grid = mask_grid(scene.domain, scene.mask.refine)
    share = land_share(grid, scene_crs(scene.domain))
    log.info("land covers %.1f %% of the scene", 100.0 * share.mean())
    return xr.Dataset(
        {"land_fraction": (("y", "x"), share, {"units": "1", "long_name": "share of land"})},
        coords={"x": ("x", grid.x, {"units": "m"}), "y": ("y", grid.y, {"units": "m"})},
        attrs={"crs": scene.domain.crs},
    )
