# SPDX-License-Identifier: GPL-2.0-or-later
"""Ice concentration, ice thickness, land and true cell areas on the scene's mask grid.

The user's file may be on longitude and latitude or projected, its concentration a share or in per
cent, its days many. What is missing in it is never used as a number: see docs/masks.md.
"""

import logging
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.core import area_means, fields, interpolate
from floeflow.core.errors import FloeError
from floeflow.core.grids import Grid, cell_area, mask_grid, scene_crs, to_lonlat
from floeflow.core.period import ATTRIBUTE
from floeflow.masks.floe_mask import floe_mask
from floeflow.masks.labels import read_labels
from floeflow.masks.mask_file import MaskFile, read_mask_file
from floeflow.masks.pole_hole import LOWEST, RIM, find_hole, rim_mean
from floeflow.masks.regions import region_cells, shore_cells
from floeflow.masks.thickness import CELL_MEAN
from floeflow.masks.thickness_climatology import climatological_thickness
from floeflow.scene.blocks import Scene
from floeflow.state.scene_walls import make_planes
from floeflow.state.walls import distances

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

log = logging.getLogger(__name__)

# Ice that a map does not have is told of from this share of all ice on.
TOLD = 0.005


@dataclass
class _Placed:
    """A mask file's fields, its gaps filled, and the weights to the mask grid."""

    scene: Scene
    file: MaskFile
    transfer: interpolate.Transfer
    shape: tuple[int, int]
    share: Array
    hole: Flags
    beyond: Flags

    def to_grid(self, values: Array) -> Array:
        """On the mask grid; nothing (0) off the file's grid, but its rim's mean over the pole."""
        filled = interpolate.fill_nearest(values, self.file.source, self.scene.mask.fill_reach)
        found = np.where(self.transfer.inside, self.transfer.of(filled), 0.0).reshape(self.shape)
        if self.beyond.any():
            _, lat = self.file.source.lonlat()
            south = float(np.nanmax(lat))
            found[self.beyond] = rim_mean(values, south, lat) or 0.0
        return found

    def without_hole(self, values: Array) -> Array:
        """The same with the pole hole filled to its rim's mean.

        Raises
        ------
        FloeError
            Where the rim has no values.
        """
        missing = self.hole & np.isnan(values)
        if not missing.any():
            return values
        _, lat = self.file.source.lonlat()
        south = float(lat[missing].min())
        mean = rim_mean(values, south, lat)
        if mean is None:
            raise FloeError(
                f"{self.file.path}: the hole around the pole, north of {south:.1f} N, has no "
                f"values within {RIM:g} degree of its rim that could fill it"
            )
        return np.where(missing, mean, values)


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
        siconc, sithick (m, over the ice), land, cell_area (m2) on (y, x); attributes crs, and
        notes of what was found in the file.

    Raises
    ------
    FloeError
        For all that is wrong with the file.
    """
    grid = mask_grid(scene.domain, scene.mask.refine)
    crs = scene_crs(scene.domain)
    if scene.packing.generator == "floes":
        return _make_floe_mask(scene, grid, land_fraction)
    if scene.mask.uniform > 0.0:
        return _make_uniform_mask(scene, grid, land_fraction)
    lon, lat = to_lonlat(crs, *grid.mesh())
    file = read_mask_file(scene)
    transfer = area_means.transfer(file.source, grid, crs, lon, lat)
    placed, notes = _placed(scene, file, transfer, lat)
    if scene.mask.land == "none":
        land = np.zeros(grid.shape, dtype=bool)
    elif land_fraction is None:
        land = _land_of_file(placed) >= scene.mask.land_fraction
    else:
        land = land_fraction >= scene.mask.land_fraction
    land |= _shore(scene, grid)
    siconc = np.clip(placed.to_grid(placed.share), 0.0, 1.0)
    covered = (transfer.inside.reshape(grid.shape) | placed.beyond).mean()
    if covered < 1.0:
        notes.append(
            f"{file.path} covers {100.0 * covered:.1f} % of the scene; elsewhere there is open "
            "water"
        )
    siconc[land | (siconc < scene.mask.minimum_concentration)] = 0.0
    area = cell_area(grid, crs)
    notes += _cut(scene, grid, siconc, area)
    notes += _guesses(placed, siconc * area, land)
    siconc, sithick = _with_thickness(scene, placed, siconc, lon, lat)
    for note in notes:
        log.info("%s", note)
    log.info(
        "ice area %.6g km2, ice volume %.6g km3, land %.1f %% of the cells",
        (siconc * area).sum() / 1e6,
        (siconc * sithick * area).sum() / 1e9,
        100.0 * land.mean(),
    )
    made = _dataset(scene, grid.x, grid.y, siconc, sithick, land, area)
    made.attrs["notes"] = "\n".join(notes)
    return made


def _guesses(placed: _Placed, ice: Array, land: Flags) -> list[str]:
    """What a map does not tell by itself: ice where it has no value, and no land at all."""
    found, path, mask = [], placed.file.path, placed.scene.mask
    known = placed.transfer.of(np.isfinite(placed.share).astype(float)).reshape(placed.shape)
    filled, total = float((ice * np.clip(1.0 - known, 0.0, 1.0))[~placed.beyond].sum()), ice.sum()
    if filled > TOLD * total:
        found.append(
            f"{filled / 1e6:.4g} km2 of the ice ({100.0 * filled / total:.1f} %) lie where {path} "
            f"has no value, and are as the nearest within {mask.fill_reach / 1e3:g} km "
            "(mask.fill_reach); where a file leaves open water out, name mask.water"
        )
    if mask.land == "mask" and not land.any():
        found.append(f"{path} tells of no land in the scene: all of it is sea")
    return found


def _shore(scene: Scene, grid: Grid) -> Flags:
    """Land of the user's shoreline, (ny, nx)."""
    if not scene.mask.shoreline:
        return np.zeros(grid.shape, dtype=bool)
    return shore_cells(scene.mask.shoreline, grid, scene.domain.crs)


