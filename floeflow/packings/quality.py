# SPDX-License-Identifier: GPL-2.0-or-later
"""How good a packing is, in figures: sizes, contacts, overlaps, isotropy, ice and the mask's."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.core.clip import shared
from floeflow.core.near import deepest_overlap
from floeflow.core.period import period_of, shortest
from floeflow.packings.discs import outlines
from floeflow.packings.elements import grid_of
from floeflow.packings.tessellation import cell_corners, touched
from floeflow.state.schema import MOBILE

Array = NDArray[np.float64]

# Discs with a gap below this share of their radii's sum are in touch.
TOUCH = 1.0e-3
# Side of the boxes in which ice is compared with the mask (m).
BOX = 1.0e5
# Names of the figures in packing.nc start with this.
PREFIX = "quality_"
LABELS = {
    "radius_least": ("Smallest radius", "m"),
    "radius_median": ("Median radius", "m"),
    "radius_largest": ("Largest radius", "m"),
    "size_median": ("Median size of a cell (root of its area)", "m"),
    "size_spread": ("Spread of cell sizes (standard deviation of the logarithm)", "1"),
    "disc_share": ("Share of the ice's area that discs fill", "1"),
    "coordination": ("Discs in touch with a disc, mean", "1"),
    "neighbours": ("Cells that share a side with a cell, mean", "1"),
    "anisotropy": ("Anisotropy of the lines of centres (0 none, 1 all in one direction)", "1"),
    "overlap": ("Largest overlap over the sum of two radii", "1"),
    "ashore": ("Area of discs on land over the ice's area on the map", "1"),
    "area_error": ("Ice area against the mask's, relative", "1"),
    "volume_error": ("Ice volume against the mask's, relative", "1"),
    "box_error": (
        "Ice area in boxes of 100 km against the mask's (rms, of a box)",
        "1",
    ),
    "size_error": ("Cell sizes against the size function (standard deviation of the ratio)", "1"),
    "outline_distance": ("Discs from the outlines of their floes, mean", "m"),
    "outline_share": ("The same over the radius of a disc of the median floe's area", "1"),
    "moment_error": (
        "Second moments of floes of several discs against the image's, over their trace, largest",
        "1",
    ),
    "moment_share": ("Share of these floes whose second moments are off by more than 1 %", "1"),
}


def quality(mask: xr.Dataset, packing: xr.Dataset) -> dict[str, float]:
    """Figures of a packing, by the names of `LABELS`; none without elements.

    Parameters
    ----------
    mask, packing : xarray.Dataset
        Outputs of those stages.

    Returns
    -------
    dict of float
        Each in the unit that its label tells.
    """
    mobile = packing["type"].values == MOBILE
    if not mobile.any():
        return {}
    places = np.stack([packing["x"].values, packing["y"].values], axis=1)
    radius, area = packing["radius"].values, packing["area"].values[mobile]
    own, size = radius[mobile], np.sqrt(area)
    period = period_of(packing.attrs)
    apart, touching = _edges(packing)
    span = np.hypot(*apart.T)
    out = {
        "radius_least": float(own.min()),
        "radius_median": float(np.median(own)),
        "radius_largest": float(own.max()),
        "size_median": float(np.median(size)),
        "size_spread": float(np.log(size).std()),
        "disc_share": float(np.pi * (own**2).sum() / _plane_area(mask)),
        "coordination": 2.0 * float(touching.sum()) / len(own),
        "neighbours": 2.0 * len(span) / len(own),
        "anisotropy": _anisotropy(apart, span),
        "overlap": deepest_overlap(places, radius, int(mobile.sum()), period),
        "ashore": _on_land(mask, places[mobile], own) / _plane_area(mask),
    }
    return out | _ice(mask, packing.isel(element=np.flatnonzero(mobile)))


def _edges(packing: xr.Dataset) -> tuple[Array, NDArray[np.bool_]]:
    """Lines between the centres on both sides of each edge (m), (edge, 2); and which touch."""
    places = np.stack([packing["x"].values, packing["y"].values], axis=1)
    radius = packing["radius"].values
    lo, hi = packing["edge_lo"].values - 1, packing["edge_hi"].values - 1
    dx, dy = (places[hi] - places[lo]).T
    apart = np.column_stack(shortest((dx, dy), period_of(packing.attrs)))
    return apart, np.hypot(*apart.T) < (1.0 + TOUCH) * (radius[lo] + radius[hi])


def neighbour_counts(packing: xr.Dataset) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """With how many others each mobile element shares a side of its cell, and how many touch it.

    Parameters
    ----------
    packing : xarray.Dataset
        Output of that stage.

    Returns
    -------
    tuple of ndarray
        (n,) each.
    """
    mobile = packing["type"].values == MOBILE
    count = mobile.size
    ends = np.stack([packing["edge_lo"].values, packing["edge_hi"].values]) - 1
    _, touching = _edges(packing)
    found = [np.bincount(each.ravel(), minlength=count) for each in (ends, ends[:, touching])]
    return found[0][mobile], found[1][mobile]


def _on_land(mask: xr.Dataset, places: Array, radius: Array) -> float:
    """Area (m2) of discs on land, as regular polygons of their areas."""
    grid, land = grid_of(mask), mask["land"].values > 0
    if not land.any():
        return 0.0
    low, high = places - radius[:, None], places + radius[:, None]
    disc, cell = touched(grid, land, np.column_stack([low, high]))
    near, row = np.unique(disc, return_inverse=True)
    if not len(near):
        return 0.0
    corners = outlines(places[near], radius[near])
    start, ring = corners.shape[1] * np.arange(len(near) + 1), corners.reshape(-1, 2)
    cells, box = np.unique(cell, return_inverse=True)
    fours, squares = cell_corners(grid, cells)
    area, _ = shared(fours, squares, start, ring, box, row)
    return float(area.sum())


def _plane_area(mask: xr.Dataset) -> float:
    """Area under ice cells, or under floes, on the map (m2)."""
    if "floe" in mask:
        return float((mask["floe"].values > 0).sum()) * float(mask.attrs["floe_pixel"]) ** 2
    return float((mask["siconc"].values > 0).sum()) * grid_of(mask).spacing ** 2


def _anisotropy(apart: Array, span: Array) -> float:
    """Difference of the fabric tensor's eigenvalues: of the mean of n n^T over lines of centres."""
    if not len(span):
        return 0.0
    n = apart / span[:, None]
    values = np.linalg.eigvalsh(n.T @ n / len(n))
    return float(values[1] - values[0])


