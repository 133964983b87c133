# SPDX-License-Identifier: GPL-2.0-or-later
"""Discs as large as it takes for a pack to resist where its elements cover the sea.

A contact is as long as the side of the hexagon about the smaller disc (`EDGE_SHARE`). Where a disc
fills that hexagon's share of its element's area, contacts all around it are as long as the
element's outline. Discs of a tessellation, of fresh cells and of elements that took in open water
fill less, and a pack that covers its sea would converge by a tenth before its contacts resist. So
discs grow. What overlaps then makes no force: it is rest overlap.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.core.period import distances_of, period_of
from floeflow.state.bonds import element_rows
from floeflow.state.elements import pair_arrays
from floeflow.state.schema import MOBILE
from floeflow.state.walls import clearance, distances

Array = NDArray[np.float64]

# Share of a hexagon that the disc inscribed in it fills, 0.907.
INSCRIBED = float(np.pi / np.sqrt(12.0))


def fill_areas(state: xr.Dataset, time: float = 0.0) -> xr.Dataset:
    """Let discs grow until they fill `INSCRIBED` of the areas of their elements.

    Centres, areas, momenta and angular momenta stay, and so do the forces of contacts. A gap gets
    narrower, and is touched at most. At walls and closed coasts discs end where these stand.

    Parameters
    ----------
    state : xarray.Dataset
        State before the motion of a window.
    time : float
        At which walls are where they are, s.

    Returns
    -------
    xarray.Dataset
        New state: ``radius``, ``omega``, ``contact_rest_overlap``, ``wall_contact_rest_overlap``.
    """
    radius = state["radius"].values
    x, y = state["x"].values, state["y"].values
    mobile = state["type"].values == MOBILE
    wanted = np.sqrt(INSCRIBED * state["area"].values / np.pi)
    some = np.flatnonzero(mobile & (wanted > radius))
    faces = pair_arrays(state, "wall_face") if "wall_face_ax" in state else None
    if faces is not None and len(faces["ax"]) and len(some):
        room = clearance(faces, x[some], y[some], time, float(wanted[some].max()))
        wanted[some] = np.minimum(wanted[some], room)
    grown = radius.copy()
    grown[some] = np.maximum(wanted[some], radius[some])
    if not (grown > radius).any():
        return state
    # The moment of inertia of a disc grows with its area.
    spin = state["omega"].values * (radius / grown) ** 2
    out = state.assign(radius=("element", grown), omega=("element", spin))
    out = _with_contacts(out, radius, grown)
    return out if faces is None else _with_wall_contacts(out, radius, grown, time)


def _rest(overlap: Array, rest: Array, more: Array) -> Array:
    """Rest overlaps of discs that overlap by so much more: forces stay, gaps close at most."""
    elastic = overlap - rest
    return overlap + more - np.where(elastic > 0.0, elastic, np.minimum(elastic + more, 0.0))


def _with_contacts(state: xr.Dataset, radius: Array, grown: Array) -> xr.Dataset:
    if "contact_id_lo" not in state or not state.sizes["contact"]:
        return state
    ids = state["id"].values
    lo, hi = (element_rows(ids, state[f"contact_id_{end}"].values) for end in ("lo", "hi"))
    places = {"x": state["x"].values, "y": state["y"].values}
    overlap = radius[lo] + radius[hi] - distances_of(places, lo, hi, period_of(state.attrs))
    more = (grown - radius)[lo] + (grown - radius)[hi]
    rest = _rest(overlap, state["contact_rest_overlap"].values, more)
    return state.assign(contact_rest_overlap=("contact", rest))


def _with_wall_contacts(state: xr.Dataset, radius: Array, grown: Array, time: float) -> xr.Dataset:
    if "wall_contact_id" not in state or not state.sizes["wall_contact"]:
        return state
    contacts, faces = (pair_arrays(state, f"wall_{kind}") for kind in ("contact", "face"))
    row = element_rows(state["id"].values, contacts["id"])
    face = {name: values[contacts["face"]] for name, values in faces.items()}
    away = distances(face, state["x"].values[row], state["y"].values[row], time)
    more = (grown - radius)[row]
    rest = _rest(radius[row] - away, contacts["rest_overlap"], more)
    return state.assign(wall_contact_rest_overlap=("wall_contact", rest))
