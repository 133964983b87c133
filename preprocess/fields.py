# SPDX-License-Identifier: GPL-2.0-or-later
"""Gridded fields of a user's file brought to points of the scene.

Bilinear interpolation on longitude/latitude grids (any order of latitude, longitudes 0..360 or
-180..180, the dateline and the pole crossed) and on projected grids. No value of a fill is ever
used: missing values are NaN here, and are either filled from the nearest known one or refused.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyproj
import xarray as xr
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from floeflow.errors import FloeError
from floeflow.preprocess import cf
from floeflow.preprocess.grids import from_lonlat, to_lonlat

Array = NDArray[np.float64]
Index = NDArray[np.int64]

EARTH_RADIUS = 6371.0e3


@dataclass(frozen=True)
class Source:
    """The horizontal grid of a file's variable, axes ascending.

    Parameters
    ----------
    x, y : ndarray
        Longitude and latitude (degrees), or projected coordinates (m), (nx,) and (ny,).
    crs : pyproj.CRS or None
        Projection; None on longitude and latitude.
    order_x, order_y : ndarray
        Columns and rows of the file in the order of ``x`` and ``y``.
    periodic : bool
        Whether the longitudes go all the way round.
    caps : tuple of bool
        Whether a row at the south and the north pole is to be added.
    """

    x: Array
    y: Array
    crs: pyproj.CRS | None
    order_x: Index
    order_y: Index
    periodic: bool
    caps: tuple[bool, bool]

    def lonlat(self) -> tuple[Array, Array]:
        """Longitude and latitude of all points (degrees), each (ny, nx)."""
        x, y = np.meshgrid(self.x, self.y)
        return (x, y) if self.crs is None else to_lonlat(self.crs, x, y)

    def padded(self, values: Array) -> Array:
        """Add the wrapped column and the rows at the poles (mean of the last row)."""
        south, north = self.caps
        rows = [values]
        if south:
            rows.insert(0, _mean_row(values[..., :1, :]))
        if north:
            rows.append(_mean_row(values[..., -1:, :]))
        values = np.concatenate(rows, axis=-2)
        return np.concatenate([values, values[..., :1]], axis=-1) if self.periodic else values

    def axes(self) -> tuple[Array, Array]:
        """Axes of the padded grid."""
        south, north = self.caps
        y = np.concatenate([[-90.0] * south, self.y, [90.0] * north])
        x = np.append(self.x, self.x[0] + 360.0) if self.periodic else self.x
        return x, y


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


def _mean_row(row: Array) -> Array:
    return np.broadcast_to(row.mean(axis=-1, keepdims=True), row.shape)


def open_file(path: str | Path) -> xr.Dataset:
    """Open a file lazily, numbers unpacked and fills as NaN, times as they stand.

    Raises
    ------
    FloeError
        Where it cannot be read.
    """
    try:
        return xr.open_dataset(path, engine="netcdf4", decode_times=False, mask_and_scale=True)
    except Exception as error:  # a damaged HDF5 file raises whatever its bytes lead to
        raise FloeError(f"{path}: cannot be read as NetCDF ({type(error).__name__})") from None


def read_values(
    data: xr.Dataset, name: str, layout: cf.Layout, source: Source, times: Index, path: str | Path
) -> Array:
    """Values of a variable at some of its times, axes ascending, NaN where missing.

    Of several levels the one nearest the surface is taken.

    Returns
    -------
    ndarray
        (times, ny, nx); a variable without time counts as one of a single time.

    Raises
    ------
    FloeError
        Where the file turns out damaged, or the values are no numbers.
    """
    field = data[name]
    if layout.level:
        level = np.asarray(data[layout.level].values, dtype=float)
        field = field.isel({layout.level: int(np.argmin(np.abs(level)))})
    if layout.time:
        field = field.isel({layout.time: times})
    else:
        field = field.expand_dims("one time")
    keep = (layout.time or "one time", layout.y, layout.x)
    field = field.isel({dim: 0 for dim in field.dims if dim not in keep})
    try:
        values = np.asarray(field.transpose(*keep).values, dtype=float)
    except (TypeError, ValueError):
        raise FloeError(f"{path}: variable '{name}' holds no numbers") from None
    except Exception as error:  # as above
        raise FloeError(
            f"{path}: variable '{name}' cannot be read ({type(error).__name__})"
        ) from None
    values = values[:, source.order_y][:, :, source.order_x]
    for key, beyond in (("valid_min", np.less), ("valid_max", np.greater)):
        bound = field.attrs.get(key)
        # Bounds are in packed numbers; only those of unpacked variables are plain.
        if bound is not None and "scale_factor" not in data[name].encoding:
            values[beyond(values, float(bound))] = np.nan
    values[~np.isfinite(values)] = np.nan
    return values


def source_grid(
    variables: dict[str, cf.Variable],
    variable: cf.Variable,
    layout: cf.Layout,
    data: xr.Dataset,
    path: str | Path,
) -> Source:
    """Horizontal grid of a variable.

    Raises
    ------
    FloeError
        Where coordinates are missing, repeated or not finite, or where the grid mapping does not
        fit the latitudes and longitudes that the file gives beside it.
    """
    x = np.asarray(data[layout.x].values, dtype=float) * layout.scale
    y = np.asarray(data[layout.y].values, dtype=float) * layout.scale
    if layout.lonlat:
        x = np.mod(x, 360.0)
        if np.any(np.abs(y) > 90.0 + 1e-6):
            raise FloeError(f"{path}: latitudes '{layout.y}' reach beyond 90 degrees")
        y = np.clip(y, -90.0, 90.0)
    x_axis, order_x = _ascending(x, layout.x, path, drop_repeated=layout.lonlat)
    y_axis, order_y = _ascending(y, layout.y, path, drop_repeated=False)
    if not layout.lonlat:
        crs = cf.projection(variables, variable, path)
        source = Source(x_axis, y_axis, crs, order_x, order_y, False, (False, False))
        _check_mapping(source, layout, data, path)
        return source
    # Start behind the widest gap, so that a regional grid across Greenwich stays in one piece.
    gaps = np.diff(np.append(x_axis, x_axis[0] + 360.0))
    start = (int(np.argmax(gaps)) + 1) % x_axis.size
    x_axis = np.concatenate([x_axis[start:], x_axis[:start] + 360.0])
    order_x = np.roll(order_x, -start)
    periodic = bool(gaps.max() <= 1.5 * np.median(gaps))
    reach = 1.01 * float(np.median(np.diff(y_axis)))
    south = periodic and -90.0 < y_axis[0] <= -90.0 + reach
    north = periodic and 90.0 - reach <= y_axis[-1] < 90.0
    return Source(x_axis, y_axis, None, order_x, order_y, periodic, (bool(south), bool(north)))


def _ascending(
    axis: Array, name: str, path: str | Path, drop_repeated: bool
) -> tuple[Array, Index]:
    if not np.isfinite(axis).all():
        raise FloeError(f"{path}: coordinate '{name}' has missing values")
    order = np.argsort(axis, kind="stable")
    if drop_repeated:
        # Some files give the first meridian again at the end.
        order = order[np.concatenate([[True], np.diff(axis[order]) > 1e-9])]
    if order.size < 2 or np.any(np.diff(axis[order]) <= 0):
        raise FloeError(f"{path}: coordinate '{name}' has under two different values, or repeats")
    return axis[order], order


def _check_mapping(source: Source, layout: cf.Layout, data: xr.Dataset, path: str | Path) -> None:
    """Compare the grid mapping with the file's own two-dimensional latitudes, if it has them."""
    for name, field in data.variables.items():
        if set(field.dims) != {layout.x, layout.y} or field.attrs.get(
            "standard_name"
        ) not in ("latitude", "longitude"):
            continue
        given = field.transpose(layout.y, layout.x).values[np.ix_(source.order_y, source.order_x)]
        lon, lat = source.lonlat()
        computed = lat if field.attrs["standard_name"] == "latitude" else lon
        off = np.mod(given - computed + 180.0, 360.0) - 180.0
        if field.attrs["standard_name"] == "longitude":
            off = off * np.cos(np.radians(lat))
        distance = np.nanmax(np.abs(np.radians(off))) * EARTH_RADIUS
        if distance > 0.5 * np.diff(source.x).max():
            raise FloeError(
                f"{path}: the grid mapping lies up to {distance / 1e3:.0f} km off the file's own "
                f"'{name}'"
            )


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