def _ice(mask: xr.Dataset, elements: xr.Dataset) -> dict[str, float]:
    cell, siconc = mask["cell_area"].values, mask["siconc"].values
    area = elements["area"].values
    ice = area * elements["ice_fraction"].values.sum(axis=1)
    volume = float((area * elements["ice_volume"].values.sum(axis=1)).sum())
    held = float((cell * siconc * mask["sithick"].values).sum())
    wanted = float((cell * siconc).sum())
    grid = grid_of(mask)
    x, y = grid.mesh()
    count = [int(np.ceil(n * grid.spacing / BOX)) for n in grid.shape]

    def boxed(x: Array, y: Array, amount: Array) -> Array:
        row = np.clip((y - grid.y_min) // BOX, 0, count[0] - 1).astype(int)
        column = np.clip((x - grid.x_min) // BOX, 0, count[1] - 1).astype(int)
        flat = (row * count[1] + column).ravel()
        return np.bincount(flat, amount.ravel(), minlength=count[0] * count[1]).astype(float)

    off = boxed(elements["x"].values, elements["y"].values, ice) - boxed(x, y, cell * siconc)
    some = boxed(x, y, siconc) > 0
    return {
        "area_error": float(ice.sum()) / wanted - 1.0,
        "volume_error": volume / held - 1.0,
        "box_error": float(np.sqrt((off[some] ** 2).mean())) / BOX**2,
    }
