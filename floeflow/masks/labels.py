# SPDX-License-Identifier: GPL-2.0-or-later
"""Labelled images of floes: each pixel holds the number of its floe, 0 where there is none.

GeoTIFF, PNG and what else GDAL reads, or a variable of a NetCDF file. Only the part over the scene
is read. An image in another projection than the scene's is brought to it by the nearest pixel.
"""

from __future__ import annotations

import logging
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import pyproj
from numpy.typing import NDArray

from floeflow.core import cf_reading as cf
from floeflow.core.errors import FloeError
from floeflow.core.grids import Grid, scene_crs
from floeflow.scene.blocks import Domain, Labels

Numbers = NDArray[np.int32]

log = logging.getLogger(__name__)

# Pixels over a scene; their numbers take 4 bytes each.
MOST_PIXELS = 100_000_000
# A pixel's sides may differ by this share, and its rows by this many pixels from even ones.
SQUARE = 1.0e-3
NETCDF_ENDINGS = {".nc", ".nc4", ".cdf", ".netcdf"}


@dataclass(frozen=True)
class Floes:
    """Numbers of floes on square pixels in the scene's projection.

    Parameters
    ----------
    numbers : ndarray
        Number of the floe, 0 for none, rows from south to north, (ny, nx).
    grid : Grid
        The pixels.
    """

    numbers: Numbers
    grid: Grid


def read_labels(keys: Labels, domain: Domain) -> Floes:
    """Read the part of a labelled image that lies over a scene.

    Parameters
    ----------
    keys : Labels
        File, and what it may not say itself: variable, projection, pixel.
    domain : Domain
        The scene's rectangle.

    Returns
    -------
    Floes
        Pixels that touch the rectangle; nothing is resampled where the projections agree.

    Raises
    ------
    FloeError
        One sentence that names the file, or the key that says what the file does not.
    """
    path = Path(keys.file)
    if not path.is_file():
        raise FloeError(f"{path}: there is no such file (mask.labels.file)")
    if path.suffix.lower() in NETCDF_ENDINGS:
        return _read_netcdf(path, keys, domain)
    return _read_image(path, keys, domain)


def _read_image(path: Path, keys: Labels, domain: Domain) -> Floes:
    try:
        import rasterio
        from rasterio.errors import NotGeoreferencedWarning, RasterioError
    except ImportError:
        raise FloeError(
            f"{path}: is an image, which needs the package rasterio: "
            ".venv/bin/pip install 'floeflow[formats]'"
        ) from None

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", NotGeoreferencedWarning)
            with rasterio.open(path) as image:
                return _of_image(image, path, keys, domain)
    except RasterioError as error:
        reason = str(error).splitlines()[0]
        raise FloeError(f"{path}: cannot be read as an image: {reason}") from None


def _of_image(image: Any, path: Path, keys: Labels, domain: Domain) -> Floes:
    from rasterio.enums import Resampling
    from rasterio.vrt import WarpedVRT

    if image.count != 1:
        raise FloeError(
            f"{path}: has {image.count} bands; a labelled image has one, the number of each "
            "pixel's floe"
        )
    if image.dtypes[0].startswith("complex"):
        raise FloeError(f"{path}: holds complex numbers, no labels")
    transform, crs = _place(image, path, keys, domain)
    target = scene_crs(domain)
    if _alike(crs, target):
        return _window(image, path, transform, domain)
    log.warning(
        "%s is in the projection '%s': brought to the scene's by the nearest pixel", path, crs.name
    )
    with WarpedVRT(
        image,
        src_crs=crs.to_wkt(),
        src_transform=transform,
        crs=target.to_wkt(),
        resampling=Resampling.nearest,
    ) as warped:
        return _window(warped, path, warped.transform, domain)


def _place(image: Any, path: Path, keys: Labels, domain: Domain) -> tuple[Any, pyproj.CRS]:
    """Transform and projection of an image, from itself or from the keys."""
    from rasterio.transform import from_origin

    transform = image.transform
    if transform.is_identity:
        if not keys.pixel:
            raise FloeError(
                f"{path}: does not say where on the earth it lies; mask.labels.pixel, the side of "
                "a pixel in metres, places its upper left corner at that of the scene"
            )
        return from_origin(domain.x_min, domain.y_max, keys.pixel, keys.pixel), scene_crs(domain)
    if keys.crs:
        crs = scene_crs(domain.model_copy(update={"crs": keys.crs}))
    elif image.crs is None:
        raise FloeError(
            f"{path}: does not say its projection; name it in mask.labels.crs, such as EPSG:3413"
        )
    else:
        crs = pyproj.CRS.from_user_input(image.crs.to_wkt())
    if abs(transform.b) + abs(transform.d) > SQUARE * abs(transform.a):
        raise FloeError(f"{path}: is turned against its projection, which is not read")
    return transform, crs


def _alike(one: pyproj.CRS, two: pyproj.CRS) -> bool:
    """Whether projections are the same, however they are written."""
    if one.equals(two, ignore_axis_order=True):
        return True
    code = one.to_epsg()
    return code is not None and code == two.to_epsg()


