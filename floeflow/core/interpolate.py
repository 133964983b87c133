# SPDX-License-Identifier: GPL-2.0-or-later
"""From a file's grid to places: bilinear weights, across the dateline and the pole, and filling.

Missing values (NaN) are either filled from the nearest known one first, or come out as NaN.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import pyproj
from numpy.typing import NDArray
from scipy.spatial import Delaunay, QhullError, cKDTree

from floeflow.core.fields import AnySource, Curvilinear, Source
from floeflow.core.grids import EARTH_RADIUS, from_lonlat

Array = NDArray[np.float64]
Index = NDArray[np.int64]

# A triangle between points of a curvilinear grid may be so many of their distances wide: wider
# ones lie over blocks of the grid that the file leaves out.
WIDEST = 3.0


class Transfer(Protocol):
    """Something that brings fields of a source to places: bilinear weights, or area means."""

    @property
    def inside(self) -> NDArray[np.bool_]:
        """Whether the source covers the place, (points,)."""

    def of(self, values: Array) -> Array:
        """Values at the places: (..., ny, nx) of the source, unpadded, to (..., points).

        Parameters
        ----------
        values : ndarray
            In any unit.

        Returns
        -------
        ndarray
            In the unit of the values, (..., points).
        """


@dataclass(frozen=True)
class Weights:
    """Bilinear weights from a padded source grid to points.

    Parameters
    ----------
    index : ndarray
        Flat indices of the corners, (4, points), or (3, points) on a curvilinear grid.
    weight : ndarray
        Their weights, which add up to 1, same shape.
    inside : ndarray
        Whether the point lies on the source grid, half a cell beyond its last points included.
    source : Source or Curvilinear
        The grid.
    distance : ndarray or None
        How far a point that is not inside lies from the point it takes (m), (points,); None on
        regular grids.
    """

    index: Index
    weight: Array
    inside: NDArray[np.bool_]
    source: AnySource
    distance: Array | None = None

    def of(self, values: Array) -> Array:
        """Values at the points: (..., ny, nx), unpadded, to (..., points).

        Parameters
        ----------
        values : ndarray
            In any unit.

        Returns
        -------
        ndarray
            In the unit of the values, (..., points).
        """
        source = self.source
        return self.apply(source.padded(values) if isinstance(source, Source) else values)

    def apply(self, padded: Array) -> Array:
        """Values at the points: (..., ny, nx) to (..., points).

        Parameters
        ----------
        padded : ndarray
            With the wrapped column and the rows at the poles.

        Returns
        -------
        ndarray
            In the unit of the values, (..., points).
        """
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

    Returns
    -------
    Weights
        Four corners of each place; places beside the source are marked.
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
    return Weights(index, weight, inside_x & inside_y, source)


def triangle_weights(source: Curvilinear, plane: pyproj.CRS, lon: Array, lat: Array) -> Weights:
    """Linear weights on triangles between the points of a curvilinear grid.

    The triangles (Delaunay) are drawn on the map of the places, so that neither seams nor folds of
    the grid, nor the pole, matter. A place beyond them takes the nearest point.

    Parameters
    ----------
    source : Curvilinear
        The grid.
    plane : pyproj.CRS
        Projection on which they are drawn.
    lon, lat : ndarray
        Places (degrees), any one shape.

    Returns
    -------
    Weights
        Three corners of each place, or one beyond the triangles, with its distance (m).
    """
    place = np.stack(from_lonlat(plane, np.ravel(lon), np.ravel(lat)), axis=1)
    x, y = from_lonlat(plane, source.lon, source.lat)
    spacing = local_spacing(x, y)
    low, high = place.min(axis=0), place.max(axis=0)
    margin = WIDEST * float(np.nanmedian(spacing)) + 0.1 * float((high - low).max())
    # Seams repeat their points: of those at one place the first counts.
    near = np.isfinite(x) & np.isfinite(y) & np.isfinite(spacing)
    near &= (x >= low[0] - margin) & (x <= high[0] + margin)
    near &= (y >= low[1] - margin) & (y <= high[1] + margin)
    kept = np.flatnonzero(near)
    points = np.stack([x.ravel()[kept], y.ravel()[kept]], axis=1)
    _, first = np.unique(np.round(points, 1), axis=0, return_index=True)
    kept, points = kept[np.sort(first)], points[np.sort(first)]
    count = len(place)
    nothing = Weights(
        np.zeros((3, count), np.int64), np.zeros((3, count)), np.zeros(count, bool), source,
        np.full(count, np.inf),
    )  # fmt: skip
    if len(points) == 0:
        return nothing
    distance, nearest = cKDTree(points).query(place)
    index = np.repeat(kept[nearest][None], 3, axis=0)
    weight = np.zeros((3, count))
    weight[0] = 1.0
    inside = np.zeros(count, bool)
    try:
        mesh = Delaunay(points)
    except (QhullError, ValueError):  # all points on a line
        return Weights(index, weight, inside, source, distance)
    found = mesh.find_simplex(place)
    inside = found >= 0
    corner = mesh.simplices[found]
    sides = [points[corner[:, a]] - points[corner[:, b]] for a, b in ((0, 1), (1, 2), (2, 0))]
    longest = np.max([np.hypot(*side.T) for side in sides], axis=0)
    allowed = WIDEST * spacing.ravel()[kept[corner]].max(axis=1)
    inside &= longest <= allowed
    matrix = mesh.transform[found]
    two = np.einsum("kij,kj->ki", matrix[:, :2], place - matrix[:, 2])
    three = np.clip(np.concatenate([two, 1.0 - two.sum(axis=1, keepdims=True)], axis=1), 0.0, 1.0)
    three /= three.sum(axis=1, keepdims=True)
    inside &= np.isfinite(three).all(axis=1)
    index[:, inside], weight[:, inside] = kept[corner[inside]].T, three[inside].T
    return Weights(index, weight, inside, source, np.where(inside, 0.0, distance))


def local_spacing(x: Array, y: Array) -> Array:
    """Longer of the distances to the next points along both axes of a grid (m), (ny, nx).

    Parameters
    ----------
    x : ndarray
        m, (ny, nx).
    y : ndarray
        m, (ny, nx).

    Returns
    -------
    ndarray
        NaN for a point without known neighbours.
    """
    far = np.full(x.shape, np.nan)
    with np.errstate(invalid="ignore"):
        along = np.hypot(np.diff(x, axis=1), np.diff(y, axis=1))
        across = np.hypot(np.diff(x, axis=0), np.diff(y, axis=0))
    for part, rows, columns in (
        (along, slice(None), slice(1, None)),
        (along, slice(None), slice(None, -1)),
        (across, slice(1, None), slice(None)),
        (across, slice(None, -1), slice(None)),
    ):
        far[rows, columns] = np.fmax(far[rows, columns], part)
    return far


def _bracket(axis: Array, places: Array) -> tuple[Index, Array, NDArray[np.bool_]]:
    """Interval, share of the way through it, and whether on the axis up to half a cell beyond."""
    low = np.clip(np.searchsorted(axis, places, side="right") - 1, 0, axis.size - 2)
    share = (places - axis[low]) / (axis[low + 1] - axis[low])
    reach_low, reach_high = 0.5 * (axis[1] - axis[0]), 0.5 * (axis[-1] - axis[-2])
    inside = (places >= axis[0] - reach_low) & (places <= axis[-1] + reach_high)
    return low.astype(np.int64), np.where(inside, np.clip(share, 0.0, 1.0), 0.0), inside


def fill_nearest(values: Array, source: AnySource, reach: float) -> Array:
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
    # Points without a place are used by no weight.
    placed = np.isfinite(points).all(axis=-1)
    known, wanted = placed & ~missing, placed & missing
    if not known.any() or not wanted.any():
        return filled
    distance, nearest = cKDTree(points[known]).query(points[wanted])
    taken = values[..., known][..., nearest]
    filled[..., wanted] = np.where(distance <= reach, taken, 0.0)
    return filled


def at_times(seconds: Array, values: Array, wanted: Array) -> Array:
    """Linear in time: (file's times, place) to (wanted, place); steady values stay.

    Parameters
    ----------
    seconds : ndarray
        Of the file (s), ascending, (times,).
    values : ndarray
        (times, places).
    wanted : ndarray
        s, (k,).

    Returns
    -------
    ndarray
        (k, places); read-only for steady values.
    """
    if seconds.size == 0:
        return np.broadcast_to(values, (wanted.size, values.shape[1]))
    if seconds.size == 1:
        return np.broadcast_to(values[:1], (wanted.size, values.shape[1]))
    low = np.clip(np.searchsorted(seconds, wanted, side="right") - 1, 0, seconds.size - 2)
    share = ((wanted - seconds[low]) / (seconds[low + 1] - seconds[low]))[:, None]
    return values[low] + share * (values[low + 1] - values[low])
