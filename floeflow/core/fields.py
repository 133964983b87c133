# SPDX-License-Identifier: GPL-2.0-or-later
"""Gridded fields of a user's file: their grid and their values, axes ascending.

Longitude/latitude grids (any order of latitude, longitudes 0..360 or -180..180), projected grids,
and curvilinear ones with two-dimensional longitudes and latitudes. No value of a fill is ever used:
missing values are NaN from here on.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyproj
import xarray as xr
from numpy.typing import NDArray

from floeflow.core import cf_reading as cf
from floeflow.core import levels
from floeflow.core.errors import FloeError
from floeflow.core.grids import EARTH_RADIUS, metres_per_unit, to_lonlat
from floeflow.core.input_files import Hints, open_input
from floeflow.core.unpack import Flags, Values, status_flags, unpack

Array = NDArray[np.float64]
Index = NDArray[np.int64]


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
        """Add the wrapped column and the rows at the poles (mean of the last row).

        Parameters
        ----------
        values : ndarray
            (..., ny, nx).

        Returns
        -------
        ndarray
            With a column and rows more where the source has them, (..., ny + caps, nx + wrap).
        """
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


def _mean_row(row: Array) -> Array:
    return np.broadcast_to(row.mean(axis=-1, keepdims=True), row.shape)


@dataclass(frozen=True)
class Curvilinear:
    """A horizontal grid with longitudes and latitudes of its own for every point.

    Parameters
    ----------
    lon, lat : ndarray
        Degrees, (ny, nx); NaN where the file has none, as in blocks of land left out.
    """

    lon: Array
    lat: Array

    def lonlat(self) -> tuple[Array, Array]:
        """Longitude and latitude of all points (degrees), each (ny, nx)."""
        return self.lon, self.lat


AnySource = Source | Curvilinear


def shape_of(source: AnySource) -> tuple[int, int]:
    """Rows and columns of a source, unpadded.

    Parameters
    ----------
    source : AnySource
        Grid or points of a file.

    Returns
    -------
    tuple of int
        (ny, nx).
    """
    if isinstance(source, Curvilinear):
        return source.lon.shape[0], source.lon.shape[1]
    return source.y.size, source.x.size


def open_file(path: str | Path, hints: Hints | None = None) -> xr.Dataset:
    """Open a file lazily, values and times as stored, coordinates in order.

    Parameters
    ----------
    path : str or Path
        File.
    hints : Hints, optional
        What the scene says of the file.

    Returns
    -------
    xarray.Dataset
        To be closed by the caller.

    Raises
    ------
    FloeError
        Where it cannot be read.
    """
    return open_input(path, hints)


def surface_level(
    data: xr.Dataset,
    name: str,
    layout: cf.Layout,
    ocean: bool,
    path: str | Path,
    wanted: float = 0.0,
) -> levels.Level | None:
    """The level of a variable that is read, None where it has no levels; see `levels.surface`.

    Parameters
    ----------
    data : xarray.Dataset
        Of the file, not decoded.
    name : str
        Of the variable.
    layout : cf.Layout
        Its dimensions.
    ocean : bool
        Whether levels are depths in the sea, else heights.
    path : str or Path
        Of the file, for messages.
    wanted : float, optional
        Depth or height (m).

    Returns
    -------
    levels.Level or None
        Its index and place.

    Raises
    ------
    FloeError
        For levels that cannot be told, or none near enough.
    """
    axis = layout.level or layout.height
    if not axis:
        return None
    item = data[axis]
    what = f"{path}: variable '{name}'"
    values = np.asarray(item.values, dtype=float)
    return levels.surface(axis, item.attrs, values, ocean, what, wanted)


def read_values(
    data: xr.Dataset,
    name: str,
    layout: cf.Layout,
    source: AnySource,
    times: Index,
    path: str | Path,
    level: int | None = None,
) -> Array:
    """Values of a variable at some of its times, axes ascending, NaN where missing.

    Of several levels ``level`` is taken; without it the one nearest the sea's surface, see
    `levels.surface`.

    Parameters
    ----------
    data : xarray.Dataset
        Of the file, not decoded.
    name : str
        Of the variable.
    layout : cf.Layout
        Its dimensions.
    source : AnySource
        Its grid.
    times : Index
        Rows of the time axis.
    path : str or Path
        Of the file, for messages.
    level : int, optional
        Index of the level.

    Returns
    -------
    ndarray
        (times, ny, nx); a variable without time counts as one of a single time.

    Raises
    ------
    FloeError
        Where the file turns out damaged, or the values are no numbers.
    """
    return read_unpacked(data, name, layout, source, times, path, level).values


def read_unpacked(
    data: xr.Dataset,
    name: str,
    layout: cf.Layout,
    source: AnySource,
    times: Index,
    path: str | Path,
    level: int | None = None,
) -> Values:
    """As `read_values`, with the flags that tell why values are missing.

    Parameters
    ----------
    data : xarray.Dataset
        Of the file, not decoded.
    name : str
        Of the variable.
    layout : cf.Layout
        Its dimensions.
    source : AnySource
        Its grid.
    times : Index
        Rows of the time axis.
    path : str or Path
        Of the file, for messages.
    level : int, optional
        Index of the level; None without levels.

    Returns
    -------
    Values
        (times, ny, nx), missing values NaN.

    Raises
    ------
    FloeError
        For values that cannot be unpacked.
    """
    raw = _stored(data, name, layout, times, path, level)
    try:
        found = unpack(raw, data[name].attrs)
    except FloeError as error:
        raise FloeError(f"{path}: variable '{name}': {error}") from None
    flags = {kind: _ordered(hit, source).astype(bool) for kind, hit in found.flags.items()}
    return Values(_ordered(found.values, source), flags, found.rounding)


def read_flags(
    data: xr.Dataset,
    name: str,
    layout: cf.Layout,
    source: AnySource,
    times: Index,
    path: str | Path,
) -> dict[str, Flags]:
    """Where a status flag tells of land, (times, ny, nx); see `unpack.status_flags`.

    Parameters
    ----------
    data : xarray.Dataset
        Of the file, not decoded.
    name : str
        Of the variable.
    layout : cf.Layout
        Its dimensions.
    source : AnySource
        Its grid.
    times : Index
        Rows of the time axis.
    path : str or Path
        Of the file, for messages.

    Returns
    -------
    dict of Flags
        By kind of flag; empty where there is no status flag.
    """
    found = status_flags(_stored(data, name, layout, times, path), data[name].attrs)
    return {kind: _ordered(hit, source).astype(bool) for kind, hit in found.items()}


def _stored(
    data: xr.Dataset,
    name: str,
    layout: cf.Layout,
    times: Index,
    path: str | Path,
    level: int | None = None,
) -> NDArray[Any]:
    """Numbers as stored, (times, ny, nx), in the file's own order."""
    field = data[name]
    if layout.level:
        if level is None:
            found = surface_level(data, name, layout, True, path)
            level = 0 if found is None else found.index
        field = field.isel({layout.level: level})
    field = field.isel({layout.time: times}) if layout.time else field.expand_dims("one time")
    keep = (layout.time or "one time", layout.y, layout.x)
    field = field.isel({dim: 0 for dim in field.dims if dim not in keep})
    # What was cut to one place has no horizontal dimensions left.
    field = field.expand_dims([dim for dim in keep if dim not in field.dims])
    try:
        raw = np.asarray(field.transpose(*keep).values)
    except Exception as error:  # a damaged HDF5 file raises whatever its bytes lead to
        raise FloeError(
            f"{path}: variable '{name}' cannot be read ({type(error).__name__})"
        ) from None
    if raw.dtype.kind not in "iufb":
        raise FloeError(f"{path}: variable '{name}' holds no numbers")
    return raw


