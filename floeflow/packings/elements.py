# SPDX-License-Identifier: GPL-2.0-or-later
"""What every generator makes: elements with their cells and edges, and the dataset of them."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import shapely
import xarray as xr
from numpy.typing import NDArray

from floeflow.core.grids import Grid
from floeflow.core.period import ATTRIBUTE
from floeflow.packings import points
from floeflow.packings.coastline import coastline
from floeflow.state.schema import COAST, MOBILE

Array = NDArray[np.float64]
Index = NDArray[np.int64]

# Unclaimed water below this share of the ocean is the round-off of a sum.
ROUND_OFF = 1.0e-12


@dataclass(frozen=True)
class Elements:
    """What a generator makes: discs, and areas, ice, cells and edges of the mobile ones.

    Parameters
    ----------
    places, radius : ndarray
        Discs (m), mobile ones first, then those of the coast, (n + k, 2) and (n + k,).
    area : ndarray
        Effective areas (m2 on the earth), (n,).
    ice_fraction, ice_volume : ndarray
        Share of the area under ice, and ice volume per area (m), (n,).
    polygons : ndarray of shapely.Polygon
        Clipped cells, (n,).
    lo, hi, ends : ndarray
        Shared edges as in `tessellation.Diagram`.
    correction : float
        As in `tessellation.Overlay`.
    floe : ndarray, optional
        Number of each mobile element's floe, (n,).
    concentration : ndarray, optional
        Ice concentration of the mask about each mobile element, (n,), where its own is another.
    size_ratio : ndarray, optional
        Size of each mobile element's cell over that which the size function asks for, (n,).
    figures : dict
        What the generator itself knows of the quality, by the names of `quality.LABELS`.
    """

    places: Array
    radius: Array
    area: Array
    ice_fraction: Array
    ice_volume: Array
    polygons: NDArray[np.object_]
    lo: Index
    hi: Index
    ends: Array
    correction: float
    floe: Index | None = None
    concentration: Array | None = None
    size_ratio: Array | None = None
    figures: dict[str, float] = field(default_factory=dict)

    @property
    def count(self) -> int:
        """How many are mobile."""
        return len(self.area)


def no_elements() -> Elements:
    """Those of a mask without ice."""
    none, index = np.empty(0), np.empty(0, dtype=np.int64)
    polygons = np.empty(0, dtype=object)
    ends = np.empty((0, 2, 2))
    return Elements(
        np.empty((0, 2)), none, none, none, none, polygons, index, index, ends, correction=0.0
    )


def grid_of(mask: xr.Dataset) -> Grid:
    """The mask's grid.

    Parameters
    ----------
    mask : xarray.Dataset
        On ``y`` and ``x``.

    Returns
    -------
    Grid
        Centres of the cells, spacing and lower left corner (m).
    """
    x, y = mask["x"].values, mask["y"].values
    spacing = float(x[1] - x[0])
    return Grid(x, y, spacing, float(x[0]) - 0.5 * spacing, float(y[0]) - 0.5 * spacing)


def ordered(grid: Grid, places: Array) -> Array:
    """Points in the order of a Hilbert curve, so that neighbours are near in memory.

    Parameters
    ----------
    grid : Grid
        Rectangle that the curve fills.
    places : ndarray
        m, (n, 2).

    Returns
    -------
    ndarray
        The same points.
    """
    return places[hilbert_order(grid, places)]


def hilbert_order(grid: Grid, places: Array) -> Index:
    """Rows of points in the order of a Hilbert curve.

    Parameters
    ----------
    grid : Grid
        Rectangle that the curve fills.
    places : ndarray
        m, (n, 2).

    Returns
    -------
    Index
        (n,).
    """
    side = grid.spacing * max(grid.shape)
    key = points.hilbert_key(places[:, 0], places[:, 1], grid.x_min, grid.y_min, side)
    return np.argsort(key, kind="stable")


def _rings(polygons: NDArray[np.object_], count: int) -> tuple[Index, Array]:
    """Starts and vertices of open rings, without repeated vertices; none for coast elements."""
    xy, of = shapely.get_coordinates(polygons, return_index=True)
    if len(xy):
        last = np.append(of[1:] != of[:-1], True)
        again = np.append(np.all(xy[1:] == xy[:-1], axis=1) & (of[1:] == of[:-1]), False)
        keep = ~(last | again)
        xy, of = xy[keep], of[keep]
    start = np.searchsorted(of, np.arange(count + 1))
    return start.astype(np.int64), xy


def packing_dataset(mask: xr.Dataset, elements: Elements) -> xr.Dataset:
    """Elements sorted by id, mobile ones first; see docs/theory/packing.md.

    Parameters
    ----------
    mask : xarray.Dataset
        Whose ocean is claimed by the elements.
    elements : Elements
        Places, discs and cells.

    Returns
    -------
    xarray.Dataset
        SI units; polygons as rings.
    """
    count, mobile = len(elements.radius), elements.count

    def padded(values: Array) -> Array:
        return np.concatenate([values, np.zeros(count - mobile)])

    ocean = float(mask["cell_area"].values[mask["land"].values == 0].sum())
    unclaimed = ocean - float(elements.area.sum())
    start, ring = _rings(elements.polygons, count)
    coast_start, coast_ring = coastline(grid_of(mask), mask["land"].values > 0)
    data: dict[str, NDArray[Any]] = {
        "id": np.arange(1, count + 1, dtype=np.int64),
        "type": np.where(np.arange(count) < mobile, MOBILE, COAST).astype(np.int8),
        "x": elements.places[:, 0],
        "y": elements.places[:, 1],
        "radius": elements.radius,
        "area": padded(elements.area),
    }
    if elements.floe is not None:
        coast = np.zeros(count - mobile, dtype=np.int64)
        data["floe"] = np.concatenate([elements.floe, coast])
    if elements.concentration is not None:
        data["concentration"] = padded(elements.concentration)
    if elements.size_ratio is not None:
        data["size_ratio"] = padded(elements.size_ratio)
    columns = {
        "ice_fraction": padded(elements.ice_fraction)[:, None],
        "ice_volume": padded(elements.ice_volume)[:, None],
    }
    edges: dict[str, NDArray[Any]] = {"edge_lo": elements.lo + 1, "edge_hi": elements.hi + 1}
    for k, end in enumerate("ab"):
        edges |= {f"edge_{end}x": elements.ends[:, k, 0], f"edge_{end}y": elements.ends[:, k, 1]}
    attrs = {
        "crs": mask.attrs["crs"],
        "ocean_area": ocean,
        "unclaimed_water": unclaimed if abs(unclaimed) > ROUND_OFF * ocean else 0.0,
        "overlay_correction": elements.correction,
    }
    if ATTRIBUTE in mask.attrs:
        attrs[ATTRIBUTE] = mask.attrs[ATTRIBUTE]
    return xr.Dataset(
        {name: ("element", values) for name, values in data.items()}
        | {name: (("element", "category"), values) for name, values in columns.items()}
        | {"cell_start": ("element_bound", start)}
        | {"cell_x": ("vertex", ring[:, 0]), "cell_y": ("vertex", ring[:, 1])}
        | {name: ("edge", values) for name, values in edges.items()}
        | {"coast_start": ("coast_bound", coast_start)}
        | {f"coast_{a}": ("coast_corner", coast_ring[:, k]) for k, a in enumerate("xy")},
        attrs=attrs,
    )