def _region(scene: Scene, grid: Grid) -> Flags:
    """Cells of the region that cuts the scene, (ny, nx)."""
    if not scene.mask.region:
        return np.ones(grid.shape, dtype=bool)
    return region_cells(scene.mask.region, grid, scene.domain.crs)


def _behind_planes(scene: Scene, grid: Grid) -> Flags:
    """Cells whose centre lies behind a plane of the scene's walls, (ny, nx)."""
    behind = np.zeros(grid.shape, dtype=bool)
    for face in make_planes(scene):
        behind |= distances(face, *grid.mesh()) < 0.0
    return behind


def _cut(scene: Scene, grid: Grid, siconc: Array, area: Array) -> list[str]:
    """Take out, in place, what lies beyond the region and behind planes; notes of the latter."""
    siconc[~_region(scene, grid)] = 0.0
    behind = _behind_planes(scene, grid)
    lost, whole = float((siconc * area)[behind].sum()), float((siconc * area).sum())
    siconc[behind] = 0.0
    if lost == 0.0:
        return []
    return [f"walls: {100.0 * lost / whole:.3g} % of the ice lies behind one and is left out"]


def _known_land(scene: Scene, grid: Grid, land_fraction: Array | None) -> Flags:
    """Land without a mask file that would tell it, (ny, nx)."""
    land = _shore(scene, grid)
    return land if land_fraction is None else land | (land_fraction >= scene.mask.land_fraction)


def _make_uniform_mask(scene: Scene, grid: Grid, land_fraction: Array | None) -> xr.Dataset:
    """Mask of one concentration on all water of the region."""
    land = _known_land(scene, grid, land_fraction)
    area = cell_area(grid, scene_crs(scene.domain))
    siconc = np.where(land, 0.0, scene.mask.uniform)
    notes = _cut(scene, grid, siconc, area)
    for note in notes:
        log.info("%s", note)
    sithick = _thickness_by_rule(scene, siconc, *to_lonlat(scene_crs(scene.domain), *grid.mesh()))
    made = _dataset(scene, grid.x, grid.y, siconc, sithick, land, area)
    made.attrs["notes"] = "\n".join(notes)
    return made


def _make_floe_mask(scene: Scene, grid: Grid, land_fraction: Array | None) -> xr.Dataset:
    """Mask of a labelled image: concentration is the share that floes cover."""
    land = _known_land(scene, grid, land_fraction)
    floes = read_labels(scene.mask.labels, scene.domain)
    # Floes are whole: a region leaves out those that reach beyond it, a plane those behind it.
    within = _region(scene, grid) & ~_behind_planes(scene, grid)
    siconc, pixels = floe_mask(floes, grid, land, within)
    sithick = np.where(siconc > 0, scene.mask.ice_thickness, 0.0)
    area = cell_area(grid, scene_crs(scene.domain))
    made = _dataset(scene, grid.x, grid.y, siconc, sithick, land, area).merge(pixels)
    made.attrs |= pixels.attrs | {"notes": ""}
    return made


