# SPDX-License-Identifier: GPL-2.0-or-later
"""Let elements that became too small join their largest neighbour.

The merged element stands at their common centre of mass and keeps their areas, amounts, momentum
and angular momentum. Bonds and contacts to others pass to it as they are in space.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy import sparse
from scipy.spatial import cKDTree

from floeflow.dynamics.remesh.tables import (
    corner_rows,
    element_values,
    put_together,
    with_pairs,
    with_walls,
)
from floeflow.dynamics.remesh.transport import amounts, values_of
from floeflow.dynamics.ridging.ridging import contact_share
from floeflow.state.bonds import Arrays, element_rows
from floeflow.state.elements import joint_thickness, pair_arrays
from floeflow.state.schema import MASS, MOBILE, VARIABLES
from floeflow.state.walls import unsafe

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Flags = NDArray[np.bool_]

# Gap between the discs of two neighbours, as a share of the sum of their radii.
WIDEST_GAP = 0.5


def merge_targets(state: xr.Dataset, share: float) -> Index:
    """Row that each element becomes part of; its own where it stays, (n,).

    Parameters
    ----------
    state : xarray.Dataset
        The state.
    share : float
        Elements with a radius under this share of the mean of the mobile ones are too small.
        Each joins its neighbour of the largest area, if that is larger than its own.

    Returns
    -------
    ndarray
        Rows of integers, (n,); no row leads to one that itself joins another.
    """
    radius, area = state["radius"].values, state["area"].values
    mobile = np.flatnonzero(state["type"].values == MOBILE)
    into = np.arange(len(radius))
    if len(mobile) < 2:
        return into
    small = mobile[radius[mobile] < share * radius[mobile].mean()]
    places = np.stack([state["x"].values, state["y"].values], axis=1)
    most = (1.0 + WIDEST_GAP) * (radius[mobile].max() + radius[small].max(initial=0.0))
    near = cKDTree(places[mobile]).query_ball_point(places[small], most, return_sorted=True)
    for row, around in zip(small.tolist(), near, strict=True):
        others = mobile[around]
        apart = np.hypot(*(places[others] - places[row]).T)
        reach = (1.0 + WIDEST_GAP) * (radius[others] + radius[row])
        others = others[(apart < reach) & (area[others] > area[row])]
        if len(others):
            into[row] = others[np.argmax(area[others])]
    return into_roots(into)


def into_roots(into: Index) -> Index:
    """Rows of the elements in which chains of joining elements end, (n,).

    Parameters
    ----------
    into : ndarray
        Row of the element that each joins, its own where it stays, (n,).

    Returns
    -------
    ndarray
        Rows of elements that stay, (n,).
    """
    while not np.array_equal(into, into[into]):
        into = into[into]
    return into


def merge(state: xr.Dataset, into: Index) -> xr.Dataset:
    """Join elements.

    Parameters
    ----------
    state : xarray.Dataset
        A state. Where it has outlines, a merged element takes that of its largest part, which
        is scaled to its area wherever it is used.
    into : ndarray
        From `merge_targets`.

    Returns
    -------
    xarray.Dataset
        Area, ice, snow, momentum and angular momentum as before, to round-off; orientation and
        id of a merged element are those of its largest part.
    """
    roots, group = np.unique(into, return_inverse=True)
    joins = np.bincount(group) > 1
    if not joins.any():
        return state
    count, n = len(roots), len(into)
    add = sparse.csr_matrix((np.ones(n), (group, np.arange(n))), shape=(count, n))
    old = element_values(state, np.arange(n))
    new = {name: values[roots] for name, values in old.items()}
    _add_up(new, old, add, joins)
    _place(new, old, add, group, joins)
    _stay_at_sea(state, new, roots)
    out = put_together(state, new, _outlines(state, roots))
    tables = {}
    if "bond_id_lo" in state:
        bonds = _moved_bonds(pair_arrays(state, "bond"), old, new, group)
        whole = bonds["length"] * bonds["thickness"] * (1 - bonds["crack_a"] - bonds["crack_b"])
        tables["bond"] = _one_per_pair(bonds, whole)
    for elements, made in ((old, state), (new, out)):
        elements["thickness"] = joint_thickness(made)
    tables["contact"] = _moved_contacts(pair_arrays(state, "contact"), old, new, group)
    if "bond" in tables:
        apart = ~_same_pairs(tables["contact"], tables["bond"])
        tables["contact"] = {name: v[apart] for name, v in tables["contact"].items()}
    return with_walls(with_pairs(out, tables), state, state["id"].values[into])


def _outlines(state: xr.Dataset, rows: Index) -> Array | None:
    """Corners of the outlines of some elements in their body frames (m), (c, 2), or none."""
    if "cell_corners" not in state:
        return None
    corners = np.stack([state["corner_x"].values, state["corner_y"].values], axis=1)
    return corners[corner_rows(state["cell_corners"].values, rows)]


def _dot(add: sparse.csr_matrix, values: Array) -> Array:
    summed = add @ values.reshape(len(values), -1)
    return np.asarray(summed).reshape(add.shape[0], *values.shape[1:])


def _add_up(new: Arrays, old: Arrays, add: sparse.csr_matrix, joins: Flags) -> None:
    named = {name: values for name, values in old.items() if VARIABLES[name].kind}
    held = {name: _dot(add, amount) for name, amount in amounts(named).items()}
    # What has nothing to be a property of takes the mean over the area.
    area = np.where(held["area"] > 0, held["area"], 1.0)
    fill = {
        name: _dot(add, v * _like(old["area"], v)) / _like(area, v) for name, v in named.items()
    }
    for name, values in values_of(held, held["area"], fill).items():
        new[name][joins] = values[joins]


def _like(values: Array, other: Array) -> Array:
    return values.reshape((-1,) + (1,) * (other.ndim - 1))


def _place(new: Arrays, old: Arrays, add: sparse.csr_matrix, group: Index, joins: Flags) -> None:
    """Centre, radius and spin of the merged elements."""
    mass = amounts({name: v for name, v in old.items() if VARIABLES[name].kind})[MASS]
    # Parts of groups without mass weigh by their area.
    weight = np.where((add @ mass)[group] > 0, mass, old["area"])
    held = np.where(joins, add @ weight, 1.0)
    first = old["area"][element_rows(old["id"], new["id"])]
    radius = new["radius"] * np.sqrt(
        np.where(joins, new["area"], 1.0) / np.where(joins, first, 1.0)
    )
    centre = {axis: (add @ (weight * old[axis])) / held for axis in ("x", "y")}
    rx, ry = (old[axis] - centre[axis][group] for axis in ("x", "y"))
    spin = 0.5 * weight * old["radius"] ** 2 * old["omega"]
    turning = add @ (weight * (rx * old["v"] - ry * old["u"]) + spin)
    omega = turning / np.where(joins, 0.5 * held * radius**2, 1.0)
    for name, values in (*centre.items(), ("radius", radius), ("omega", omega)):
        new[name][joins] = values[joins]


def _stay_at_sea(state: xr.Dataset, new: Arrays, roots: Index) -> None:
    """Merged elements whose centre would lie behind a coast stand where their largest part did."""
    if "wall_face_ax" not in state or state.sizes["wall_face"] == 0:
        return
    first = np.column_stack([state["x"].values, state["y"].values])[roots]
    moved, faces = np.column_stack([new["x"], new["y"]]), pair_arrays(state, "wall_face")
    there = unsafe(faces, first, moved, new["radius"])
    for axis, values in zip("xy", first.T, strict=True):
        new[axis][there] = values[there]


def _moved_bonds(bonds: Arrays, old: Arrays, new: Arrays, group: Index) -> Arrays:
    """Bonds in the frames of the merged elements, their lines unmoved in space."""
    out = dict(bonds)
    rows = {}
    for side in ("lo", "hi"):
        row = element_rows(old["id"], bonds[f"id_{side}"])
        rows[side] = group[row]
        for end in "ab":
            ax, ay = bonds[f"{side}_{end}x"], bonds[f"{side}_{end}y"]
            cos, sin = np.cos(old["theta"][row]), np.sin(old["theta"][row])
            moved = new["x"][group[row]] - old["x"][row], new["y"][group[row]] - old["y"][row]
            px, py = cos * ax - sin * ay - moved[0], sin * ax + cos * ay - moved[1]
            turned = new["theta"][group[row]]
            same = (moved[0] == 0) & (moved[1] == 0) & (turned == old["theta"][row])
            cos, sin = np.cos(turned), np.sin(turned)
            out[f"{side}_{end}x"] = np.where(same, ax, cos * px + sin * py)
            out[f"{side}_{end}y"] = np.where(same, ay, cos * py - sin * px)
    return _in_order(out, rows["lo"], rows["hi"], new["id"])


# Columns that change places where the ids of a bond do.
_SWAPPED = (("crack_a", "crack_b"),) + tuple(
    (f"lo_{end}{axis}", f"hi_{other}{axis}") for end, other in ("ab", "ba") for axis in "xy"
)


def _in_order(pairs: Arrays, lo: Index, hi: Index, ids: Index) -> Arrays:
    """Pairs under new ids, lower first; those within one element are gone."""
    flip = lo > hi
    out = dict(pairs)
    for a, b in _SWAPPED:
        if a in out:
            out[a], out[b] = np.where(flip, out[b], out[a]), np.where(flip, out[a], out[b])
    out["id_lo"], out["id_hi"] = ids[np.minimum(lo, hi)], ids[np.maximum(lo, hi)]
    return {name: values[lo != hi] for name, values in out.items()}


def _one_per_pair(pairs: Arrays, strength: Array) -> Arrays:
    """The strongest of the pairs that have become one, sorted."""
    order = np.lexsort((-strength, pairs["id_hi"], pairs["id_lo"]))
    lo, hi = pairs["id_lo"][order], pairs["id_hi"][order]
    first = np.append(True, (np.diff(lo) != 0) | (np.diff(hi) != 0))[: len(lo)]
    return {name: values[order[first]] for name, values in pairs.items()}


def _moved_contacts(contacts: Arrays, old: Arrays, new: Arrays, group: Index) -> Arrays:
    """Contacts of the merged elements with the force that they had."""

    def overlap(elements: Arrays, lo: Index, hi: Index) -> Array:
        dx, dy = (elements[axis][hi] - elements[axis][lo] for axis in ("x", "y"))
        return np.asarray(elements["radius"][lo] + elements["radius"][hi] - np.hypot(dx, dy))

    lo, hi = (element_rows(old["id"], contacts[f"id_{end}"]) for end in ("lo", "hi"))
    elastic = overlap(old, lo, hi) - contacts["rest_overlap"]
    # Where nothing has changed, not even a round-off does.
    rest = contacts["rest_overlap"] + (overlap(new, group[lo], group[hi]) - overlap(old, lo, hi))
    apart = group[lo] != group[hi]
    # Thicker ice is stiffer: less overlap holds the same force.
    now = contact_share(new, group[lo], group[hi])
    softer = np.divide(contact_share(old, lo, hi), now, out=np.ones_like(now), where=now > 0)
    rest = rest + np.where(apart & (elastic > 0), elastic * (1.0 - softer), 0.0)
    held = {"rest_overlap": rest, "slip": contacts["slip"] * softer, "_": elastic}
    out = _in_order(contacts | held, group[lo], group[hi], new["id"])
    elastic = out.pop("_")
    out = _one_per_pair(out | {"_": elastic}, elastic)
    elastic = out.pop("_")
    if "ridge_closing" in contacts:
        return out
    # Only ridges reach across a gap.
    rows = [element_rows(new["id"], out[f"id_{end}"]) for end in ("lo", "hi")]
    touching = overlap(new, *rows) > 0
    return {name: values[touching] for name, values in out.items()}


def _same_pairs(pairs: Arrays, others: Arrays) -> Flags:
    base = 1 + max(int(t["id_hi"].max(initial=0)) for t in (pairs, others))
    return np.isin(pairs["id_lo"] * base + pairs["id_hi"], others["id_lo"] * base + others["id_hi"])
