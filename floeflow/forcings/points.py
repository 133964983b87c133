# SPDX-License-Identifier: GPL-2.0-or-later
"""Files cut to one place, so that a column's forcing is read by the readers of scenes.

A file holds a point already, or a map of any kind, of which the nearest point is taken. What is
cut has no horizontal dimension left and counts as a grid of one point.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from floeflow.core import cf_reading as cf
from floeflow.core import fields
from floeflow.core.errors import FloeError
from floeflow.core.monthly import unit
from floeflow.forcings.tracks import InputFile

Place = tuple[float, float]

_ONE = np.zeros(1, dtype=np.int64)
POINT = fields.Source(np.zeros(1), np.zeros(1), None, _ONE, _ONE, False, (False, False))


@dataclass
class PointFile(InputFile):
    """A file cut to one place."""

    def layout(self, variable: cf.Variable) -> cf.Layout:
        """Roles of a variable's dimensions: time and level, and no others of more than one value.

        Parameters
        ----------
        variable : cf.Variable
            One of the file.

        Returns
        -------
        Layout
            One of longitude and latitude, on a map of one point.

        Raises
        ------
        FloeError
            Where others are left: the place is not known.
        """
        time, level, stamp, height = cf.own_axes(self.variables, variable, self.path)
        for dim, size in zip(variable.dims, variable.shape, strict=True):
            if size > 1 and dim not in (time, level):
                raise FloeError(
                    f"{self.path}: '{dim}' has {size} values: name the place by --lon and --lat on "
                    "a map"
                )
        x, y = "x of a point", "y of a point"
        return cf.Layout(x, y, True, time, level, 1.0, None, stamp, height)

    def source(self, variable: cf.Variable) -> fields.AnySource:
        """A grid of one point.

        Parameters
        ----------
        variable : cf.Variable
            One of the file.

        Returns
        -------
        Source
            That of all variables of the file.
        """
        return POINT


def at_place(file: InputFile, place: Place | None) -> PointFile:
    """Cut a file to a place.

    Parameters
    ----------
    file : InputFile
        As `open_files` gives it.
    place : tuple of float or None
        Longitude and latitude (degrees); None: the file holds a point.

    Returns
    -------
    PointFile
        The nearest point of each variable, without horizontal dimensions.

    Raises
    ------
    FloeError
        Where the place lies off a map of the file.
    """
    data, cut = file.data, set[str]()
    if place is not None:
        for variable in file.variables.values():
            if sum(size > 1 for size in variable.shape) < 2 or cut & set(variable.dims):
                continue
            try:
                layout = file.layout(variable)
            except FloeError:
                continue  # bounds, say: if it is needed, what is left of it will be refused
            row, column = _nearest(file.source(variable), place, file.path)
            data = data.isel({layout.y: row, layout.x: column})
            cut |= {layout.x, layout.y}
    data = data.isel({dim: 0 for dim, size in data.sizes.items() if size == 1 and _flat(data, dim)})
    return PointFile(file.path, data, cf.variables_of(data))


def _flat(data: xr.Dataset, dim: object) -> bool:
    """Whether a dimension of one value is none of time or level."""
    variables = cf.variables_of(data)
    return cf.dimension_kind(variables, str(dim)) not in ("time", "level")


def _nearest(source: fields.AnySource, place: Place, path: Path) -> tuple[int, int]:
    """Row and column in the file of a map's point nearest to a place."""
    lon, lat = source.lonlat()
    there = unit(np.array(place[0]), np.array(place[1]))
    points = unit(lon, lat)
    away = np.where(np.isfinite(lon), np.linalg.norm(points - there, axis=-1), np.inf)
    row, column = np.unravel_index(int(np.argmin(away)), away.shape)
    rows, columns = (slice(max(k - 1, 0), k + 2) for k in (int(row), int(column)))
    step = np.linalg.norm(points[rows, columns] - points[row, column], axis=-1)
    if away[row, column] > np.nanmax(step):
        raise FloeError(
            f"{path}: --lon {place[0]:g} --lat {place[1]:g} lies off its map; the nearest point is "
            f"{lat[row, column]:.2f} N, {lon[row, column]:.2f} E"
        )
    if isinstance(source, fields.Curvilinear):
        return int(row), int(column)
    return int(source.order_y[row]), int(source.order_x[column])