def _ordered(values: Array | Flags, source: AnySource) -> NDArray[Any]:
    if isinstance(source, Curvilinear):
        return values
    return np.asarray(values[:, source.order_y][:, :, source.order_x])


def source_grid(
    variables: dict[str, cf.Variable],
    variable: cf.Variable,
    layout: cf.Layout,
    data: xr.Dataset,
    path: str | Path,
) -> AnySource:
    """Horizontal grid of a variable.

    Parameters
    ----------
    variables : dict of cf.Variable
        Of the file, by name.
    variable : cf.Variable
        One of them.
    layout : cf.Layout
        Its dimensions.
    data : xarray.Dataset
        Of the file, not decoded.
    path : str or Path
        Of the file, for messages.

    Returns
    -------
    Source or Curvilinear
        Axes ascending, in m or degrees; which of them were turned over is noted.

    Raises
    ------
    FloeError
        Where coordinates are missing, repeated or not finite, or where the grid mapping does not
        fit the latitudes and longitudes that the file gives beside it.
    """
    if layout.places:
        return _curvilinear(layout, data, path)
    crs = None if layout.lonlat else cf.projection(variables, variable, path)
    scale = layout.scale or (metres_per_unit(crs) if crs else 1.0)
    x = unpack(np.asarray(data[layout.x].values), data[layout.x].attrs).values * scale
    y = unpack(np.asarray(data[layout.y].values), data[layout.y].attrs).values * scale
    if layout.lonlat:
        x = np.mod(x, 360.0)
        if np.any(np.abs(y) > 90.0 + 1e-6):
            raise FloeError(f"{path}: latitudes '{layout.y}' reach beyond 90 degrees")
        y = np.clip(y, -90.0, 90.0)
    x_axis, order_x = _ascending(x, layout.x, path, drop_repeated=layout.lonlat)
    y_axis, order_y = _ascending(y, layout.y, path, drop_repeated=False)
    if crs is not None:
        source = Source(x_axis, y_axis, crs, order_x, order_y, False, (False, False))
        _check_mapping(source, layout, data, path)
        return source
    # Start behind the widest gap, so that a regional grid across Greenwich stays in one piece.
    gaps = np.diff(np.append(x_axis, x_axis[0] + 360.0))
    periodic = bool(gaps.max() <= 1.5 * np.median(gaps))
    start = 0 if periodic else (int(np.argmax(gaps)) + 1) % x_axis.size
    x_axis = np.concatenate([x_axis[start:], x_axis[:start] + 360.0])
    order_x = np.roll(order_x, -start)
    reach = 1.01 * float(np.median(np.diff(y_axis)))
    south = periodic and -90.0 < y_axis[0] <= -90.0 + reach
    north = periodic and 90.0 - reach <= y_axis[-1] < 90.0
    return Source(x_axis, y_axis, None, order_x, order_y, periodic, (bool(south), bool(north)))


