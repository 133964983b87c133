# SPDX-License-Identifier: GPL-2.0-or-later
"""Observed concentration on the scene's grid beside the run's, and thickness at places."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.analysis.observations.point_files import Points
from floeflow.core import area_means, times
from floeflow.core import cf_reading as cf
from floeflow.core import fields as files
from floeflow.core.errors import FloeError
from floeflow.core.grids import from_lonlat, scene_crs, scene_grid, to_lonlat
from floeflow.core.input_files import Hints
from floeflow.diagnostics.ice_edge import edge_error
from floeflow.masks.mask_file import as_share, find_concentration
from floeflow.scene import Scene

Array = NDArray[np.float64]

log = logging.getLogger(__name__)

# Where one edge is known to be and the other not, cells of less sea do not count.
LEAST_SEA = 0.5


@dataclass(frozen=True)
class EdgeErrors:
    """Ice edges of run and observation at the observation's times.

    Attributes
    ----------
    seconds : ndarray
        Since the scene's start, (time,).
    over, under : ndarray
        Area where only the run, or only the observation has ice (m2), (time,).
    persistence : ndarray
        Integrated ice-edge error of the first observation, kept as it is (m2), (time,).
    displacement : ndarray
        Integrated error over the length of the observed edge (m), (time,).
    bias, rms : ndarray
        Of the concentration where either has ice (1), (time,).
    """

    seconds: Array
    over: Array
    under: Array
    persistence: Array
    displacement: Array
    bias: Array
    rms: Array

    @property
    def integrated(self) -> Array:
        """Integrated ice-edge error (m2), (time,)."""
        return np.asarray(self.over + self.under)


def observed_shares(scene: Scene, path: Path, variable: str, crs: str) -> tuple[Array, Array]:
    """Observed concentration on the scene's grid at its times within the run.

    Parameters
    ----------
    scene : Scene
        The scene.
    path : Path
        A file that the mask could be read from as well, with one or more times.
    variable : str
        Name of the concentration; empty: by its standard name.
    crs : str
        Projection, where the file does not tell.

    Returns
    -------
    tuple of ndarray
        Seconds since the scene's start (time,), and shares (time, y, x), NaN where unknown.

    Raises
    ------
    FloeError
        As the mask would, and where no time lies within the run.
    """
    plane, grid = scene_crs(scene.domain), scene_grid(scene.domain)
    lon, lat = to_lonlat(plane, *grid.mesh())
    end = scene.time.windows * scene.time.window
    with files.open_file(path, Hints("mask", crs, {}, variable, 0.0)) as data:
        variables = cf.variables_of(data)
        item = find_concentration(variables, variable, path)
        layout = cf.layout(variables, item, path)
        name = layout.time or layout.stamp
        if not name:
            raise FloeError(f"{path}: '{item.name}' has no time")
        seconds, bounds = times.axis_seconds(data, variables, name, scene.time.start, path)
        if bounds is not None:
            seconds = 0.5 * (bounds[0] + bounds[1])
        half = 0.5 * scene.time.window
        within = np.flatnonzero((seconds >= -half) & (seconds <= end + half))
        if not within.size:
            raise FloeError(
                f"{path}: none of its {seconds.size} times lies within the run; the first is "
                f"{times.say(scene.time.start, float(seconds[0]))}"
            )
        source = files.source_grid(variables, item, layout, data, path)
        index = within if layout.time else np.array([0])
        found = files.read_unpacked(data, item.name, layout, source, index, path)
        shares, note = as_share(found, item, path)
    if note:
        log.warning("%s", note)
    carry = area_means.transfer(source, grid, plane, lon, lat)
    known = np.isfinite(shares)
    weight = carry.of(known.astype(float))
    filled = carry.of(np.where(known, shares, 0.0))
    mean = np.divide(filled, weight, out=np.full(filled.shape, np.nan), where=weight >= LEAST_SEA)
    mean = np.where(carry.inside, mean, np.nan)
    return seconds[within], mean.reshape(-1, *grid.shape)


def edge_errors(
    scene: Scene, grid: xr.Dataset, area: Array, seen: tuple[Array, Array]
) -> EdgeErrors:
    """Compare edges at the observation's times with the nearest boundaries of the run.

    Parameters
    ----------
    scene : Scene
        The scene.
    grid : xarray.Dataset
        Its gridded output, shares of 1.
    area : ndarray
        Sea of the cells (m2), (y, x).
    seen : tuple of ndarray
        From `observed_shares`.
    """
    at, observed = seen
    own = grid["time"].values.astype(float)
    spacing = scene.domain.spacing
    # The run's cells of sea without ice have a share of 0; land is unknown in both.
    ours = np.where(area > 0.0, np.nan_to_num(grid["siconc"].values), np.nan)
    rows = []
    for seconds, truth in zip(at, observed, strict=True):
        mine = ours[int(np.argmin(np.abs(own - seconds)))]
        error = edge_error(mine, truth, area, spacing)
        stays = edge_error(observed[0], truth, area, spacing)
        both = np.isfinite(mine) & np.isfinite(truth) & (np.fmax(mine, truth) > 0.0)
        off, weight = (mine - truth)[both], area[both]
        total = weight.sum()
        bias, square = (
            (float((weight * part).sum() / total) if total > 0 else np.nan)
            for part in (off, off**2)
        )
        rows.append(
            (error.over, error.under, stays.integrated, error.displacement, bias, np.sqrt(square))
        )
    columns = np.array(rows).T
    return EdgeErrors(at, *columns)


@dataclass(frozen=True)
class ThicknessPairs:
    """Thickness observed and of the run at the same places and times (m)."""

    seconds: Array
    observed: Array
    run: Array

    @property
    def bias(self) -> float:
        """Mean of run minus observed (m)."""
        return float((self.run - self.observed).mean())

    @property
    def rms(self) -> float:
        """Root mean square of the difference (m)."""
        return float(np.sqrt(((self.run - self.observed) ** 2).mean()))

    @property
    def correlation(self) -> float:
        """Correlation; NaN where either is constant."""
        if self.observed.size < 2 or self.observed.std() == 0.0 or self.run.std() == 0.0:
            return float("nan")
        return float(np.corrcoef(self.observed, self.run)[0, 1])


def thickness_pairs(scene: Scene, grid: xr.Dataset, points: Points) -> ThicknessPairs:
    """Thickness of the run's ice in the cell and at the boundary nearest to each observation.

    Parameters
    ----------
    scene : Scene
        Its grid and window.
    grid : xarray.Dataset
        Fields of the run on (time, y, x), thickness in m.
    points : Points
        Observed thickness (m) at longitude, latitude and time.

    Raises
    ------
    FloeError
        Where no observation lies within run and ice.
    """
    assert points.thickness is not None
    cells = scene_grid(scene.domain)
    x, y = from_lonlat(scene_crs(scene.domain), points.lon, points.lat)
    column = np.floor((x - scene.domain.x_min) / cells.spacing).astype(int)
    row = np.floor((y - scene.domain.y_min) / cells.spacing).astype(int)
    own = grid["time"].values.astype(float)
    half = 0.5 * scene.time.window
    ny, nx = cells.shape
    inside = (column >= 0) & (column < nx) & (row >= 0) & (row < ny)
    inside &= (points.seconds >= own[0] - half) & (points.seconds <= own[-1] + half)
    when = np.abs(points.seconds[inside, None] - own).argmin(axis=1)
    ours = grid["sithick"].values[when, row[inside], column[inside]]
    good = np.isfinite(ours)
    if not good.any():
        raise FloeError(f"{points.path}: no observation lies within the run and its ice")
    return ThicknessPairs(points.seconds[inside][good], points.thickness[inside][good], ours[good])
