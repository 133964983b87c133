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


def rotate(u: Array, v: Array, angle: Array) -> tuple[Array, Array]:
    """Turn vectors anticlockwise by an angle (rad)."""
    cos, sin = np.cos(angle), np.sin(angle)
    return u * cos - v * sin, u * sin + v * cos


def east_north_to_map(u: Array, v: Array, angle: Array) -> tuple[Array, Array]:
    """East and north components to x and y, given `north_angle` (rad)."""
    return rotate(u, v, angle - np.pi / 2)


def map_to_east_north(u: Array, v: Array, angle: Array) -> tuple[Array, Array]:
    """Components along x and y to east and north, given `north_angle` (rad)."""
    return rotate(u, v, np.pi / 2 - angle)
