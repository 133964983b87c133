# SPDX-License-Identifier: GPL-2.0-or-later
"""Polygons of a shapefile: its .shp, in the projection that the .prj beside it names.

The layout is that of ESRI's technical description (July 1998). Attributes (.dbf) are not read.
"""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pyproj
import shapely
from numpy.typing import NDArray

from floeflow.core.errors import FloeError

Array = NDArray[np.float64]

HEADER, CODE = 100, 9994
NOTHING, POLYGONS = 0, (5, 15, 25)
# Sides of polygons on a map are straight there: they are divided before they leave it, m.
LONGEST_SIDE = 1.0e4


def read_shapefile(path: Path) -> list[shapely.Geometry]:
    """Polygons in longitude and latitude, one a record.

    Parameters
    ----------
    path : Path
        The .shp file.

    Returns
    -------
    list of shapely.Geometry
        Degrees, in the order of the records; null shapes are left out.

    Raises
    ------
    FloeError
        One sentence: no projection, no shapefile, no polygons.
    """
    crs = _projection(path)
    data = path.read_bytes()
    if len(data) < HEADER or struct.unpack(">i", data[:4])[0] != CODE:
        raise FloeError(f"{path}: this is no shapefile")
    found: list[shapely.Geometry] = []
    at = HEADER
    while at < len(data):
        name = f"{path}: record {len(found) + 1}"
        try:
            number, words = struct.unpack_from(">2i", data, at)
            kind = struct.unpack_from("<i", data, at + 8)[0]
        except struct.error:
            raise FloeError(f"{name} is cut off") from None
        if words < 2 or at + 8 + 2 * words > len(data):
            raise FloeError(f"{name} is cut off")
        if kind in POLYGONS:
            rings = _rings(data[at + 8 : at + 8 + 2 * words], name)
            found.append(_to_lonlat(_polygon(rings, name), crs, name))
        elif kind != NOTHING:
            raise FloeError(f"{name} (number {number}) is of type {kind}, not a polygon")
        at += 8 + 2 * words
    return found


def _projection(path: Path) -> pyproj.CRS:
    beside = path.with_suffix(".prj")
    if not beside.is_file():
        raise FloeError(f"{path}: needs {beside.name} beside it, which names its projection")
    try:
        return pyproj.CRS.from_wkt(beside.read_text("utf-8"))
    except (OSError, pyproj.exceptions.CRSError, UnicodeDecodeError):
        raise FloeError(f"{beside}: names no projection that is known") from None


def _rings(record: bytes, name: str) -> list[Array]:
    """Corners of each ring of a polygon, closed."""
    try:
        parts, points = struct.unpack_from("<2i", record, 36)
        start = np.frombuffer(record, "<i4", parts, 44)
        corner = np.frombuffer(record, "<f8", 2 * points, 44 + 4 * parts).reshape(-1, 2)
    except (struct.error, ValueError):
        raise FloeError(f"{name} is cut off") from None
    ends = np.append(start, points)
    if parts < 1 or ends[0] != 0 or (np.diff(ends) < 4).any():
        raise FloeError(f"{name} has rings of less than four corners")
    return [
        corner[first:last].astype(float) for first, last in zip(ends[:-1], ends[1:], strict=True)
    ]


def _polygon(rings: list[Array], name: str) -> shapely.MultiPolygon:
    """Rings on the file's own map: clockwise around what is inside, anticlockwise around holes."""
    clockwise = [not shapely.is_ccw(shapely.linearrings(ring)) for ring in rings]
    shells = [ring for ring, outer in zip(rings, clockwise, strict=True) if outer]
    if not shells:
        raise FloeError(f"{name} has no ring that runs clockwise, as outer ones do")
    whole = np.array([shapely.Polygon(ring) for ring in shells], dtype=object)
    of: list[list[Array]] = [[] for _ in shells]
    for ring in (ring for ring, outer in zip(rings, clockwise, strict=True) if not outer):
        around = np.flatnonzero(shapely.contains(whole, shapely.polygons(ring)))
        if not len(around):
            raise FloeError(f"{name} has a hole outside of its rings")
        # The innermost: islands may lie in lakes.
        of[int(around[np.argmin(shapely.area(whole[around]))])].append(ring)
    return shapely.MultiPolygon(list(zip(shells, of, strict=True)))


def _to_lonlat(polygon: shapely.MultiPolygon, crs: pyproj.CRS, name: str) -> shapely.MultiPolygon:
    """Straight sides on a map are divided first, as they are bent in longitude and latitude."""
    if not crs.is_geographic:
        assert crs.geodetic_crs is not None
        transformer = pyproj.Transformer.from_crs(crs, crs.geodetic_crs, always_xy=True)

        def moved(corners: Array) -> Array:
            return np.column_stack(transformer.transform(*corners.T))

        polygon = shapely.transform(shapely.segmentize(polygon, LONGEST_SIDE), moved)
    x, y = shapely.get_coordinates(polygon).T
    if not (np.abs(x) <= 360.0).all() or not (np.abs(y) <= 90.0).all():
        raise FloeError(f"{name} has corners that are no places in the projection of its .prj")
    return polygon
