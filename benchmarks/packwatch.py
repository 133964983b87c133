# SPDX-License-Identifier: GPL-2.0-or-later
"""What the elements of a window's end show: where they lie, what they claim, what holds them.

Outlines are the elements' cells, carried and turned with them, scaled to their effective areas.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import shapely
import xarray as xr
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from floeflow.core import grids
from floeflow.core.constants import EDGE_SHARE
from floeflow.core.grids import scene_grid
from floeflow.coupling.sea.shares import balanced_pull, build_shares
from floeflow.dynamics.remesh.overlap import carried_polygons, overlap
from floeflow.dynamics.remesh.remap import outlines
from floeflow.packings import discs
from floeflow.packings.elements import grid_of
from floeflow.scene import Scene
from floeflow.state import read_dataset
from floeflow.state.schema import MOBILE
from floeflow.transfer import Grid

Array = NDArray[np.float64]
Shapes = NDArray[np.object_]

DAY = 86400.0


@dataclass(frozen=True)
class Sea:
    """Where land and sea are.

    Parameters
    ----------
    land : ndarray of shapely.Polygon
        Cells of the mask that are land, (k,).
    boxes : ndarray of shapely.Polygon
        Cells of the scene's grid, (m,).
    area : ndarray
        Sea in these (m2), (m,).
    grid : Grid
        That grid.
    pull : ndarray
        Of its cells on the elements, (m,).
    """

    land: Shapes
    boxes: Shapes
    area: Array
    grid: Grid
    pull: Array


@dataclass(frozen=True)
class Watched:
    """What the elements of a window's end show.

    Parameters
    ----------
    day : float
        Days since the start.
    elements, ashore : int
        Mobile elements, and those of them whose centre lies on a land cell of the mask.
    outline_error : float
        Largest difference of an outline's area and the effective area, over the latter.
    sum_error : float
        Areas and unclaimed water less the ocean's area, over that.
    water : float
        Unclaimed water over the ocean's area.
    cells_overlap : float
        Area that two outlines share, over the sum of their areas.
    crowded, dealt : float
        Area claimed beyond the sea of the scene's cells, over all area: as outlines lie, and as
        the exchange with the sea deals it out (`floeflow.coupling.sea.shares`).
    neighbours, touching : float
        Medians of how many elements one touches, and of the length of these contacts over the
        outline of a hexagon of its area.
    outlines_on_land, discs_on_land : float
        Ice area on land as outlines and as discs show it, over all ice area.
    bonded : float
        Length that bonds hold (m), both sides counted.
    perimeter : float
        Length of all outlines (m).
    volume, ridged_volume, ridged_area, ice_area : float
        Ice volume, that of ridges (m3), their area and the ice's (m2).
    """

    day: float
    elements: int
    ashore: int
    outline_error: float
    sum_error: float
    water: float
    cells_overlap: float
    crowded: float
    dealt: float
    neighbours: float
    touching: float
    outlines_on_land: float
    discs_on_land: float
    bonded: float
    perimeter: float
    volume: float
    ridged_volume: float
    ridged_area: float
    ice_area: float


def read_sea(folder: Path, scene: Scene) -> Sea:
    """Land and sea of a run."""
    return sea_of(read_dataset(folder / "preprocess/mask.nc"), scene_grid(scene.domain))


def sea_of(mask: xr.Dataset, coarse: grids.Grid) -> Sea:
    """Land and sea of a mask; the latter in the cells of a coarser grid."""
    grid, land = grid_of(mask), mask["land"].values > 0
    x, y = grid.mesh()
    half = 0.5 * grid.spacing
    cells = shapely.box(x[land] - half, y[land] - half, x[land] + half, y[land] + half)
    cx, cy = coarse.mesh()
    half = 0.5 * coarse.spacing
    boxes = shapely.box(cx - half, cy - half, cx + half, cy + half).ravel()
    row = np.floor((y - coarse.y_min) / coarse.spacing).astype(int)
    column = np.floor((x - coarse.x_min) / coarse.spacing).astype(int)
    flat = row * coarse.shape[1] + column
    sea = np.where(land, 0.0, mask["cell_area"].values)
    area = np.bincount(flat.ravel(), sea.ravel(), len(boxes)).astype(float)
    wet, cell_area = ~land, mask["cell_area"].values
    target = Grid(coarse.x, coarse.y)
    pull = balanced_pull(x[wet], y[wet], cell_area[wet], target)
    return Sea(cells, np.asarray(boxes), area, target, pull)


def shapes(state: xr.Dataset, rows: NDArray[np.int64]) -> Shapes:
    """Outlines of some elements, where they are."""
    place = np.stack([state["x"].values, state["y"].values], axis=1)[rows]
    start, corner = outlines(state, rows)
    theta, area = state["theta"].values[rows], state["area"].values[rows]
    return carried_polygons(start, corner, place, theta, area)


def watch(state: xr.Dataset, sea: Sea) -> Watched:
    """Look at the elements of a window's end (a state or a snapshot with outlines)."""
    rows = np.flatnonzero((state["type"].values == MOBILE) & (state["area"].values > 0.0))
    area = state["area"].values[rows]
    ice = state["ice_fraction"].values[rows].sum(axis=1)
    cells = shapes(state, rows)
    on_map = shapely.area(cells)
    first, second, both, _ = overlap(cells, cells)
    twice = first < second
    _, box, claimed, _ = overlap(cells, sea.boxes)
    claims = np.bincount(box, claimed, len(sea.boxes))
    beyond = np.maximum(claims - sea.area, 0.0)
    place = np.stack([state["x"].values, state["y"].values], axis=1)[rows]
    around = sea.area.reshape(sea.grid.shape)
    dealt = build_shares(place[:, 0], place[:, 1], area, sea.grid, around, sea.pull)
    ocean, water = float(state.attrs["ocean_area"]), float(state.attrs["unclaimed_water"])
    round_ = shapely.polygons(discs.outlines(place, state["radius"].values[rows]))
    # Ice as discs show it: what of the disc lies on land, of the element's ice.
    dry, wet = (on_land(each, sea.land) for each in (cells, round_))
    points = shapely.points(place)
    land = shapely.STRtree(sea.land)
    neighbours, touching = contacts_of(place, state["radius"].values[rows], area)
    level_area = state["level_area"].values[rows] if "level_area" in state else 1.0
    level_volume = state["level_volume"].values[rows] if "level_volume" in state else 1.0
    share, volume = state["ice_fraction"].values[rows], state["ice_volume"].values[rows]
    ridged = area @ ((1.0 - level_area) * share).sum(axis=1)
    piled = area @ ((1.0 - level_volume) * volume).sum(axis=1)
    return Watched(
        day=float(state.attrs["time"]) / DAY,
        elements=len(rows),
        ashore=len(np.unique(land.query(points, predicate="intersects")[0])),
        outline_error=float(np.abs(on_map / area - 1.0).max()),
        sum_error=float(abs(state["area"].values.sum() + water - ocean) / ocean),
        water=water / ocean,
        cells_overlap=float(both[twice].sum() / on_map.sum()),
        crowded=float(beyond.sum() / claims.sum()),
        dealt=float(np.maximum(dealt.claimed - dealt.sea, 0.0).sum() / area.sum()),
        neighbours=float(np.median(neighbours)),
        touching=float(np.median(touching)),
        outlines_on_land=float((dry * area * ice).sum() / (area @ ice)),
        discs_on_land=float((wet * area * ice).sum() / (area @ ice)),
        bonded=float(state["bonded_length"].values[rows].sum()),
        perimeter=float(shapely.length(cells).sum()),
        volume=float(area @ volume.sum(axis=1)),
        ridged_volume=float(piled),
        ridged_area=float(ridged),
        ice_area=float(area @ ice),
    )


def contacts_of(place: Array, radius: Array, area: Array) -> tuple[Array, Array]:
    """How many discs each touches, and the length of that over its outline as a hexagon, (n,)."""
    pairs = cKDTree(place).query_pairs(2.0 * float(radius.max()), output_type="ndarray")
    apart = np.hypot(*(place[pairs[:, 1]] - place[pairs[:, 0]]).T)
    pairs = pairs[apart < radius[pairs].sum(axis=1)]
    both, least = pairs.T.ravel(), radius[pairs].min(axis=1)
    length = np.bincount(both, np.tile(2.0 * EDGE_SHARE * least, 2), len(area))
    count = np.bincount(both, minlength=len(area)).astype(float)
    return count, length / np.sqrt(8.0 * np.sqrt(3.0) * area)


def on_land(outlined: Shapes, land: Shapes) -> Array:
    """Share of each shape that lies on land, (n,)."""
    if not len(land):
        return np.zeros(len(outlined))
    source, _, area, _ = overlap(outlined, land)
    return np.asarray(np.bincount(source, area, len(outlined)) / shapely.area(outlined))
