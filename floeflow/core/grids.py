# SPDX-License-Identifier: GPL-2.0-or-later
"""The scene's two grids in projected metres, their places on the earth and their true areas.

The scene grid carries forcing and gridded output; the mask grid, finer by ``mask.refine``, carries
ice and land. Both cover the scene's rectangle exactly.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import pyproj
from numpy.typing import NDArray
from pyproj.exceptions import CRSError
from scipy import sparse

from floeflow.core.errors import FloeError

Array = NDArray[np.float64]

# An areal scale this near to one everywhere is that of an equal-area projection, whose scale
# pyproj finds by finite differences.
EQUAL_AREA_TOLERANCE = 1e-6

EARTH_RADIUS = 6371.0e3  # m, for distances that need no ellipsoid


class Domain(Protocol):
    """A rectangle of a projection, as a scene's block ``domain`` gives it."""

    @property
    def x_min(self) -> float:
        """Left side (m)."""

    @property
    def x_max(self) -> float:
        """Right side (m)."""

    @property
    def y_min(self) -> float:
        """Lower side (m)."""

    @property
    def y_max(self) -> float:
        """Upper side (m)."""

    @property
    def spacing(self) -> float:
        """Width of a cell (m)."""

    @property
    def crs(self) -> str:
        """Name of the projection."""


