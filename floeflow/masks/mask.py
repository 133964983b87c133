# SPDX-License-Identifier: GPL-2.0-or-later
"""Ice concentration, ice thickness, land and true cell areas on the scene's mask grid.

The user's file may be on longitude and latitude or projected, its concentration a share or in per
cent, its days many. What is missing in it is never used as a number: see docs/masks.md.
"""

import logging
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.core import cf_reading as cf
from floeflow.core import fields, interpolate
from floeflow.core.errors import FloeError
from floeflow.core.grids import cell_area, mask_grid, scene_crs, to_lonlat
from floeflow.forcings.inputs import find_concentration, nearest_time
from floeflow.scene.blocks import Scene

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

log = logging.getLogger(__name__)

PER_CENT = {"%", "percent", "per cent", "per_cent", "percentage"}
LENGTHS = {"m": 1.0, "metre": 1.0, "meter": 1.0, "metres": 1.0, "meters": 1.0, "cm": 0.01}
# Packed files overshoot by their rounding.
TOLERANCE = 0.01
MOST_THICKNESS = 50.0


def as_share(values: Array, units: str, what: str) -> Array:
    """Concentration as a share.

    Per cent is told by the units, but files are known whose units say per cent and whose values
    are shares: where no value is above 1, they are taken as shares.

    Parameters
    ----------
    values : ndarray
        As in the file, NaN where missing.
    units : str
        The file's units.
    what : str
        File and variable, for the message.

    Raises
    ------
    FloeError
        Where units are unknown or values lie outside 0..1 by more than a packing's rounding.
    """
    known = values[np.isfinite(values)]
    low, high = float(known.min()), float(known.max())
    if units.lower() in PER_CENT:
        if high > 1.0 + TOLERANCE:
            values, low, high = values / 100.0, low / 100.0, high / 100.0
        else:
            log.warning("%s: units say '%s' but no value is above 1: taken as shares", what, units)
    elif units not in ("", "1", "fraction"):
        raise FloeError(f"{what} has units '{units}', which are neither a share nor per cent")
    if low < -TOLERANCE or high > 1.0 + TOLERANCE:
        raise FloeError(
            f"{what} (units '{units}') reaches from {low:g} to {high:g} as a share, outside 0..1: "
            "check its units and its missing values"
        )
    return np.clip(values, 0.0, 1.0)


def as_metres(values: Array, units: str, what: str) -> Array:
    """Ice thickness in metres; see `as_share`."""
    if units.lower() not in LENGTHS:
        raise FloeError(f"{what} has units '{units}', not m or cm")
    values = values * LENGTHS[units.lower()]
    known = values[np.isfinite(values)]
    low, high = float(known.min()), float(known.max())
    if low < -TOLERANCE or high > MOST_THICKNESS:
        raise FloeError(
            f"{what} reaches from {low:g} to {high:g} m, outside 0..{MOST_THICKNESS:g} m: check "
            "its units and its missing values"
        )
    return np.maximum(values, 0.0)


class _Reader:
    """The fields of one mask file, brought to the mask grid."""

    def __init__(self, scene: Scene, lon: Array, lat: Array) -> None:
        self.scene, self.shape = scene, lon.shape
        self.path = Path(scene.mask.file)
        self.variables = cf.describe(self.path)
        mask = scene.mask
        self.concentration = find_concentration(self.variables, mask.concentration, self.path)
        with fields.open_file(self.path) as data:
            layout = cf.layout(self.variables, self.concentration, self.path)
            self.source = fields.source_grid(
                self.variables, self.concentration, layout, data, self.path
            )
            self.weights = interpolate.weights(self.source, lon, lat)
            self.raw = self._raw(data, self.concentration)
            self.thickness = self._raw(data, self._variable("thickness"))
            self.water = self._raw(data, self._variable("water"))

    def _variable(self, key: str) -> cf.Variable | None:
        name = getattr(self.scene.mask, key)
        return cf.named(self.variables, name, self.path, f"mask.{key}") if name else None

    def _raw(self, data: xr.Dataset, variable: cf.Variable | None) -> Array | None:
        if variable is None:
            return None
        layout = cf.layout(self.variables, variable, self.path)
        index, off = nearest_time(self.path, self.variables, layout, self.scene)
        if abs(off) > 86400.0:
            log.warning(
                "%s: '%s' is %.1f days away from the scene's start",
                self.path,
                variable.name,
                off / 86400.0,
            )
        values = fields.read_values(
            data, variable.name, layout, self.source, np.array([index]), self.path
        )[0]
        if values.shape != (self.source.y.size, self.source.x.size):
            raise FloeError(
                f"{self.path}: '{variable.name}' is not on the grid of '{self.concentration.name}'"
            )
        if not np.isfinite(values).any():
            raise FloeError(
                f"{self.path}: variable '{variable.name}' has no value that is not missing"
            )
        return values

    def what(self, variable: cf.Variable) -> str:
        return f"{self.path}: variable '{variable.name}'"

    def to_grid(self, values: Array) -> Array:
        """Bilinear; nothing (0) off the file's grid."""
        filled = interpolate.fill_nearest(values, self.source, self.scene.mask.fill_reach)
        found = self.weights.apply(self.source.padded(filled))
        return np.where(self.weights.inside, found, 0.0).reshape(self.shape)


