# SPDX-License-Identifier: GPL-2.0-or-later
"""Where open water freezes: new elements, ice for those around, or frazil that stays in the sea.

The open water of each cell was advanced as a column of its own. If ice formed in it, it becomes new
elements where there is room for them. What freezes between elements joins these, with the water in
which it froze. Too little ice to be either melts back: its heat stays lacking in the sea until
there is enough. Elements whose ice has nearly gone return their water to the sea.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy import sparse
from scipy.spatial import cKDTree

from floeflow.coupling.sea.columns import Columns
from floeflow.coupling.sea.ice import (
    Returned,
    Terms,
    add_terms,
    dissolve,
    join_returned,
    returned_ice,
    with_elements,
)
from floeflow.coupling.sea.places import SeaPlaces
from floeflow.coupling.sea.shares import Shares, build_shares
from floeflow.coupling.sea.water import Water
from floeflow.dynamics.remesh.absorb import ALONE, used_up_alone
from floeflow.dynamics.remesh.tables import element_values
from floeflow.dynamics.remesh.transport import amounts, values_of
from floeflow.state.schema import MOBILE, VARIABLES

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Flags = NDArray[np.bool_]

# Ice that covers less of the open water than this stays frazil in the sea (the concentration from
# which on observers speak of ice).
LEAST_COVER = 0.15
# Discs of a packing fill this share of the area (`floeflow.packings.discs.FILL`).
FILL = 0.84
# New elements are made of at least this share of a typical one's area, or of their cell's sea, and
# their discs have at least this share of the radius that their area asks for.
LEAST_SIZE, LEAST_RADIUS = 0.5, 0.35
# An element takes water beside it up to this many times the area that its disc stands for, or that
# of a typical one: discs kept off a coast are small for the ice that they carry.
MOST_AREA = 2.0
# Ice in a cell without elements joins the nearest one, up to so many grid spacings away.
FARTHEST = 4.0
# Elements with less than this share or volume of ice dissolve.
GONE_FRACTION, GONE_VOLUME = 0.01, 2e-3


@dataclass(frozen=True)
class OpenIce:
    """Ice that formed in the open water of cells.

    Parameters
    ----------
    cells : ndarray
        Flat index of the grid's cells, (k,).
    area : ndarray
        Of their open water (m2), (k,).
    columns : dict of ndarray
        Its columns, (k, ...).
    shares : Shares
        Of the mobile elements.
    terms : dict of ndarray
        Terms of the budgets over that water as the columns were advanced, (k,); of all cells
        alone, not of some.
    """

    cells: Index
    area: Array
    columns: Columns
    shares: Shares
    terms: Columns = field(default_factory=dict)

    def some(self, rows: Index | Flags) -> OpenIce:
        """Ice of some of the cells.

        Parameters
        ----------
        rows : ndarray or ndarray
            Of the cells, (k,).
        """
        columns = {name: value[rows] for name, value in self.columns.items()}
        return OpenIce(self.cells[rows], self.area[rows], columns, self.shares)

    def matrix(self, count: int) -> sparse.csr_array:
        """Cells of the rows, (k, count).

        Parameters
        ----------
        count : int
            Number of cells of the sea.
        """
        k = len(self.cells)
        return sparse.csr_array((np.ones(k), (np.arange(k), self.cells)), shape=(k, count))


def icy(found: OpenIce) -> OpenIce:
    """The cells in which there is any ice.

    Parameters
    ----------
    found : OpenIce
        New ice by cell.
    """
    return found.some(found.columns["ice_volume"].sum(axis=1) > 0.0)


def melt_back(water: Water, found: OpenIce, places: SeaPlaces) -> tuple[Water, Terms, Returned]:
    """Return ice that formed in open water to the sea.

    Parameters
    ----------
    water : Water
        The sea, (cells,).
    found : OpenIce
        Columns of open water, and the ice that formed in them.
    places : SeaPlaces
        Grid of the sea.

    Returns
    -------
    tuple of Water, Terms and Returned
        The sea, the terms of its budgets (J, kg, m2, m3), summed, and what went back where.
    """
    water, terms = dissolve(water, found.columns, found.area, found.matrix(water.area.size))
    x, y = (axis[found.cells] for axis in places.grid.places())
    back = returned_ice((x, y), found.columns, found.area, True)
    return water, terms | {"sea_melted_back": float(back.volume.sum())}, back


def settle_ice(
    state: xr.Dataset,
    water: Water,
    found: OpenIce,
    places: SeaPlaces,
    ridging: bool = False,
) -> tuple[xr.Dataset, Water, Terms, Returned]:
    """Make elements of the ice in open water, give it to others, or melt it back.

    Parameters
    ----------
    state : xarray.Dataset
        After the columns of the window; with the attribute ``typical_area`` (m2).
    water : Water
        The sea after the columns.
    found : OpenIce
        From the columns of open water.
    places : SeaPlaces
        The sea of the scene.
    ridging : bool
        Elements may be used up by ridges; those that no other is near go back to the sea.

    Returns
    -------
    tuple of xarray.Dataset, Water, dict and Returned
        State and sea, and the terms of the budgets, with ``sea_born`` and ``sea_gone``: how many
        elements there are more and fewer; and what melted back, by places.
    """
    found = icy(found)
    enough = found.columns["ice_fraction"].sum(axis=1) >= LEAST_COVER
    water, terms, thin = melt_back(water, found.some(~enough), places)
    found = found.some(enough)
    mobile = np.flatnonzero(state["type"].values == MOBILE)
    made, left = _new_elements(state, found, places)
    count = len(made["x"])
    if count:
        # Their ids are the highest, so that the rows of the others stay.
        state = with_elements(state, np.arange(state.sizes["element"]), made)
    state, left, joined = _join(state, left, mobile, places)
    water, more, rest = melt_back(water, left, places)
    state, water, gone, old = remove_melted(state, water, places, ridging)
    new = {"sea_born": float(count), "sea_joined": joined}
    return state, water, add_terms(terms, more, gone, new), join_returned([thin, rest, old])


def _beside(
    state: xr.Dataset, found: OpenIce, mobile: Index, places: SeaPlaces
) -> sparse.csr_array:
    """Shares of the elements in the cells of open ice, (n, k).

    A cell in which no element has a share, such as the head of a fjord, is its nearest element's.
    """
    shared = sparse.csr_array(found.shares.matrix[:, found.cells])
    bare = np.flatnonzero(np.asarray(shared.sum(axis=0)).ravel() <= 0.0)
    x, y = (axis[found.cells[bare]] for axis in places.grid.places())
    tree = cKDTree(np.stack([state[axis].values[mobile] for axis in "xy"], axis=1))
    away, nearest = tree.query(np.stack([x, y], axis=1))
    close = away < FARTHEST * max(places.grid.spacing)
    pairs = nearest[close], bare[close]
    extra = sparse.csr_array((np.ones(len(pairs[0])), pairs), shape=shared.shape)
    return sparse.csr_array(shared + extra)


def _join(
    state: xr.Dataset, found: OpenIce, mobile: Index, places: SeaPlaces
) -> tuple[xr.Dataset, OpenIce, float]:
    """Give ice for which no new element has room to those beside it, with its water.

    Returns
    -------
    tuple of xarray.Dataset, OpenIce and float
        State, the ice that is left over, and the water that the elements took (m2).
    """
    if not (len(mobile) and len(found.cells)):
        return state, found, 0.0
    area, radius = state["area"].values[mobile], state["radius"].values[mobile]
    size = np.maximum(np.pi * radius**2 / FILL, float(state.attrs["typical_area"]))
    room = np.maximum(MOST_AREA * size - area, 0.0)
    near = _beside(state, found, mobile, places)  # (n, k)
    wish = sparse.csr_array(near * area[:, None])
    held = np.asarray(wish.sum(axis=0)).ravel()
    per = np.divide(found.area, held, out=np.zeros_like(held), where=held > 0.0)
    wish = sparse.csr_array(wish * per[None, :])  # m2 of each cell's water
    asked = np.asarray(wish.sum(axis=1)).ravel()
    part = np.minimum(np.divide(room, asked, out=np.ones_like(room), where=asked > 0.0), 1.0)
    # Where elements overlap by the shares, other cells seem open: no more water is given than is
    # no element's.
    whole, there = float(asked @ part), max(float(state.attrs["unclaimed_water"]), 0.0)
    part = part * min(1.0, there / whole) if whole > 0.0 else part
    given = sparse.csr_array(wish * part[:, None])
    taken = np.asarray(given.sum(axis=0)).ravel()
    old = element_values(state, mobile)
    kinds = {name: value for name, value in old.items() if VARIABLES[name].kind}
    ice = _as_elements(found, kinds)
    share = sparse.csr_array(given * np.divide(1.0, ice["area"])[None, :])
    own, new = amounts(kinds), amounts(ice)
    both = {name: own[name] + _spread(share, new[name]) for name in own}
    # What there is nothing of to be a property of stays as it is.
    values = values_of(both, both["area"], kinds)
    grows = asked * part > 0.0
    changed = {}
    for name, value in values.items():
        column = state[name].values.copy()
        column[mobile[grows]] = value[grows]
        changed[name] = (state[name].dims, column)
    state = state.assign(changed)
    water = float(taken.sum())
    state.attrs["unclaimed_water"] = float(state.attrs["unclaimed_water"]) - water
    rest = np.maximum(found.area - taken, 0.0)
    left = OpenIce(found.cells, rest, found.columns, found.shares)
    return state, left.some(rest > 0.0), water


def _spread(share: sparse.csr_array, amount: Array) -> Array:
    flat = np.asarray(share @ amount.reshape(len(amount), -1))
    return flat.reshape(share.shape[0], *amount.shape[1:])


def _as_elements(found: OpenIce, like: Mapping[str, Array]) -> dict[str, Array]:
    """Element variables of ice in open water, at rest."""
    count = len(found.cells)
    values = {name: np.zeros((count, *value.shape[1:])) for name, value in like.items()}
    values |= {name: value for name, value in found.columns.items() if name in values}
    values["area"] = found.area
    return values


def _new_elements(
    state: xr.Dataset, found: OpenIce, places: SeaPlaces
) -> tuple[dict[str, Array], OpenIce]:
    """New elements of ice in open water, and the ice for which there was no room."""
    typical = float(state.attrs["typical_area"])
    sea = found.shares.sea[found.cells]
    wide = found.area >= np.maximum(LEAST_SIZE * np.minimum(typical, sea), ALONE * typical)
    asked = np.where(wide, np.maximum(np.round(found.area / typical), 1.0), 0.0).astype(np.int64)
    each = found.area / np.maximum(asked, 1)
    discs = np.stack([state[name].values for name in ("x", "y", "radius")], axis=1)
    x, y, radius, row = place_discs(places, discs, found.cells, asked, each)
    like = element_values(state, np.zeros(0, dtype=np.int64))
    new = _as_elements(found.some(row), like)
    new |= {"x": x, "y": y, "radius": radius, "area": each[row]}
    new["type"] = np.full(len(x), MOBILE)
    left = found.area - np.bincount(row, each[row], len(found.cells))
    rest = OpenIce(found.cells, np.maximum(left, 0.0), found.columns, found.shares)
    return new, rest.some(left > 1e-9 * found.area)


def place_discs(
    places: SeaPlaces,
    discs: Array,
    cells: Index,
    asked: Index,
    area: Array,
    least: float = LEAST_RADIUS,
) -> tuple[Array, Array, Array, Index]:
    """Places for new discs that meet no other disc and no land.

    Parameters
    ----------
    places : SeaPlaces
        Where discs may be.
    discs : ndarray
        x, y and radius of those that are there (m), (n, 3).
    cells : ndarray
        Flat index of the grid's cells, (k,).
    asked : ndarray
        How many in each, (k,).
    area : ndarray
        For which each stands (m2), (k,).
    least : float
        Share of the radius that this area asks for under which no disc is placed.

    Returns
    -------
    tuple of ndarray
        x, y, radius (m) and the row of the cell of each new disc.
    """
    taken: list[tuple[float, float, float, int]] = []
    wanted = np.flatnonzero(asked > 0)
    row_of = np.full(places.area.size, -1)
    row_of[cells[wanted]] = wanted
    some = np.flatnonzero(row_of[places.cell] >= 0)
    if not len(some):
        none = np.empty(0)
        return none, none, none, np.empty(0, dtype=np.int64)
    spots = np.stack([places.x[some], places.y[some]], axis=1)
    room = places.shore[some].copy()
    if len(discs):
        # The disc that is nearest by its edge is among the nearest by their centres, or else is so
        # large that it covers them.
        tree = cKDTree(discs[:, :2])
        apart, which = tree.query(spots, k=min(12, len(discs)))
        apart, which = apart.reshape(len(spots), -1), which.reshape(len(spots), -1)
        room = np.minimum(room, (apart - discs[which, 2]).min(axis=1))
    at = row_of[places.cell[some]]
    order = np.argsort(at, kind="stable")
    starts = np.searchsorted(at[order], np.arange(len(cells) + 1))
    for row in wanted.tolist():
        mine = order[starts[row] : starts[row + 1]]
        target = float(np.sqrt(FILL * area[row] / np.pi))
        for _ in range(int(asked[row])):
            if not len(mine):
                break
            best = mine[int(np.argmax(room[mine]))]
            if room[best] < least * target:
                break
            size = min(target, float(room[best]))
            taken.append((float(spots[best, 0]), float(spots[best, 1]), size, row))
            away = np.hypot(*(spots - spots[best]).T)
            room = np.minimum(room, away - size)
    table = np.array(taken, dtype=np.float64).reshape(-1, 4)
    return table[:, 0], table[:, 1], table[:, 2], table[:, 3].astype(np.int64)


def remove_melted(
    state: xr.Dataset, water: Water, places: SeaPlaces, ridging: bool = False
) -> tuple[xr.Dataset, Water, Terms, Returned]:
    """Return elements whose ice has nearly gone to the sea, with their water.

    Parameters
    ----------
    state : xarray.Dataset
        Elements before.
    water : Water
        The sea, (cells,).
    places : SeaPlaces
        Grid of the sea.
    ridging : bool
        As in `settle_ice`.

    Returns
    -------
    tuple of xarray.Dataset, Water, Terms and Returned
        The elements that are left, the sea, terms of its budgets (``sea_gone`` counts the
        elements), and what went back where.
    """
    fraction, volume = (state[f"ice_{name}"].values.sum(axis=1) for name in ("fraction", "volume"))
    mobile = state["type"].values == MOBILE
    gone = np.flatnonzero(mobile & ((fraction < GONE_FRACTION) | (volume < GONE_VOLUME)))
    if ridging:
        gone = np.union1d(gone, used_up_alone(state))
    x, y, area = (state[name].values[gone] for name in ("x", "y", "area"))
    columns = element_values(state, gone)
    old = returned_ice((x, y), columns, area, False)
    if not len(gone):
        return state, water, {"sea_gone": 0.0}, old
    shares = build_shares(x, y, area, places.grid, places.area, places.pull)
    water, terms = dissolve(water, columns, area, shares.matrix)
    keep = np.setdiff1d(np.arange(state.sizes["element"]), gone)
    none = {name: np.empty(0) for name in ("x", "y", "area")}
    return with_elements(state, keep, none), water, terms | {"sea_gone": float(len(gone))}, old