def _placed(
    scene: Scene, file: MaskFile, transfer: interpolate.Transfer, lat: Array
) -> tuple[_Placed, list[str]]:
    """Fill open water and the pole hole, and say so."""
    notes = list(file.notes)
    share = file.share
    if file.water is not None:
        share = np.where(np.isnan(share) & file.water, 0.0, share)
    _, own = file.source.lonlat()
    hole = find_hole(np.isfinite(share), file.hole, own)
    cells = np.zeros(share.shape, bool) if hole is None else hole.cells
    beyond = _beyond_file(file.source, transfer, lat)
    placed = _Placed(scene, file, transfer, lat.shape, share, cells, beyond)
    if hole is not None:
        placed.share = placed.without_hole(share)
        notes.append(_hole_note(hole.south, float(placed.share[cells].mean())))
    elif beyond.any():
        south = float(np.nanmax(own))
        notes.append(_hole_note(south, rim_mean(share, south, own) or 0.0))
    if isinstance(transfer, area_means.AreaMeans):
        notes.append("the file is finer than the mask: area means of its cells")
    return placed, notes


def _hole_note(south: float, mean: float) -> str:
    return (
        f"the hole around the pole, north of {south:.1f} N, is filled to its rim's mean "
        f"concentration, {mean:.2f}"
    )


def _beyond_file(source: fields.AnySource, transfer: interpolate.Transfer, lat: Array) -> Flags:
    """Mask cells around the pole that a file of longitudes all round ends short of."""
    none = np.zeros(lat.shape, bool)
    if not isinstance(source, fields.Source) or source.crs is not None or not source.periodic:
        return none
    top = float(source.y[-1])
    if top < LOWEST:
        return none
    return ~transfer.inside.reshape(lat.shape) & (lat > top)


def _land_of_file(placed: _Placed) -> Array:
    """Share of land by the file: its flags, else what is missing and no pole hole."""
    file = placed.file
    land = np.isnan(placed.share) & ~placed.hole if file.land is None else file.land
    found = placed.transfer.of(land.astype(float))
    return np.where(placed.transfer.inside, found, 0.0).reshape(placed.shape)


def _thickness_by_rule(scene: Scene, siconc: Array, lon: Array, lat: Array) -> Array:
    """Thickness of the ice (m) where no file tells it, (ny, nx); 0 where there is none."""
    rule = scene.mask.thickness_rule
    if rule == "constant":
        thick = np.full_like(siconc, scene.mask.ice_thickness)
    elif rule == "concentration":
        thick = scene.mask.ice_thickness * siconc
    else:
        thick = climatological_thickness(lon, lat, scene.time.start) * siconc
    return np.where(siconc > 0.0, thick, 0.0)


def _with_thickness(
    scene: Scene, placed: _Placed, siconc: Array, lon: Array, lat: Array
) -> tuple[Array, Array]:
    """Thickness from the file or by the scene's rule; ice without thickness is no ice.

    What is brought to the grid is volume per area, so that none is lost or made.
    """
    file = placed.file
    if file.thickness is not None:
        metres = placed.without_hole(file.thickness)
        if file.thickness_is == CELL_MEAN:
            volume, share = placed.to_grid(metres), placed.to_grid(placed.share)
        else:
            reach = scene.mask.fill_reach
            filled = [
                interpolate.fill_nearest(part, file.source, reach)
                for part in (placed.share, metres)
            ]
            share = placed.to_grid(filled[0])
            volume = placed.to_grid(filled[0] * filled[1])
        sithick = np.divide(volume, share, out=np.zeros_like(volume), where=share > 0.0)
    else:
        sithick = _thickness_by_rule(scene, siconc, lon, lat)
    siconc = np.where(sithick > 0.0, siconc, 0.0)
    return siconc, np.where(siconc > 0.0, sithick, 0.0)


def _dataset(
    scene: Scene, x: Array, y: Array, siconc: Array, sithick: Array, land: Flags, area: Array
) -> xr.Dataset:
    dims, period = ("y", "x"), scene.period
    repeats = {} if period is None else {ATTRIBUTE: list(period)}
    return xr.Dataset(
        {
            "siconc": (dims, siconc, {"units": "1", "standard_name": "sea_ice_area_fraction"}),
            "sithick": (dims, sithick, {"units": "m", "standard_name": "sea_ice_thickness"}),
            "land": (dims, land.astype(np.int8), {"units": "1", "long_name": "1 land, 0 water"}),
            "cell_area": (dims, area, {"units": "m2", "standard_name": "cell_area"}),
        },
        coords={"x": ("x", x, {"units": "m"}), "y": ("y", y, {"units": "m"})},
        attrs={"crs": scene.domain.crs} | repeats,
    )
