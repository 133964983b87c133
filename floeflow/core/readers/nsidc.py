# SPDX-License-Identifier: GPL-2.0-or-later
"""NSIDC's flat binary sea-ice concentration (NSIDC-0051, 0081): 300-byte header, then bytes.

Polar stereographic on the Hughes ellipsoid, 25 km; concentration in steps of 0.4 per cent up to
250, then flags: 251 pole hole, 252 unused, 253 coast, 254 land, 255 missing. The header's fields
are text of six bytes: at 6 the columns, at 12 the rows, at 102 the year, at 108 its day (user's
guide of NSIDC-0051).
"""

from __future__ import annotations

from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pyproj
import xarray as xr

from floeflow.core.errors import FloeError

HEADER = 300
# Rows, columns: EPSG code, left and upper edge (m).
GRIDS = {
    (448, 304): (3411, -3.85e6, 5.85e6),
    (332, 316): (3412, -3.95e6, 4.35e6),
}
CELL = 2.5e4


def opens(path: Path) -> bool:
    """A ``.bin`` file of the size of one of the two grids, with or without header.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    bool
        True if this reader takes the file.
    """
    if not path.is_file() or path.suffix.lower() != ".bin":
        return False
    return _shape(path) is not None


def _shape(path: Path) -> tuple[int, int] | None:
    size = path.stat().st_size
    return next((s for s in GRIDS if size in (s[0] * s[1], s[0] * s[1] + HEADER)), None)


def open_raw(path: Path) -> xr.Dataset:
    """Open whole: variable ``ice`` with flags, its day from the header or the file's name.

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
        Where the header tells of another grid.
    """
    shape = _shape(path)
    assert shape is not None
    raw = path.read_bytes()
    header, body = raw[: -shape[0] * shape[1]], raw[-shape[0] * shape[1] :]
    if header:
        _check_header(header, shape, path)
    code, left, top = GRIDS[shape]
    rows, columns = shape
    attrs = {
        "standard_name": "sea_ice_area_fraction",
        "units": "1",
        "scale_factor": 0.004,
        "valid_range": np.array([0, 250], np.uint8),
        "flag_values": np.array([251, 252, 253, 254, 255], np.uint8),
        "flag_meanings": "pole_hole unused coast land missing",
        "grid_mapping": "crs",
    }
    values = np.frombuffer(body, np.uint8).reshape(shape)
    data = xr.Dataset(
        {
            "ice": (("y", "x"), values, attrs),
            "crs": ((), 0, {"crs_wkt": pyproj.CRS.from_epsg(code).to_wkt()}),
        },
        coords={
            "x": ("x", left + CELL * (np.arange(columns) + 0.5)),
            "y": ("y", top - CELL * (np.arange(rows) + 0.5)),
        },
    ).drop_indexes(["x", "y"])
    for axis in "xy":
        data[axis].attrs = {"standard_name": f"projection_{axis}_coordinate", "units": "m"}
    day = _day(header, path)
    if day is not None:
        noon = {"units": f"hours since {day:%Y-%m-%d} 00:00:00", "standard_name": "time"}
        data = data.assign_coords(time=((), 12.0, noon))
    return data


def _check_header(header: bytes, shape: tuple[int, int], path: Path) -> None:
    try:
        said = int(header[12:18].strip(b"\0 ")), int(header[6:12].strip(b"\0 "))
    except ValueError:
        raise FloeError(f"{path}: its 300-byte header has no numbers of rows and columns") from None
    if said != shape:
        raise FloeError(
            f"{path}: its header tells of {said[0]} rows and {said[1]} columns, its size of "
            f"{shape[0]} and {shape[1]}"
        )


def _day(header: bytes, path: Path) -> datetime | None:
    """Day of the file: by its name (nt_YYYYMMDD_...), as the header's year may be of two digits."""
    for part in path.stem.split("_"):
        if len(part) == 8 and part.isdigit():
            try:
                return datetime.strptime(part, "%Y%m%d")
            except ValueError:
                continue
    try:
        day, year = int(header[108:114].strip(b"\0 ")), int(header[102:108].strip(b"\0 "))
    except ValueError:
        return None
    if not 1 <= day <= 366:
        return None
    year += 0 if year >= 1000 else 1900 if year >= 70 else 2000
    return datetime(year, 1, 1) + timedelta(days=day - 1)
