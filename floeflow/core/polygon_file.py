# SPDX-License-Identifier: GPL-2.0-or-later
"""Polygons of a file in a projection: GeoJSON (RFC 7946: longitudes, latitudes) or a shapefile."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pyproj
import shapely
from numpy.typing import NDArray
from shapely.geometry import shape

from floeflow.core.errors import FloeError
from floeflow.core.polygon_names import SHAPEFILE
from floeflow.core.shapefile import read_shapefile

Array = NDArray[np.float64]

# Sides longer than this (degrees) are divided, as they are bent on the map.
LONGEST_SIDE = 0.25
# Rings that cross themselves count as the area around which they go once, where that is not
# further from their own than this share: shorelines have small loops.
CROSSED = 0.01
MAX_BYTES = 50_000_000


def read_polygons(path: str | Path, crs: str) -> list[tuple[shapely.Geometry, dict[str, Any]]]:
    """Polygons and their properties.

    Parameters
    ----------
    path : str or Path
        GeoJSON file of a Polygon or MultiPolygon, a Feature or a FeatureCollection; or a shapefile
        (.shp) of polygons, which come without properties.
    crs : str
        Projection to bring them to (pyproj name).

    Returns
    -------
    list of (shapely.Geometry, dict)
        Valid polygons in projected metres, with the properties of their features.

    Raises
    ------
    FloeError
        One sentence: no file, no GeoJSON or shapefile, no polygon, places that are none.
    """
    path = Path(path)
    try:
        if path.exists() and not path.is_file():
            raise FloeError(f"{path}: is no file of polygons, but a folder, a pipe or a device")
        if path.stat().st_size > MAX_BYTES:
            raise FloeError(f"{path}: polygons of over {MAX_BYTES} bytes are not read")
        shapes = path.suffix.lower() == SHAPEFILE
        found = [(each, {}) for each in read_shapefile(path)] if shapes else _of_json(path)
    except OSError as error:
        raise FloeError(f"{path}: cannot be read: {error.strerror}") from None
    if not found:
        raise FloeError(f"{path}: holds no polygon")
    return [
        (project(polygon, crs, f"{path}: feature {number}"), properties)
        for number, (polygon, properties) in enumerate(found, start=1)
    ]


def _of_json(path: Path) -> list[tuple[shapely.Geometry, dict[str, Any]]]:
    """Polygons in longitude and latitude, and their properties."""
    try:
        data = json.loads(path.read_text("utf-8"))
    except (ValueError, RecursionError):
        raise FloeError(f"{path}: this is not GeoJSON") from None
    return [
        (_polygon(feature, f"{path}: feature {number}"), feature.get("properties") or {})
        for number, feature in enumerate(_features(data, path), start=1)
    ]


def _features(data: Any, path: Path) -> list[dict[str, Any]]:
    kind = data.get("type") if isinstance(data, dict) else None
    if kind == "FeatureCollection":
        features = data.get("features")
        if isinstance(features, list) and all(isinstance(each, dict) for each in features):
            return features
    elif kind == "Feature":
        return [data]
    elif kind in ("Polygon", "MultiPolygon"):
        return [{"geometry": data}]
    raise FloeError(f"{path}: this is not GeoJSON of polygons")


def _polygon(feature: dict[str, Any], name: str) -> shapely.Geometry:
    geometry = feature.get("geometry")
    kind = geometry.get("type") if isinstance(geometry, dict) else None
    if not isinstance(geometry, dict) or kind not in ("Polygon", "MultiPolygon"):
        raise FloeError(f"{name} is a {kind or 'nothing'}, not a Polygon or MultiPolygon")
    try:
        found = shape(geometry)
    except (ValueError, TypeError, LookupError, AttributeError, shapely.errors.ShapelyError):
        raise FloeError(f"{name} has no valid coordinates") from None
    xy = shapely.get_coordinates(found)
    if not len(xy) or not np.isfinite(xy).all() or np.abs(xy[:, 1]).max() > 90:
        raise FloeError(f"{name}: coordinates are longitudes and latitudes in degrees")
    if np.abs(xy[:, 0]).max() > 360:
        raise FloeError(f"{name}: coordinates are longitudes and latitudes in degrees")
    return found


def project(polygon: shapely.Geometry, crs: str, name: str) -> shapely.Geometry:
    """Bring a polygon of longitudes and latitudes to a projection.

    Sides are divided first, along straight lines in longitude and latitude.

    Parameters
    ----------
    polygon : shapely.Geometry
        Degrees.
    crs : str
        Projection.
    name : str
        Of the polygon, for messages.

    Returns
    -------
    shapely.Geometry
        Valid, in metres of the projection.

    Raises
    ------
    FloeError
        Where it lies outside of the projection, or its ring crosses itself.
    """
    target = pyproj.CRS.from_user_input(crs)
    assert target.geodetic_crs is not None
    transformer = pyproj.Transformer.from_crs(target.geodetic_crs, target, always_xy=True)

    def moved(ring: shapely.LinearRing) -> Array:
        xy = shapely.get_coordinates(ring)
        # A side goes the short way round, also over the antimeridian; a ring may go round the pole.
        xy[:, 0] = np.unwrap(xy[:, 0], period=360.0)
        xy = shapely.get_coordinates(shapely.segmentize(shapely.LineString(xy), LONGEST_SIDE))
        return np.stack(transformer.transform(np.mod(xy[:, 0], 360.0), xy[:, 1]), axis=1)

    parts = []
    for part in shapely.get_parts(polygon):
        shell, holes = moved(part.exterior), [moved(ring) for ring in part.interiors]
        if not all(np.isfinite(ring).all() for ring in (shell, *holes)):
            raise FloeError(f"{name} lies outside of the projection '{target.name}'")
        parts.append(shapely.Polygon(shell, holes))
        _check_simple(parts[-1], name)
    valid = shapely.make_valid(parts, method="structure", keep_collapsed=False)
    return shapely.union_all(valid)


def _check_simple(part: shapely.Polygon, name: str) -> None:
    """Refuse a polygon of which a guess would take another area than was meant."""
    if shapely.is_valid(part):
        return
    repaired = float(shapely.area(shapely.make_valid(part, method="structure")))
    if abs(repaired - part.area) > CROSSED * max(repaired, part.area):
        raise FloeError(f"{name}: its ring crosses itself")


def within(polygon: shapely.Geometry, x: Array, y: Array) -> NDArray[np.bool_]:
    """Whether points (m) lie in a polygon; as the arrays are shaped.

    Parameters
    ----------
    polygon : shapely.Geometry
        m; prepared for further questions.
    x : ndarray
        m.
    y : ndarray
        m.

    Returns
    -------
    ndarray
        bool.
    """
    shapely.prepare(polygon)
    return np.asarray(shapely.contains_xy(polygon, x, y))
