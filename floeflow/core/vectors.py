# SPDX-License-Identifier: GPL-2.0-or-later
"""Turning vectors between east/north and the axes of a projection.

A vector keeps its speed and its bearing from true north: it is turned by the direction that north
has on the map. On a conformal projection that is also its direction on the map. EASE2 (Lambert's
azimuthal equal-area) is not conformal: near the pole meridians and parallels still cross at right
angles, but lengths along and across them differ by up to some per cent, so a drifting element's
track on the map bends by the same little. The speed in metres a second is the true one.
"""

from __future__ import annotations

import numpy as np
import pyproj
from numpy.typing import NDArray

from floeflow.core.fields import AnySource, Curvilinear
from floeflow.core.grids import from_lonlat

Array = NDArray[np.float64]

# Step along the meridian by which north is found (degrees, about 11 m).
STEP = 1.0e-4


def north_angle(crs: pyproj.CRS, lon: Array, lat: Array) -> Array:
    """Direction of true north on the map.

    Found by a step along the meridian that stays on this side of the pole, so that a point at the
    pole has the north of its own meridian.

    Parameters
    ----------
    crs : pyproj.CRS
        The projection.
    lon, lat : ndarray
        Places (degrees), any one shape.

    Returns
    -------
    ndarray
        Angle from the x axis, anticlockwise (rad), same shape.
    """
    lon, lat = np.asarray(lon, dtype=float), np.asarray(lat, dtype=float)
    upper = np.minimum(lat + STEP / 2, 90.0)
    lower = np.maximum(upper - STEP, -90.0)
    upper = np.maximum(upper, lower + STEP)
    x0, y0 = from_lonlat(crs, lon, lower)
    x1, y1 = from_lonlat(crs, lon, upper)
    return np.asarray(np.arctan2(y1 - y0, x1 - x0))


def component_angle(source: AnySource, plane: pyproj.CRS, east_north: bool, second: bool) -> Array:
    """Direction on a map of a vector's component, at the points where the component stands.

    Parameters
    ----------
    source : Source or Curvilinear
        The component's grid.
    plane : pyproj.CRS
        The map.
    east_north : bool
        Whether the component points east or north; else along an axis of the grid.
    second : bool
        Whether it is the second component: north, or along the second axis.

    Returns
    -------
    ndarray
        Angle from the map's x axis, anticlockwise (rad), (ny, nx).
    """
    lon, lat = source.lonlat()
    quarter = np.pi / 2
    north = north_angle(plane, lon, lat)
    along: Array = np.zeros(1)
    if east_north:
        pass
    elif isinstance(source, Curvilinear):
        along = first_axis_angle(lon, lat)
    elif source.crs is not None:
        # East, seen from a projection's x axis, lies a quarter turn before its north.
        along = quarter - north_angle(source.crs, lon, lat)
    return np.asarray(north - quarter + along + (quarter if second else 0.0))


def first_axis_angle(lon: Array, lat: Array) -> Array:
    """Angle of a curvilinear grid's first axis from east, anticlockwise (rad), (ny, nx).

    From the chord between the points before and behind along a row, seen in the plane of east and
    north at the point; the second axis is taken at right angles. This is what history files call
    ANGLE.

    Parameters
    ----------
    lon : ndarray
        Degrees, (ny, nx).
    lat : ndarray
        Degrees, (ny, nx).

    Returns
    -------
    ndarray
        rad.
    """
    east, north = np.radians(lon), np.radians(lat)
    place = np.stack(
        [np.cos(north) * np.cos(east), np.cos(north) * np.sin(east), np.sin(north)], axis=-1
    )
    chord = np.full(place.shape, np.nan)
    chord[:, 1:-1] = place[:, 2:] - place[:, :-2]
    for at, one, other in ((0, 1, 0), (-1, -1, -2)):
        chord[:, at] = place[:, one] - place[:, other]
    # Beside a block without places only one neighbour is there.
    for shift, sign in ((-1, 1.0), (1, -1.0)):
        one_sided = sign * (np.roll(place, shift, axis=1) - place)
        chord = np.where(np.isfinite(chord), chord, one_sided)
    along_east = -np.sin(east) * chord[..., 0] + np.cos(east) * chord[..., 1]
    along_north = (
        -np.sin(north) * (np.cos(east) * chord[..., 0] + np.sin(east) * chord[..., 1])
        + np.cos(north) * chord[..., 2]
    )
    return np.asarray(np.arctan2(along_north, along_east))


def rotate(u: Array, v: Array, angle: Array) -> tuple[Array, Array]:
    """Turn vectors anticlockwise by an angle (rad).

    Parameters
    ----------
    u : ndarray
        Components, in one unit.
    v : ndarray
        Components, in one unit.
    angle : ndarray
        rad, anticlockwise.

    Returns
    -------
    tuple of ndarray
        In the unit of the components.
    """
    cos, sin = np.cos(angle), np.sin(angle)
    return u * cos - v * sin, u * sin + v * cos


def east_north_to_map(u: Array, v: Array, angle: Array) -> tuple[Array, Array]:
    """East and north components to x and y, given `north_angle` (rad).

    Parameters
    ----------
    u : ndarray
        Components, in one unit.
    v : ndarray
        Components, in one unit.
    angle : ndarray
        Of north from the map's first axis, anticlockwise (rad).

    Returns
    -------
    tuple of ndarray
        In the unit of the components.
    """
    return rotate(u, v, angle - np.pi / 2)


def map_to_east_north(u: Array, v: Array, angle: Array) -> tuple[Array, Array]:
    """Components along x and y to east and north, given `north_angle` (rad).

    Parameters
    ----------
    u : ndarray
        Components, in one unit.
    v : ndarray
        Components, in one unit.
    angle : ndarray
        Of north from the map's first axis, anticlockwise (rad).

    Returns
    -------
    tuple of ndarray
        In the unit of the components.
    """
    return rotate(u, v, np.pi / 2 - angle)
