# SPDX-License-Identifier: GPL-2.0-or-later
"""The mask of a labelled image: each cell holds as much ice as floes cover of it.

The floes themselves go along, pixel by pixel, for the packing. All shares are exact overlaps of
pixels and cells, so that areas of floes and of the mask add up to the same.
"""

from __future__ import annotations

import logging

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.core.grids import Grid, overlaps
from floeflow.masks.labels import Floes

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

log = logging.getLogger(__name__)

# Shares of a pixel on land below this are the round-off of its sides.
ROUND_OFF = 1.0e-9


def floe_mask(
    floes: Floes, grid: Grid, land: Flags, region: Flags | None = None
) -> tuple[Array, xr.Dataset]:
    """Ice concentration of floes, and the floes themselves.

    Parameters
    ----------
    floes : Floes
        Numbered pixels in the scene's projection.
    grid : Grid
        The mask grid.
    land : ndarray
        Its cells of land, (ny, nx): a pixel that touches one holds no floe.
    region : ndarray, optional
        Cells that cut the scene, (ny, nx): a floe that touches another cell is left out.

    Returns
    -------
    siconc : ndarray
        Share of each cell that floes cover, (ny, nx).
    pixels : xarray.Dataset
        floe(floe_y, floe_x), with the pixels' centres (m).
    """
    across = overlaps(grid.x_edges, floes.grid.x_edges)
    up = overlaps(grid.y_edges, floes.grid.y_edges)
    touched = (up.T @ land.astype(float)) @ across
    ashore = touched > ROUND_OFF * floes.grid.spacing**2
    numbers = np.where(ashore, 0, floes.numbers).astype(np.int32)
    if (ashore & (floes.numbers > 0)).any():
        lost = (ashore & (floes.numbers > 0)).sum() / (floes.numbers > 0).sum()
        log.warning("%.2g %% of the floes' area lies on land cells and is left out", 100 * lost)
    if region is not None and not region.all():
        beyond = ((up.T @ (~region).astype(float)) @ across) > ROUND_OFF * floes.grid.spacing**2
        reaching = np.setdiff1d(np.unique(numbers[beyond]), [0])
        numbers[np.isin(numbers, reaching)] = 0
        log.info("%d floes reach beyond the region or a wall and are left out", len(reaching))
    covered = (up @ (numbers > 0).astype(float)) @ across.T
    siconc = np.clip(covered / grid.spacing**2, 0.0, 1.0)
    pixels = xr.Dataset(
        {"floe": (("floe_y", "floe_x"), numbers, {"long_name": "number of the floe, 0 for none"})},
        coords={
            "floe_x": ("floe_x", floes.grid.x, {"units": "m"}),
            "floe_y": ("floe_y", floes.grid.y, {"units": "m"}),
        },
        attrs={"floe_pixel": floes.grid.spacing},
    )
    return siconc, pixels
