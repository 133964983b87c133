# SPDX-License-Identifier: GPL-2.0-or-later
"""Put a state together from some of its old elements and new ones."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from floeflow.state.bonds import Arrays, element_rows
from floeflow.state.elements import pair_arrays, with_tables
from floeflow.state.schema import COAST, VARIABLES
from floeflow.state.walls import distances, overlapping

Array = NDArray[np.float64]
Index = NDArray[np.int64]


def element_values(state: xr.Dataset, rows: Index) -> Arrays:
    """All element variables of some rows, by name.

    Parameters
    ----------
    state : xarray.Dataset
        With n elements.
    rows : Index
        Rows of the elements, (k,).

    Returns
    -------
    Arrays
        (k, ...) each.
    """
    return {
        str(name): state[name].values[rows]
        for name in state.data_vars
        if VARIABLES[str(name)].dims[0] == "element"
    }


def corner_rows(count: Index, rows: Index) -> Index:
    """Rows of the corners of some elements, element after element, from all elements' counts.

    Parameters
    ----------
    count : Index
        Number of corners of each element, (n,).
    rows : Index
        Rows of the elements, (k,).

    Returns
    -------
    Index
        (corners,).
    """
    first = np.concatenate([[0], np.cumsum(count)])
    mine = count[rows]
    start = np.concatenate([[0], np.cumsum(mine)])
    return np.asarray(np.repeat(first[rows] - start[:-1], mine) + np.arange(start[-1]))


def put_together(state: xr.Dataset, elements: Arrays, corners: Array | None) -> xr.Dataset:
    """State with these elements, sorted by id, and no pairs.

    Parameters
    ----------
    state : xarray.Dataset
        Gives the variables and the attributes.
    elements : dict of ndarray
        All its element variables.
    corners : ndarray or None
        Corners of the outlines (m), (c, 2), in the elements' order; None: it has no outlines.

    Returns
    -------
    xarray.Dataset
        With the sea and the attributes of the given one.
    """
    order = np.argsort(elements["id"], kind="stable")
    data = {}
    for name, values in elements.items():
        rule = VARIABLES[name]
        data[name] = (rule.dims, values[order].astype(rule.dtype, copy=False))
    if corners is not None:
        place = corner_rows(elements["cell_corners"], order)
        for k, axis in enumerate("xy"):
            data[f"corner_{axis}"] = (("corner",), corners[place, k])
    # The sea lies on a grid of its own and is the same for any elements.
    for name, rule in VARIABLES.items():
        if rule.dims[0] == "sea_y" and name in state:
            data[name] = (rule.dims, state[name].values)
    return xr.Dataset(data, attrs=dict(state.attrs))


def kept_pairs(table: Arrays, ids: Index, names: Index) -> Arrays:
    """Pairs whose elements both have these ids, which are renamed in the same order.

    Parameters
    ----------
    table : Arrays
        Pairs, with ``id_lo`` and ``id_hi``.
    ids : Index
        Ids of the elements that stay, ascending, (n,).
    names : Index
        Their new ids, (n,).

    Returns
    -------
    Arrays
        A new table.
    """
    ends = [table[f"id_{end}"] for end in ("lo", "hi")]
    both = np.isin(ends[0], ids) & np.isin(ends[1], ids)
    out = {name: values[both] for name, values in table.items()}
    for end in ("lo", "hi"):
        out[f"id_{end}"] = names[element_rows(ids, out[f"id_{end}"])] if both.any() else ends[0][:0]
    return out


def joined_pairs(tables: list[Arrays]) -> Arrays:
    """Pairs of several tables of the same columns, sorted.

    Parameters
    ----------
    tables : list of Arrays
        Bond or contact tables.

    Returns
    -------
    dict of ndarray
        One table with all rows, by the lower, then the higher id.
    """
    joined = {name: np.concatenate([table[name] for table in tables]) for name in tables[0]}
    order = np.lexsort((joined["id_hi"], joined["id_lo"]))
    return {name: values[order] for name, values in joined.items()}


def with_pairs(state: xr.Dataset, tables: dict[str, Arrays]) -> xr.Dataset:
    """State with bonds and contacts; what else overlaps makes no force.

    Elements that are newly at their places may overlap with others, as with the coast. Such an
    overlap is their rest overlap: it pushes no one away.

    Parameters
    ----------
    state : xarray.Dataset
        Elements at their places.
    tables : dict of Arrays
        Bonds and contacts, by ``bond`` and ``contact``.

    Returns
    -------
    xarray.Dataset
        A new one.
    """
    contacts = tables["contact"]
    known = [np.stack([t["id_lo"], t["id_hi"]], axis=1) for t in tables.values()]
    lo, hi, overlap = overlapping_discs(state, np.concatenate(known))
    extra: Arrays = {name: np.zeros(len(lo)) for name in contacts}
    extra |= {"id_lo": lo, "id_hi": hi, "rest_overlap": overlap}
    tables = tables | {"contact": joined_pairs([contacts, extra])}
    return with_tables(state, tables)


# A ridge at a wall holds a disc off by less than this share of its radius.
FAR = 0.25


def with_walls(state: xr.Dataset, before: xr.Dataset, names: Index | None) -> xr.Dataset:
    """State with its walls: contacts keep their elastic overlap, new ones begin without force.

    Parameters
    ----------
    state, before : xarray.Dataset
        State with other elements than before; both at the same time.
    names : ndarray or None
        Id that each element of ``before`` goes by now, (n,); None: all contacts begin anew.

    Returns
    -------
    xarray.Dataset
        The state itself where it had no walls.
    """
    if "wall_contact_id" not in before:
        return state
    time = float(before.attrs["time"])
    contacts, faces = (pair_arrays(before, f"wall_{kind}") for kind in ("contact", "face"))
    if names is None:
        contacts = {name: values[:0] for name, values in contacts.items()}
        names = before["id"].values

    def overlap(of: xr.Dataset, ids: Index, face: Index) -> Array:
        row = element_rows(of["id"].values, ids)
        place = of["x"].values[row], of["y"].values[row]
        some = {name: values[face] for name, values in faces.items()}
        return np.asarray(of["radius"].values[row] - distances(some, *place, time))

    elastic = overlap(before, contacts["id"], contacts["face"]) - contacts["rest_overlap"]
    contacts["id"] = names[element_rows(before["id"].values, contacts["id"])]
    # Of the contacts that have become one the hardest stays.
    order = np.lexsort((-elastic, contacts["face"], contacts["id"]))
    pair = np.stack([contacts["id"], contacts["face"]], axis=1)[order]
    first = np.append(True, (np.diff(pair, axis=0) != 0).any(axis=1))[: len(pair)]
    contacts = {name: values[order[first]] for name, values in contacts.items()}
    now, elastic = overlap(state, contacts["id"], contacts["face"]), elastic[order[first]]
    contacts["rest_overlap"] = now - elastic
    # An element that merging moved away from a wall keeps nothing of it: the wall's next faces
    # would take over a rest from afar.
    apart = -FAR * state["radius"].values[element_rows(state["id"].values, contacts["id"])]
    near = (now > 0.0) | ((elastic > 0.0) & (now > apart))
    contacts = {name: values[near] for name, values in contacts.items()}
    ice = np.flatnonzero(state["type"].values != COAST)
    elements = {name: state[name].values[ice] for name in ("id", "x", "y", "radius")}
    found = overlapping(faces, elements, time)
    base = len(faces["ax"])
    known = contacts["id"] * base + contacts["face"]
    new = ~np.isin(found["id"] * base + found["face"], known)
    none = np.zeros(int(new.sum()))
    extra = {name: found[name][new] if name in found else none for name in contacts}
    contacts = {name: np.concatenate([contacts[name], extra[name]]) for name in contacts}
    order = np.lexsort((contacts["face"], contacts["id"]))
    contacts = {name: values[order] for name, values in contacts.items()}
    return with_tables(state, {"wall_face": faces, "wall_contact": contacts})


def overlapping_discs(state: xr.Dataset, but: Index) -> tuple[Index, Index, Array]:
    """Ids of pairs that overlap, but for those known (k, 2), and by how much (m).

    Parameters
    ----------
    state : xarray.Dataset
        Elements at their places.
    but : Index
        Ids of pairs that are known, (k, 2).

    Returns
    -------
    tuple of Index and ndarray
        Ids lo and hi, (p,), and overlap (m), (p,).
    """
    ids, radius = state["id"].values, state["radius"].values
    places = np.stack([state["x"].values, state["y"].values], axis=1)
    pairs = cKDTree(places).query_pairs(2.0 * float(radius.max()), output_type="ndarray")
    lo, hi = np.sort(pairs, axis=1).T.astype(np.int64)
    overlap = radius[lo] + radius[hi] - np.hypot(*(places[hi] - places[lo]).T)
    coast = state["type"].values == COAST
    keep = (overlap > 0) & ~(coast[lo] & coast[hi])
    lo, hi, overlap = ids[lo[keep]], ids[hi[keep]], overlap[keep]
    base = int(ids[-1]) + 1
    new = ~np.isin(lo * base + hi, but[:, 0] * base + but[:, 1])
    return lo[new], hi[new], overlap[new]