def _curvilinear(layout: cf.Layout, data: xr.Dataset, path: str | Path) -> Curvilinear:
    assert layout.places is not None
    degrees = []
    for name in layout.places:
        item = data[name].transpose(layout.y, layout.x)
        values = unpack(np.asarray(item.values), item.attrs).values
        if str(item.attrs.get("units", "")).lower().startswith("rad"):
            values = np.degrees(values)
        degrees.append(values)
    lon, lat = degrees
    if np.nanmax(np.abs(lat), initial=0.0) > 90.0 + 1e-6:
        raise FloeError(f"{path}: latitudes '{layout.places[1]}' reach beyond 90 degrees")
    none = ~np.isfinite(lon) | ~np.isfinite(lat)
    # Blocks that were never written stand at 0, 0 by the hundred.
    origin = (lon == 0.0) & (lat == 0.0)
    none |= origin if origin.sum() > 1 else False
    if none.all():
        raise FloeError(f"{path}: coordinate '{layout.places[1]}' has no value")
    lon, lat = np.where(none, np.nan, lon), np.where(none, np.nan, lat)
    return Curvilinear(lon, np.clip(lat, -90.0, 90.0))


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
        if set(field.dims) != {layout.x, layout.y} or field.attrs.get("standard_name") not in (
            "latitude",
            "longitude",
        ):
            continue
        own = unpack(np.asarray(field.transpose(layout.y, layout.x).values), field.attrs).values
        given = own[np.ix_(source.order_y, source.order_x)]
        lon, lat = source.lonlat()
        computed = lat if field.attrs["standard_name"] == "latitude" else lon
        off = np.mod(given - computed + 180.0, 360.0) - 180.0
        if field.attrs["standard_name"] == "longitude":
            off = off * np.cos(np.radians(lat))
        distance = np.nanmax(np.abs(np.radians(off))) * EARTH_RADIUS
        # Half a cell is a common fault of such files, and harmless.
        if distance > np.diff(source.x).max():
            raise FloeError(
                f"{path}: the grid mapping lies up to {distance / 1e3:.0f} km off the file's own "
                f"'{name}'"
            )