@dataclass(frozen=True)
class Grid:
    """A regular grid of square cells.

    Parameters
    ----------
    x, y : ndarray
        Cell centres (m), ascending, (nx,) and (ny,).
    spacing : float
        Side of a cell (m).
    x_min, y_min : float
        Lower left corner of the grid (m).
    """

    x: Array
    y: Array
    spacing: float
    x_min: float
    y_min: float

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.y.size, self.x.size

    @property
    def x_edges(self) -> Array:
        """Sides of the columns (m), (nx + 1,)."""
        return np.asarray(self.x_min + self.spacing * np.arange(self.x.size + 1), dtype=float)

    @property
    def y_edges(self) -> Array:
        """Sides of the rows (m), (ny + 1,)."""
        return np.asarray(self.y_min + self.spacing * np.arange(self.y.size + 1), dtype=float)

    def mesh(self) -> tuple[Array, Array]:
        """Centres of all cells, x and y (m), each (ny, nx)."""
        x, y = np.meshgrid(self.x, self.y)
        return x, y

    def cell_of(self, x: Array, y: Array) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Row and column of the cells in which points lie; points outside get the nearest.

        Parameters
        ----------
        x : ndarray
            m, (n,).
        y : ndarray
            m, (n,).

        Returns
        -------
        tuple of ndarray
            (n,) each.
        """
        column = np.floor((x - self.x_min) / self.spacing).astype(np.int64)
        row = np.floor((y - self.y_min) / self.spacing).astype(np.int64)
        return np.clip(row, 0, self.y.size - 1), np.clip(column, 0, self.x.size - 1)


def _grid(domain: Domain, refine: int) -> Grid:
    spacing = domain.spacing / refine
    nx = refine * round((domain.x_max - domain.x_min) / domain.spacing)
    ny = refine * round((domain.y_max - domain.y_min) / domain.spacing)
    x = domain.x_min + spacing * (np.arange(nx, dtype=float) + 0.5)
    y = domain.y_min + spacing * (np.arange(ny, dtype=float) + 0.5)
    return Grid(np.asarray(x, float), np.asarray(y, float), spacing, domain.x_min, domain.y_min)


def scene_grid(domain: Domain) -> Grid:
    """Grid of forcing and output: cells of ``domain.spacing``.

    Parameters
    ----------
    domain : Domain
        Rectangle of the scene (m).

    Returns
    -------
    Grid
        Centres of the cells (m), both axes ascending.
    """
    return _grid(domain, 1)


def mask_grid(domain: Domain, refine: int) -> Grid:
    """Grid of ice and land: cells of ``domain.spacing / refine``.

    Parameters
    ----------
    domain : Domain
        Rectangle (m) and spacing (m).
    refine : int
        Cells of the mask along a side of a cell of the grid.

    Returns
    -------
    Grid
        Cells.
    """
    return _grid(domain, refine)


def scene_crs(domain: Domain) -> pyproj.CRS:
    """Projection of the scene.

    Parameters
    ----------
    domain : Domain
        With the name of a projection.

    Returns
    -------
    pyproj.CRS
        Projected, its axes in metres.

    Raises
    ------
    FloeError
        Where ``domain.crs`` names none, or none in metres.
    """
    try:
        crs = pyproj.CRS.from_user_input(domain.crs)
    except CRSError:
        raise FloeError(f"domain.crs: '{domain.crs}' names no coordinate system") from None
    if not crs.is_projected or any(axis.unit_name != "metre" for axis in crs.axis_info[:2]):
        raise FloeError(f"domain.crs: '{domain.crs}' is not a projection in metres")
    return crs


def geodetic(crs: pyproj.CRS) -> pyproj.CRS:
    """Longitude and latitude on the projection's own ellipsoid (or sphere).

    Parameters
    ----------
    crs : pyproj.CRS
        A projection.

    Returns
    -------
    pyproj.CRS
        In degrees.
    """
    base = crs.geodetic_crs
    assert base is not None
    return base


def metres_per_unit(crs: pyproj.CRS) -> float:
    """Metres in a unit of a projection's axes: 1000 with ``+units=km``.

    Parameters
    ----------
    crs : pyproj.CRS
        A projection.

    Returns
    -------
    float
        m; 1 where the projection names no unit.
    """
    axes = crs.axis_info
    return float(axes[0].unit_conversion_factor) if axes else 1.0


def to_lonlat(crs: pyproj.CRS, x: Array, y: Array) -> tuple[Array, Array]:
    """Longitude and latitude (degrees) of projected points (m), on the projection's ellipsoid.

    Parameters
    ----------
    crs : pyproj.CRS
        Projection.
    x : ndarray
        m, of one shape.
    y : ndarray
        m, of one shape.

    Returns
    -------
    lon, lat : ndarray
        Degrees, of the shape of the points.

    Raises
    ------
    FloeError
        Where a point has none, because the scene reaches beyond its projection.
    """
    transformer = pyproj.Transformer.from_crs(crs, geodetic(crs), always_xy=True)
    unit = metres_per_unit(crs)
    lon, lat = transformer.transform(np.asarray(x) / unit, np.asarray(y) / unit)
    lon, lat = np.asarray(lon, dtype=float), np.asarray(lat, dtype=float)
    bad = ~(np.isfinite(lon) & np.isfinite(lat))
    if bad.any():
        place = np.argwhere(bad)[0]
        at = float(np.asarray(x)[tuple(place)]), float(np.asarray(y)[tuple(place)])
        raise FloeError(
            f"domain: the point x = {at[0]:g} m, y = {at[1]:g} m lies outside of the projection "
            f"'{crs.name}'"
        )
    return lon, lat


def from_lonlat(crs: pyproj.CRS, lon: Array, lat: Array) -> tuple[Array, Array]:
    """Projected points (m) of longitudes and latitudes (degrees) on the projection's ellipsoid.

    Parameters
    ----------
    crs : pyproj.CRS
        Projection.
    lon : ndarray
        Degrees.
    lat : ndarray
        Degrees.

    Returns
    -------
    tuple of ndarray
        x and y, of the shape of ``lon``.
    """
    transformer = pyproj.Transformer.from_crs(geodetic(crs), crs, always_xy=True)
    # PROJ refuses longitudes of several turns.
    x, y = transformer.transform(np.mod(lon, 360.0), lat)
    unit = metres_per_unit(crs)
    return unit * np.asarray(x, dtype=float), unit * np.asarray(y, dtype=float)


def cell_area(grid: Grid, crs: pyproj.CRS) -> Array:
    """Area of the cells on the earth.

    The plane area over the projection's areal scale (Snyder 1987, eq. 4-13) at the cell's centre.

    Parameters
    ----------
    grid : Grid
        Cells.
    crs : pyproj.CRS
        Their projection.

    Returns
    -------
    ndarray
        True areas (m2), (ny, nx); exactly the plane area where the projection is equal-area.
    """
    lon, lat = to_lonlat(crs, *grid.mesh())
    scale = np.asarray(pyproj.Proj(crs).get_factors(lon, lat).areal_scale, dtype=float)
    # At the pole itself the finite differences of the scale may fail.
    fine = np.isfinite(scale) & (scale > 0)
    scale[~fine] = np.median(scale[fine])
    if np.all(np.abs(scale - 1.0) < EQUAL_AREA_TOLERANCE):
        scale[:] = 1.0
    return grid.spacing**2 / scale


def overlaps(edges: Array, others: Array) -> sparse.csr_matrix:
    """Length (m) that the intervals between edges share with those between others, (n, m).

    Parameters
    ----------
    edges : ndarray
        m, ascending, (n + 1,).
    others : ndarray
        m, ascending, (m + 1,).

    Returns
    -------
    scipy.sparse.csr_matrix
        m.
    """
    first = np.clip(np.searchsorted(others, edges[:-1], side="right") - 1, 0, None)
    last = np.clip(np.searchsorted(others, edges[1:], side="left"), None, len(others) - 1)
    count = np.maximum(last - first, 0)
    of = np.repeat(np.arange(len(count)), count)
    rank = np.arange(len(of)) - np.repeat(np.cumsum(count) - count, count)
    other = first[of] + rank
    shared = np.minimum(edges[of + 1], others[other + 1]) - np.maximum(edges[of], others[other])
    shape = (len(edges) - 1, len(others) - 1)
    return sparse.csr_matrix((np.maximum(shared, 0.0), (of, other)), shape=shape)
