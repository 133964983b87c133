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
from floeflow.masks.straits import keep_straits
from floeflow.scene.blocks import Scene

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

log = logging.getLogger(__name__)

# Samples per mask cell, each way; at least one a kilometre is not worth more.
MOST_SAMPLES, SAMPLE_SPACING = 25, 1000.0
# Samples that are kept to find straits.
MOST_KEPT = 25_000_000


def samples_per_side(spacing: float) -> int:
    """Samples along the side of a cell: about one a kilometre, from 5 to 25.

    Parameters
    ----------
    spacing : float
        Of the cells (m).

    Returns
    -------
    int
        5 to 25.
    """
    return int(np.clip(round(spacing / SAMPLE_SPACING), 5, MOST_SAMPLES))


def land_samples(grid: Grid, crs: pyproj.CRS) -> tuple[Array, Flags]:
    """Land in the cells of a grid.

    Parameters
    ----------
    grid : Grid
        The mask grid.
    crs : pyproj.CRS
        Its projection.

    Returns
    -------
    share : ndarray
        Land fraction from regularly spaced samples, (ny, nx), 0..1.
    water : ndarray
        Samples of water, as many of them as straits need and memory holds, k by k in each cell,
        (k ny, k nx).
    """
    from global_land_mask import globe

    count = samples_per_side(grid.spacing)
    keep = max(1, min(count, int(np.sqrt(MOST_KEPT / (grid.x.size * grid.y.size)))))
    kept = ((np.arange(keep) + 0.5) * count / keep).astype(int)
    offsets = ((np.arange(count) + 0.5) / count - 0.5) * grid.spacing
    share = np.empty(grid.shape)
    water = np.empty((grid.y.size, keep, grid.x.size, keep), dtype=bool)
    for row, y in enumerate(grid.y):
        # One row of cells at a time keeps the samples of a large scene out of memory.
        x_at = (grid.x[:, None] + offsets).ravel()
        x, y_at = np.meshgrid(x_at, y + offsets)
        lon, lat = to_lonlat(crs, x, y_at)
        lon = np.clip(np.mod(lon + 180.0, 360.0) - 180.0, -180.0, 180.0)
        land = globe.is_land(np.clip(lat, -90.0, 90.0), lon).reshape(count, grid.x.size, count)
        share[row] = land.mean(axis=(0, 2))
        water[row] = ~land[kept][:, :, kept]
    return share, water.reshape(grid.y.size * keep, grid.x.size * keep)


def make_land(scene: Scene) -> xr.Dataset:
    """Share of land, and land with its straits, both (y, x), on the mask grid of a scene.

    Parameters
    ----------
    scene : Scene
        Its keys.

    Returns
    -------
    xarray.Dataset
        Share of land (1) and land with its straits (1 land, 0 water), (y, x) each, on axes in m.
    """
    grid = mask_grid(scene.domain, scene.mask.refine)
    share, water = land_samples(grid, scene_crs(scene.domain))
    coarse = share >= scene.mask.land_fraction
    land = keep_straits(coarse, water)
    log.info(
        "land covers %.1f %% of the scene; for straits and inland seas %d cells became water and "
        "%d land",
        *(100.0 * land.mean(), (coarse & ~land).sum(), (land & ~coarse).sum()),
    )
    dims, units = ("y", "x"), {"units": "1"}
    return xr.Dataset(
        {
            "land_fraction": (dims, share, units | {"long_name": "share of land"}),
            "land": (dims, land.astype(np.int8), units | {"long_name": "1 land, 0 water"}),
        },
        coords={"x": ("x", grid.x, {"units": "m"}), "y": ("y", grid.y, {"units": "m"})},
        attrs={"crs": scene.domain.crs},
    )