def make_mask(scene: Scene, land_fraction: Array | None) -> xr.Dataset:
    """Ice, land and areas on the mask grid.

    Parameters
    ----------
    scene : Scene
        Its domain and mask are read.
    land_fraction : ndarray or None
        Share of land (ny, nx) where ``mask.land`` is ``global_land_mask``; otherwise None.

    Returns
    -------
    xarray.Dataset
        siconc, sithick (m, over the ice), land, cell_area (m2) on (y, x); attribute crs.

    Raises
    ------
    FloeError
        For all that is wrong with the file.
    """
    grid = mask_grid(scene.domain, scene.mask.refine)
    crs = scene_crs(scene.domain)
    lon, lat = to_lonlat(crs, *grid.mesh())
    reader = _Reader(scene, lon, lat)
    assert reader.raw is not None
    raw = as_share(
        reader.raw, reader.concentration.text("units"), reader.what(reader.concentration)
    )
    if reader.water is not None:
        raw = np.where(np.isnan(raw) & np.isfinite(reader.water), 0.0, raw)
    if scene.mask.land == "none":
        land = np.zeros(grid.shape, dtype=bool)
    elif land_fraction is None:
        missing = reader.weights.apply(reader.source.padded(np.isnan(raw).astype(float)))
        land = (missing.reshape(grid.shape) >= scene.mask.land_fraction) & (
            reader.weights.inside.reshape(grid.shape)
        )
    else:
        land = land_fraction >= scene.mask.land_fraction
    siconc = np.clip(reader.to_grid(raw), 0.0, 1.0)
    if not reader.weights.inside.all():
        log.warning(
            "%s covers %.1f %% of the scene; elsewhere there is open water",
            reader.path,
            100.0 * reader.weights.inside.mean(),
        )
    siconc[land | (siconc < scene.mask.minimum_concentration)] = 0.0
    siconc, sithick = _with_thickness(scene, reader, siconc)
    area = cell_area(grid, crs)
    log.info(
        "ice area %.6g km2, ice volume %.6g km3, land %.1f %% of the cells",
        (siconc * area).sum() / 1e6,
        (siconc * sithick * area).sum() / 1e9,
        100.0 * land.mean(),
    )
    return _dataset(scene, grid.x, grid.y, siconc, sithick, land, area)


def _with_thickness(scene: Scene, reader: _Reader, siconc: Array) -> tuple[Array, Array]:
    """Thickness from the file or by the scene's rule; ice without thickness is no ice."""
    if reader.thickness is not None:
        variable = reader.variables[scene.mask.thickness]
        metres = as_metres(reader.thickness, variable.text("units"), reader.what(variable))
        sithick = reader.to_grid(metres)
    elif scene.mask.thickness_rule == "constant":
        sithick = np.full_like(siconc, scene.mask.ice_thickness)
    else:
        sithick = scene.mask.ice_thickness * siconc
    siconc = np.where(sithick > 0.0, siconc, 0.0)
    return siconc, np.where(siconc > 0.0, sithick, 0.0)


def _dataset(
    scene: Scene, x: Array, y: Array, siconc: Array, sithick: Array, land: Flags, area: Array
) -> xr.Dataset:
    dims = ("y", "x")
    return xr.Dataset(
        {
            "siconc": (dims, siconc, {"units": "1", "standard_name": "sea_ice_area_fraction"}),
            "sithick": (dims, sithick, {"units": "m", "standard_name": "sea_ice_thickness"}),
            "land": (dims, land.astype(np.int8), {"units": "1", "long_name": "1 land, 0 water"}),
            "cell_area": (dims, area, {"units": "m2", "standard_name": "cell_area"}),
        },
        coords={"x": ("x", x, {"units": "m"}), "y": ("y", y, {"units": "m"})},
        attrs={"crs": scene.domain.crs},
    )
