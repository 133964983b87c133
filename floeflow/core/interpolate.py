# SPDX-License-Identifier: GPL-2.0-or-later
"""From a file's grid to places: bilinear weights, across the dateline and the pole, and filling.

Missing values (NaN) are either filled from the nearest known one first, or come out as NaN.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from floeflow.core.fields import Source
from floeflow.core.grids import EARTH_RADIUS, from_lonlat

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True)
class Weights:
    """Bilinear weights from a padded source grid to points.

    Parameters
    ----------
    index : ndarray
        Flat indices of the four corners, (4, points).
    weight : ndarray
        Their weights, which add up to 1, (4, points).
    inside : ndarray
        Whether the point lies on the source grid, half a cell beyond its last points included.
    """

    index: Index
    weight: Array
    inside: NDArray[np.bool_]

    def apply(self, padded: Array) -> Array:
        """Values at the points: (..., ny, nx) to (..., points)."""
        flat = padded.reshape(*padded.shape[:-2], -1)
        # One corner after the other: four times less memory, and a fixed order of summation. A
        # corner without weight must not count even where it is NaN.
        total = np.zeros((*flat.shape[:-1], self.index.shape[1]))
        for index, weight in zip(self.index, self.weight, strict=True):
            total += np.where(weight > 0, weight * flat[..., index], 0.0)
        return total


def weights(source: Source, lon: Array, lat: Array) -> Weights:
    """Bilinear weights from a source to places.

    Parameters
    ----------
    source : Source
        The grid, padded as `Source.padded` does.
    lon, lat : ndarray
        Places (degrees), any one shape; counted as on the source's own earth.
    """
    lon, lat = np.ravel(lon), np.ravel(lat)
    x_axis, y_axis = source.axes()
    if source.crs is None:
        half = 0.5 * (x_axis[1] - x_axis[0])
        x, y = x_axis[0] - half + np.mod(lon - x_axis[0] + half, 360.0), lat
        if source.periodic:
            x = x_axis[0] + np.mod(lon - x_axis[0], 360.0)
    else:
        x, y = from_lonlat(source.crs, lon, lat)
    column, east, inside_x = _bracket(x_axis, x)
    row, north, inside_y = _bracket(y_axis, y)
    flat = row * x_axis.size + column
    index = np.stack([flat, flat + 1, flat + x_axis.size, flat + x_axis.size + 1])
    weight = np.stack(
        [(1 - east) * (1 - north), east * (1 - north), (1 - east) * north, east * north]
    )
    return Weights(index, weight, inside_x & inside_y)


def _bracket(axis: Array, places: Array) -> tuple[Index, Array, NDArray[np.bool_]]:
    """Interval, share of the way through it, and whether on the axis up to half a cell beyond."""
    low = np.clip(np.searchsorted(axis, places, side="right") - 1, 0, axis.size - 2)
    share = (places - axis[low]) / (axis[low + 1] - axis[low])
    reach_low, reach_high = 0.5 * (axis[1] - axis[0]), 0.5 * (axis[-1] - axis[-2])
    inside = (places >= axis[0] - reach_low) & (places <= axis[-1] + reach_high)
    return low.astype(np.int64), np.where(inside, np.clip(share, 0.0, 1.0), 0.0), inside


def fill_nearest(values: Array, source: Source, reach: float) -> Array:
    """Fill missing values from the nearest known point.

    Parameters
    ----------
    values : ndarray
        (..., ny, nx), NaN where missing; what is missing is taken from the first field.
    source : Source
        Their grid.
    reach : float
        Longest distance to fill over (m); beyond it the value is 0.

    Returns
    -------
    ndarray
        The same without NaN, provided all fields miss the same points.
    """
    missing = np.isnan(values.reshape(-1, *values.shape[-2:])[0])
    filled = values.copy()
    if not missing.any():
        return filled
    lon, lat = (np.radians(part) for part in source.lonlat())
    points = EARTH_RADIUS * np.stack(
        [np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)], axis=-1
    )
    filled[..., missing] = 0.0
    if missing.all():
        return filled
    distance, nearest = cKDTree(points[~missing]).query(points[missing])
    taken = values[..., ~missing][..., nearest]
    filled[..., missing] = np.where(distance <= reach, taken, 0.0)
    return filled


def at_times(seconds: Array, values: Array, wanted: Array) -> Array:
    """Linear in time: (file's times, place) to (wanted, place); steady values stay."""
    if seconds.size == 0:
        return np.broadcast_to(values, (wanted.size, values.shape[1]))
    if seconds.size == 1:
        return np.broadcast_to(values[:1], (wanted.size, values.shape[1]))
    low = np.clip(np.searchsorted(seconds, wanted, side="right") - 1, 0, seconds.size - 2)
    share = ((wanted - seconds[low]) / (seconds[low + 1] - seconds[low]))[:, None]
    return values[low] + share * (values[low + 1] - values[low])
