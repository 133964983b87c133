# SPDX-License-Identifier: GPL-2.0-or-later
"""Replace the elements of a state by fresh ones in the cells of a tessellation.

Elements that drifted off the cells, out of the scene, stay as they are, with ids above those of
all cells. Coast elements stay. One that stands for more sea than its bay has lies on land with most
of its outline, but has not left.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
import xarray as xr
from numpy.typing import NDArray
from scipy import sparse
from scipy.spatial import cKDTree

from floeflow.dynamics.remesh.outline import cut
from floeflow.dynamics.remesh.overlap import Pieces, carried_polygons, covered, make_pieces, overlap
from floeflow.dynamics.remesh.pairs import Ancestry, coast_bonds, fresh_bonds, fresh_contacts
from floeflow.dynamics.remesh.spread import enclosed, join_sparse_cells, spread
from floeflow.dynamics.remesh.tables import (
    corner_rows,
    element_values,
    joined_pairs,
    kept_pairs,
    put_together,
    with_pairs,
    with_walls,
)
from floeflow.dynamics.remesh.transport import is_share, transport, values_of
from floeflow.state.bonds import Arrays
from floeflow.state.cells import Cells, rings_of
from floeflow.state.elements import joint_thickness, pair_arrays
from floeflow.state.schema import COAST, MASS, MOBILE, VARIABLES
from floeflow.state.walls import unsafe

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Index = NDArray[np.int64]

# An element that lies on the cells with less than this share of itself has left them, unless its
# centre is within the rectangle about the cells and no further from a site than so many times the
# radius of a circle of that cell's area: then it is one of a bay or a channel, and lies on land.
LEAST_COVER, NEAR = 0.5, 2.0
# A cell holds more than its area where it is more by this share.
ROUND_OFF = 1.0e-9
# Ice over less than this share of a cell makes no element: making room mixes what goes through
# water of elements whose ice has melted, and would leave a trace of ice in each.
TRACE = 1.0e-4


@dataclass(frozen=True)
class Laid:
    """A state's mobile elements laid on the cells.

    Parameters
    ----------
    rows : ndarray
        Rows in the state of the elements that lie on the cells, (n,).
    guests : ndarray
        Rows of the mobile ones that do not.
    pieces : Pieces
        Overlap of those with the cells.
    centre : ndarray
        Centres of their outlines (m), (n, 2).
    """

    rows: Index
    guests: Index
    pieces: Pieces
    centre: Array


def lay(state: xr.Dataset, cells: Cells) -> Laid:
    """Find what of a state's elements lies on which cells.

    Parameters
    ----------
    state : xarray.Dataset
        A state with outlines (effect ``remap``).
    cells : Cells
        The fresh cells.

    Returns
    -------
    Laid
        Rows on the cells, rows beside them, and the pieces (m2) that both share.
    """
    mobile = np.flatnonzero((state["type"].values == MOBILE) & (state["area"].values > 0))
    place = np.stack([state["x"].values, state["y"].values], axis=1)[mobile]
    area = state["area"].values[mobile]
    start, corner = outlines(state, mobile)
    away, near = cKDTree(np.stack([cells.x, cells.y], axis=1)).query(place)
    on_map = area / cells.scale[near]
    old = carried_polygons(start, corner, place, state["theta"].values[mobile], on_map)
    pairs = overlap(old, cells.polygons)
    on = covered(pairs[0], pairs[2], old) >= LEAST_COVER
    low, high = shapely.total_bounds(cells.polygons).reshape(2, 2)
    inside = ((place >= low) & (place <= high)).all(axis=1)
    on |= inside & (away <= NEAR * np.sqrt(cells.area[near] / np.pi))
    pairs = _with_nearest(pairs, on, near, cells, shapely.area(old))
    chosen = np.flatnonzero(on)
    pieces = make_pieces(pairs, chosen, area[chosen], len(cells.id))
    centre = shapely.get_coordinates(shapely.centroid(old[chosen]))
    return Laid(mobile[chosen], mobile[~on], pieces, centre)


def _with_nearest(
    pairs: tuple[Index, Index, Array, Array], on: Flags, near: Index, cells: Cells, area: Array
) -> tuple[Index, Index, Array, Array]:
    """Pairs with those of elements that lie on land alone, each on the cell of its nearest site."""
    bare = np.setdiff1d(np.flatnonzero(on), pairs[0])
    cell = near[bare]
    site = np.stack([cells.x[cell], cells.y[cell]], axis=1)
    more = (bare, cell, area[bare], site)
    source, target, shared, centre = (
        np.concatenate([each, one]) for each, one in zip(pairs, more, strict=True)
    )
    order = np.lexsort((target, source))
    return source[order], target[order], shared[order], centre[order]


def outlines(state: xr.Dataset, rows: Index) -> tuple[Index, Array]:
    """Open rings in the body frames of some elements: starts and corners (m).

    Parameters
    ----------
    state : xarray.Dataset
        With the corners of the elements.
    rows : Index
        Rows of the elements, (k,).

    Returns
    -------
    tuple of Index and ndarray
        (k + 1,), and (corners, 2).
    """
    count = state["cell_corners"].values
    corner = np.stack([state["corner_x"].values, state["corner_y"].values], axis=1)
    start = np.concatenate([[0], np.cumsum(count[rows])])
    return start.astype(np.int64), corner[corner_rows(count, rows)]


def overlapping(laid: Laid, cells: Cells) -> float:
    """Share of the elements' area by which they overlap: what is too much for the cells.

    Parameters
    ----------
    laid : Laid
        Pieces of elements on cells.
    cells : Cells
        Cells and their areas.

    Returns
    -------
    float
        0 to 1.
    """
    held = np.bincount(laid.pieces.target, weights=laid.pieces.area, minlength=len(cells.id))
    total = float(laid.pieces.area.sum())
    return float(np.maximum(held - cells.area, 0.0).sum()) / total if total > 0 else 0.0


def remap(
    state: xr.Dataset, cells: Cells, laid: Laid, bond_gap: float, slopes: bool = True
) -> xr.Dataset:
    """Fresh elements that hold what the old ones held.

    Parameters
    ----------
    state : xarray.Dataset
        A state with outlines.
    cells : Cells
        The fresh cells.
    laid : Laid
        From `lay`, of the same two.
    bond_gap : float
        As in `packing.bond_gap`.
    slopes : bool
        As in `transport`.

    Returns
    -------
    xarray.Dataset
        Ice and snow volume, ice area and momentum as before, to round-off; effective areas and
        unclaimed water still add up to the ocean's area.
    """
    names = [n for n, rule in VARIABLES.items() if rule.kind and n in state]
    values = {name: state[name].values[laid.rows] for name in names}
    arrived = transport(values, laid.centre, laid.pieces, slopes=slopes)
    beside = cells.neighbours()
    move = spread(arrived["area"], cells.area, cells.ease())
    # What has nothing to be a property of takes the mean over the area that came in, and a hole
    # that of its neighbours.
    share = laid.pieces.matrix()
    fill = {name: move(_product(share.T, values[name])) for name in names if name != "area"}
    arrived = {name: move(amount) for name, amount in arrived.items()}
    # Traces of ice go to the nearest ice and leave their water; then cells that are hardly filled
    # join others.
    goes, part = traces(arrived["area"], arrived["ice_fraction"].sum(axis=1), cells)
    held = _product(goes, part * arrived["area"])
    onto = sparse.csr_matrix(join_sparse_cells(held, cells.area, beside) @ goes)
    onto.sort_indices()
    in_part = sparse.csr_matrix(onto @ sparse.diags(part))
    arrived = {
        name: _product(in_part if _is_of_all_area(name) else onto, amount)
        for name, amount in arrived.items()
    }
    fill = {name: _product(in_part, amount) for name, amount in fill.items()}
    share = sparse.csr_matrix(share @ in_part.T)
    icy = arrived["ice_fraction"].sum(axis=1) > 0
    # Water amid ice is kept, or made, as an element: a lead can freeze. Where an element stays that
    # does not lie on the cells there is none.
    held = icy | (enclosed(icy, beside) & ~_taken(state, cells, laid))
    inside = held & enclosed(held, beside)
    # A round-off above the cell's own area would add up over the windows.
    over = arrived["area"] > (1.0 + ROUND_OFF) * cells.area
    area = np.where(inside & ~over, cells.area, arrived["area"])
    stays = np.flatnonzero(held & (area > 0))
    fill = _means(fill, arrived["area"], held & (arrived["area"] == 0), beside)
    fresh = values_of(
        {name: amount[stays] for name, amount in arrived.items()},
        area[stays],
        {name: mean[stays] for name, mean in fill.items()},
    )
    return _assemble(state, cells, laid, fresh, stays, share, bond_gap)


def _is_of_all_area(name: str) -> bool:
    """Whether an amount is of open water as much as of ice: the area and what lies on all of it."""
    if name == "area":
        return True
    return name != MASS and VARIABLES[name].of == "area" and not is_share(VARIABLES[name])


def traces(area: Array, ice: Array, cells: Cells) -> tuple[sparse.csr_matrix, Array]:
    """Where traces of ice go, to the nearest ice that is more, and what share of its area goes too.

    Parameters
    ----------
    area, ice : ndarray
        What the cells hold, and how much of it is under ice (m2), (m,).
    cells : Cells
        The fresh cells.

    Returns
    -------
    csr_matrix
        (m, m), with which amounts are to be multiplied from the left; its columns add up to 1.
    ndarray
        1; where ice goes elsewhere, the share of the cell's area that it covers.
    """
    count = len(area)
    goes, part = np.arange(count), np.ones(count)
    trace = (ice > 0) & (ice < TRACE * cells.area)
    more = np.flatnonzero((ice > 0) & ~trace)
    if trace.any() and len(more):
        place = np.stack([cells.x, cells.y], axis=1)
        goes[trace] = more[cKDTree(place[more]).query(place[trace])[1]]
        part[trace] = ice[trace] / area[trace]
    moves = (np.ones(count), (goes, np.arange(count)))
    return sparse.csr_matrix(moves, shape=(count, count)), part


def _taken(state: xr.Dataset, cells: Cells, laid: Laid) -> Flags:
    """Cells whose site lies under the disc of a guest."""
    sites = cKDTree(np.stack([cells.x, cells.y], axis=1))
    x, y, radius = (state[name].values[laid.guests] for name in ("x", "y", "radius"))
    under = np.zeros(len(cells.id), dtype=bool)
    for near in sites.query_ball_point(np.stack([x, y], axis=1), radius):
        under[near] = True
    return under


def _product(matrix: sparse.spmatrix, values: Array) -> Array:
    flat = matrix @ values.reshape(len(values), -1)
    return np.asarray(flat).reshape(matrix.shape[0], *values.shape[1:])


def _means(
    total: dict[str, Array], area: Array, holes: Flags, beside: sparse.csr_matrix
) -> dict[str, Array]:
    """Means over the area, and in holes over the neighbours."""
    near = sparse.csr_matrix(beside > 0)[np.flatnonzero(holes)].astype(float)
    count = np.asarray(near.sum(axis=1)).ravel()
    out = {}
    for name, values in total.items():
        shape = (-1,) + (1,) * (values.ndim - 1)
        mean = values / np.where(area > 0, area, 1.0).reshape(shape)
        # A hole's neighbours all hold something, or are holes themselves and count nothing.
        around = _product(near, mean) / count.reshape(shape)
        mean[holes] = around
        out[name] = mean
    return out


def _content_centres(laid: Laid) -> Array:
    pieces = laid.pieces
    total = np.bincount(pieces.target, weights=pieces.area, minlength=pieces.targets)
    moments = [
        np.bincount(pieces.target, weights=pieces.area * at, minlength=pieces.targets)
        for at in (pieces.x, pieces.y)
    ]
    known = np.where(total > 0, total, 1.0)
    return np.stack([np.where(total > 0, m / known, np.nan) for m in moments], axis=1)


def _assemble(
    state: xr.Dataset,
    cells: Cells,
    laid: Laid,
    values: dict[str, Array],
    stays: Index,
    share: sparse.csr_matrix,
    bond_gap: float,
) -> xr.Dataset:
    site = np.stack([cells.x, cells.y], axis=1)[stays]
    middle = _content_centres(laid)[stays]
    middle = np.where(np.isnan(middle), site, middle)
    size = np.sqrt(np.minimum(values["area"] / cells.area[stays], 1.0))
    # A smaller disc stays inside of its cell's disc, so that none overlap.
    off = middle - site
    way = np.maximum(np.hypot(*off.T), 1e-300)
    most = cells.radius[stays]
    place = site + ((1.0 - size) * np.minimum(1.0, most / way))[:, None] * off
    if "wall_face_ax" in state and state.sizes["wall_face"]:
        ashore = unsafe(pair_arrays(state, "wall_face"), site, place, most * size)
        place = np.where(ashore[:, None], site, place)
    polygons = cut(cells.polygons[stays], size**2, middle)
    start, ring = rings_of(polygons)
    corners = np.diff(start)
    made = values | {
        "id": cells.id[stays],
        "type": np.full(len(stays), MOBILE),
        "x": place[:, 0],
        "y": place[:, 1],
        "theta": np.zeros(len(stays)),
        "radius": most * size,
        "cell_corners": corners,
    }
    body = ring - np.repeat(place, corners, axis=0)
    kept = np.append(np.flatnonzero(state["type"].values == COAST), laid.guests)
    old = element_values(state, kept)
    # Guests are numbered above all cells and the coast, in the order that they had.
    first = 1 + max(int(cells.id[-1]), int(old["id"][: -len(laid.guests) or None].max(initial=0)))
    names = first + np.arange(len(laid.guests))
    old["id"][len(kept) - len(names) :] = names
    elements = {name: np.concatenate([made[name], old[name]]) for name in old}
    out = put_together(state, elements, np.concatenate([body, outlines(state, kept)[1]]))
    water = float(state.attrs["unclaimed_water"])
    out.attrs["unclaimed_water"] = water + _total_area(state) - _total_area(out)
    bonds, contacts = _pairs(state, cells, laid, made, stays, share, bond_gap)
    guests = state["id"].values[laid.guests]
    tables = {
        kind: joined_pairs([table, kept_pairs(pair_arrays(state, kind), guests, names)])
        for kind, table in (("bond", bonds), ("contact", contacts))
        if table
    }
    return with_walls(with_pairs(out, tables), state, None)


def _total_area(state: xr.Dataset) -> float:
    return float(state["area"].values.sum())


def _rows_of(state: xr.Dataset, rows: Index) -> Arrays:
    names = ("id", "x", "y", "theta", "radius")
    return {name: state[name].values[rows] for name in names}


def _between(table: Arrays, some: Index, others: Index) -> Arrays:
    """Pairs with one element of each kind."""
    lo, hi = table["id_lo"], table["id_hi"]
    both = np.isin(lo, some) & np.isin(hi, others) | np.isin(lo, others) & np.isin(hi, some)
    return {name: values[both] for name, values in table.items()}


def _pairs(
    state: xr.Dataset,
    cells: Cells,
    laid: Laid,
    made: Arrays,
    stays: Index,
    share: sparse.csr_matrix,
    bond_gap: float,
) -> tuple[Arrays, Arrays]:
    """Bonds and contacts of the fresh elements among themselves; no bonds: an empty dict."""
    total = np.asarray(share.sum(axis=0)).ravel()
    share = sparse.csr_matrix(share @ sparse.diags(1.0 / np.where(total > 0, total, 1.0)))
    old = _rows_of(state, laid.rows)
    old["thickness"] = joint_thickness(state)[laid.rows]
    ancestry = Ancestry(share, old)
    fresh: Arrays = {"id": cells.id, "x": cells.x.copy(), "y": cells.y.copy()}
    fresh |= {name: np.zeros(len(cells.id)) for name in ("theta", "radius", "thickness")}
    for name in ("x", "y", "radius"):
        fresh[name][stays] = made[name]
    fresh["thickness"][stays] = made["ice_volume"].sum(axis=1)
    bonds: Arrays = {}
    bonded = np.zeros(len(cells.lo), dtype=bool)
    if "bond_id_lo" in state:
        before = kept_pairs(pair_arrays(state, "bond"), old["id"], old["id"])
        bonds = fresh_bonds(ancestry, before, fresh, cells, bond_gap)
        base = int(cells.id[-1]) + 1
        sides = cells.id[cells.lo] * base + cells.id[cells.hi]
        bonded = np.isin(sides, bonds["id_lo"] * base + bonds["id_hi"])
        coast = _rows_of(state, np.flatnonzero(state["type"].values == COAST))
        ashore = _between(pair_arrays(state, "bond"), old["id"], coast["id"])
        if len(ashore["id_lo"]):
            bonds = joined_pairs([bonds, coast_bonds(ancestry, ashore, fresh, coast, bond_gap)])
    before = kept_pairs(pair_arrays(state, "contact"), old["id"], old["id"])
    if "ridge_closing" not in before:
        return bonds, {name: values[:0] for name, values in before.items()}
    return bonds, fresh_contacts(ancestry, before, fresh, cells, bonded, bond_gap)
