# SPDX-License-Identifier: GPL-2.0-or-later
"""GeoTIFF through rasterio (optional), its bands as variables on x and y."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from floeflow.core.errors import FloeError


def opens(path: Path) -> bool:
    """A file with the suffix of TIFF.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    bool
        True if this reader takes the file.
    """
    return path.is_file() and path.suffix.lower() in (".tif", ".tiff", ".geotiff")


def open_raw(path: Path) -> xr.Dataset:
    """Open whole: variables ``band_1``, ``band_2``, ... with nodata and scale as CF attributes.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    xarray.Dataset
        Numbers as stored, with CF attributes that say what they mean.

    Raises
    ------
    FloeError
        Where rasterio is not installed, the file is damaged, or its rows are not along y.
    """
    try:
        import rasterio
    except ImportError:
        raise FloeError(
            f"{path}: is a GeoTIFF, which needs the package rasterio: "
            ".venv/bin/pip install 'floeflow[formats]'"
        ) from None
    try:
        with rasterio.open(path) as file:
            bands = {f"band_{k}": file.read(k) for k in file.indexes}
            turn, crs = file.transform, file.crs
            notes = list(zip(file.nodatavals, file.scales, file.offsets, strict=True))
            units, tags = file.units, file.tags()
    except Exception as error:  # a damaged file raises whatever its bytes lead to
        raise FloeError(f"{path}: cannot be read as GeoTIFF ({type(error).__name__})") from None
    if turn.is_identity:
        raise FloeError(f"{path}: has no georeference, so its pixels have no place")
    if turn.b != 0 or turn.d != 0:
        raise FloeError(f"{path}: its rows do not run along x: rotate it to its projection's axes")
    data = raster(bands, (turn.a, turn.c, turn.e, turn.f), crs.to_wkt() if crs else "")
    for name, (missing, scale, offset), unit in zip(bands, notes, units, strict=True):
        attrs: dict[str, Any] = {} if missing is None else {"_FillValue": missing}
        if (scale, offset) != (1.0, 0.0):
            attrs |= {"scale_factor": scale, "add_offset": offset}
        data[name].attrs |= attrs | ({"units": unit} if unit else {})
    data.attrs = {str(key): value for key, value in tags.items()}
    return data


def raster(
    bands: dict[str, np.ndarray], place: tuple[float, float, float, float], wkt: str
) -> xr.Dataset:
    """Dataset of bands (ny, nx) on pixel centres.

    Parameters
    ----------
    bands : dict of ndarray
        By name.
    place : tuple of float
        Width of a pixel and left edge, height (negative where rows run down) and upper edge.
    wkt : str
        Coordinate system; empty where it is not told.

    Returns
    -------
    xarray.Dataset
        Bands over y and x, in the raster's order of rows, and its projection in ``crs``.
    """
    dx, left, dy, top = place
    rows, columns = next(iter(bands.values())).shape
    x, y = left + dx * (np.arange(columns) + 0.5), top + dy * (np.arange(rows) + 0.5)
    degrees = wkt.startswith(("GEOGCS", "GEOGCRS", "GEODCRS"))
    kinds = ("longitude", "latitude") if degrees else tuple(
        f"projection_{axis}_coordinate" for axis in "xy"
    )  # fmt: skip
    units = ("degrees_east", "degrees_north") if degrees else ("", "")
    coords = {
        name: (name, values, {"standard_name": kind} | ({"units": unit} if unit else {}))
        for name, values, kind, unit in zip("xy", (x, y), kinds, units, strict=True)
    }
    data = xr.Dataset({name: (("y", "x"), band) for name, band in bands.items()})
    data = data.assign_coords(coords).drop_indexes(["x", "y"])
    if wkt and not degrees:
        data["crs"] = ((), 0, {"crs_wkt": wkt})
        for name in bands:
            data[name].attrs["grid_mapping"] = "crs"
    return data