def _window(image: Any, path: Path, transform: Any, domain: Domain) -> Floes:
    """Pixels that touch the scene, south first."""
    from rasterio.windows import Window

    columns, west, size = _span(
        (transform.c, transform.a, image.width), domain.x_min, domain.x_max, path
    )
    rows, south, tall = _span(
        (transform.f, transform.e, image.height), domain.y_min, domain.y_max, path
    )
    _check_square(path, size, tall)
    count = (rows[1] - rows[0]) * (columns[1] - columns[0])
    _check_count(path, count)
    window = Window(columns[0], rows[0], columns[1] - columns[0], rows[1] - rows[0])
    values = image.read(1, window=window, masked=True)
    values = values[:, :: 1 if transform.a > 0 else -1]
    values = values[:: 1 if transform.e > 0 else -1]
    return _floes(np.ma.filled(values.astype(np.float64), 0.0), west, south, size, path)


def _span(
    axis: tuple[float, float, int], low: float, high: float, path: Path
) -> tuple[tuple[int, int], float, float]:
    """Pixels of an axis (start, step, number) that touch an interval; its lower end; their side."""
    start, step, number = axis
    ends = sorted(((low - start) / step, (high - start) / step))
    first, last = max(int(np.floor(ends[0])), 0), min(int(np.ceil(ends[1])), number)
    if last <= first:
        raise FloeError(f"{path}: lies wholly outside of the scene (domain)")
    return (first, last), start + step * (first if step > 0 else last), abs(step)


def _check_square(path: Path, size: float, tall: float) -> None:
    if abs(size - tall) > SQUARE * size:
        raise FloeError(f"{path}: pixels are {size:g} m by {tall:g} m; floes need square ones")


def _check_count(path: Path, count: int) -> None:
    if count > MOST_PIXELS:
        raise FloeError(
            f"{path}: {count:.3g} pixels lie over the scene, at most {MOST_PIXELS:g} are read: "
            "choose a smaller domain or a coarser image"
        )


def _floes(
    values: NDArray[np.float64], west: float, south: float, size: float, path: Path
) -> Floes:
    values = np.where(np.isfinite(values), values, 0.0)
    if (values != np.floor(values)).any():
        raise FloeError(f"{path}: holds numbers that are not whole; labels are")
    if values.min(initial=0) < 0 or values.max(initial=0) > np.iinfo(np.int32).max:
        raise FloeError(f"{path}: labels reach from {values.min():g} to {values.max():g}; they are "
                        "whole numbers from 1, and 0 for no floe")  # fmt: skip
    ny, nx = values.shape
    x = np.asarray(west + size * (np.arange(nx) + 0.5), float)
    y = np.asarray(south + size * (np.arange(ny) + 0.5), float)
    return Floes(values.astype(np.int32), Grid(x, y, size, west, south))


def _read_netcdf(path: Path, keys: Labels, domain: Domain) -> Floes:
    variables = cf.describe(path)
    maps = {name: item for name, item in variables.items() if len(item.dims) >= 2}
    if not keys.variable and len(maps) != 1:
        raise FloeError(
            f"{path}: name the variable with the labels in mask.labels.variable, one of "
            f"{', '.join(maps) or 'none'}"
        )
    name = keys.variable or next(iter(maps))
    variable = cf.named(variables, name, path, "mask.labels.variable")
    layout = cf.layout(variables, variable, path)
    if layout.lonlat:
        raise FloeError(
            f"{path}: '{name}' is on longitudes and latitudes; floes need square pixels in metres: "
            "bring the labels to a projection first (gdalwarp -r near)"
        )
    if keys.crs:
        crs = scene_crs(domain.model_copy(update={"crs": keys.crs}))
    else:
        crs = cf.projection(variables, variable, path)
    if not _alike(crs, scene_crs(domain)):
        raise FloeError(
            f"{path}: '{name}' is in another projection than the scene; set domain.crs to its own"
        )
    with netCDF4.Dataset(path) as file:
        axes = [layout.scale * np.asarray(file[dim][:], float) for dim in (layout.x, layout.y)]
        steps = [
            _even(axis, dim, path) for axis, dim in zip(axes, (layout.x, layout.y), strict=True)
        ]
        columns, west, size = _span(
            (axes[0][0] - 0.5 * steps[0], steps[0], axes[0].size), domain.x_min, domain.x_max, path
        )
        rows, south, tall = _span(
            (axes[1][0] - 0.5 * steps[1], steps[1], axes[1].size), domain.y_min, domain.y_max, path
        )
        _check_square(path, size, tall)
        _check_count(path, (rows[1] - rows[0]) * (columns[1] - columns[0]))
        cut = {layout.x: slice(*columns), layout.y: slice(*rows)}
        order = tuple(cut.get(dim, 0) for dim in variable.dims)
        values = np.ma.filled(np.ma.asarray(file[name][order]).astype(float), 0.0)
    dims = [dim for dim in variable.dims if dim in cut]
    values = values if dims == [layout.y, layout.x] else values.T
    values = values[:: 1 if steps[1] > 0 else -1, :: 1 if steps[0] > 0 else -1]
    return _floes(values, west, south, size, path)


def _even(axis: NDArray[np.float64], name: str, path: Path) -> float:
    gaps = np.diff(axis)
    step = float(gaps.mean()) if gaps.size else np.nan
    if not np.isfinite(step) or step == 0 or np.abs(gaps - step).max() > SQUARE * abs(step):
        raise FloeError(f"{path}: '{name}' is not an axis of even steps")
    return step
