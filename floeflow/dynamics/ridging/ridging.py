# SPDX-License-Identifier: GPL-2.0-or-later
"""What ridging leaves at a window's end: smaller elements of thicker ice, and open water.

The dynamics count how much of each element's area its contacts turned into ridges. Here the
elements lose that area; their ice keeps its volume and their contacts keep their force.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from floeflow.core.period import apart, distances_of, period_of, tree_of, wrapped
from floeflow.dynamics.ridging.centre_shifts import centre_shifts
from floeflow.dynamics.ridging.walls import shift_wall_contacts
from floeflow.state.bonds import Arrays, element_rows
from floeflow.state.elements import element_arrays
from floeflow.state.schema import COAST

# Neighbours whose discs are no further apart than this share of their radii's sum keep their gaps.
NEAR = 0.05
# No element gets smaller than this share of the mean one: what is used up joins a neighbour then.
LEAST_AREA = 0.02
# Per effective area, so that they grow as it shrinks.
_VOLUMES = ("ice_volume", "snow_volume")


def close_areas(
    state: xr.Dataset,
    ridged: np.ndarray,
    minimum_thickness: float,
    held: dict[str, Arrays] | None = None,
    time: float = 0.0,
    leads: bool = True,
) -> xr.Dataset:
    """Take the area that was turned into ridges from the elements.

    Open water of an element closes before its ice, ice and snow keep their volume, the disc
    shrinks with the area and moves to the centre of what is left, and what was closed becomes
    unclaimed water. The lines of bonds stay where they are.

    Parameters
    ----------
    state : xarray.Dataset
        State after the motion.
    ridged : ndarray, shape (n,)
        Area turned into ridges, m2, in the order of the elements. Where it is all that an element
        has, a rest stays (`LEAST_AREA`), which is to join a neighbour.
    minimum_thickness : float
        As in `element_arrays`, m.
    held : dict of dict of ndarray, optional
        Tables ``contact`` and, with walls, ``wall_contact`` at the window's start; absent: no pair
        had closed before.
    time : float
        At which walls, if there are any, are where they are, s.
    leads : bool
        Off where `floeflow.column.thickness.redistribution` is yet to say what of the area was
        water and what ice of which thickness: the ice fraction stays as it was until then.

    Returns
    -------
    xarray.Dataset
        New state: area, place, radius, volumes, ice fraction, contacts, ``unclaimed_water``.
    """
    area = state["area"].values
    coast = state["type"].values == COAST
    least = LEAST_AREA * (float(area[~coast].mean()) if (~coast).any() else 0.0)
    left = np.where(coast, area, np.maximum(area - ridged, np.minimum(area, least)))
    share = np.divide(left, area, out=np.ones_like(area), where=~coast & (area > 0))
    before = element_arrays(state, minimum_thickness)
    shift = centre_shifts(state, held or {}, before, area - left, time)
    size = state["radius"].values * np.sqrt(share)
    found: dict[str, tuple[Any, np.ndarray]] = {"area": ("element", left)}
    found["radius"] = ("element", size)
    moved = np.column_stack([state["x"].values, state["y"].values]) + shift
    for axis, values in zip("xy", wrapped(moved, period_of(state.attrs)).T, strict=True):
        found[axis] = ("element", values.copy())
    for name in _VOLUMES:
        if name in state:
            found[name] = (state[name].dims, state[name].values / share[:, None])
    if leads:
        fraction = state["ice_fraction"].values
        whole = np.maximum(fraction.sum(axis=1), np.finfo(float).tiny)
        more = np.minimum(1.0 / share, np.maximum(1.0 / whole, 1.0))
        found["ice_fraction"] = (state["ice_fraction"].dims, fraction * more[:, None])
    water = float(state.attrs["unclaimed_water"]) + float((area - left).sum())
    closed = state.assign(found)
    closed.attrs = {**state.attrs, "unclaimed_water": water}
    after = element_arrays(closed, minimum_thickness)
    closed = _shift_contacts(_shift_bonds(closed, shift), before, after)
    walled = "wall_contact_ridge_closing" in closed
    return shift_wall_contacts(closed, before, after, time) if walled else closed


def _shift_bonds(state: xr.Dataset, shift: np.ndarray) -> xr.Dataset:
    """Bonds of elements whose centres have moved: their lines stay where they are in space."""
    if "bond_id_lo" not in state or not shift.any():
        return state
    out = {}
    for side in ("lo", "hi"):
        row = element_rows(state["id"].values, state[f"bond_id_{side}"].values)
        cos, sin = np.cos(state["theta"].values[row]), np.sin(state["theta"].values[row])
        dx, dy = shift[row].T
        body = cos * dx + sin * dy, cos * dy - sin * dx
        for end in "ab":
            for axis, moved in zip("xy", body, strict=True):
                name = f"bond_{side}_{end}{axis}"
                out[name] = ("bond", state[name].values - moved)
    return state.assign(out)


def contact_share(elements: Arrays, lo: np.ndarray, hi: np.ndarray) -> np.ndarray:
    """Contact stiffness over the contact modulus, m: h_i h_j / (h_i + h_j).

    Parameters
    ----------
    elements : Arrays
        Table of n elements, sorted by id.
    lo : ndarray
        Rows of the k pairs.
    hi : ndarray
        Rows of the k pairs.

    Returns
    -------
    ndarray
        m, (k,).
    """
    a, b = elements["thickness"][lo], elements["thickness"][hi]
    return np.asarray(a * b / np.maximum(a + b, np.finfo(float).tiny))


def _shift_contacts(state: xr.Dataset, before: Arrays, after: Arrays) -> xr.Dataset:
    """Let contacts keep their elastic forces, and gaps between neighbours their widths.

    A ridge takes ice from one side of an element, its disc shrinks on all: what lies on the other
    sides must not be further off for that. Pairs that are open and apart are forgotten.
    """
    state = _with_neighbours(state, before, after)
    ids = before["id"]
    lo, hi = (element_rows(ids, state[f"contact_id_{end}"].values) for end in ("lo", "hi"))
    period = period_of(state.attrs)
    distance = distances_of(before, lo, hi, period)
    reach, shrunk = (r[lo] + r[hi] for r in (before["radius"], after["radius"]))
    elastic = reach - distance - state["contact_rest_overlap"].values
    # Thicker ice is stiffer: less overlap holds the same force. A gap stays as wide as it is.
    softer = contact_share(before, lo, hi) / contact_share(after, lo, hi)
    elastic = np.where(elastic > 0, elastic * softer, elastic)
    distance = distances_of(after, lo, hi, period)
    rest = shrunk - distance - elastic
    # Where an element is nearly used up, its ridges are no thinner than half of its ice.
    thin = 0.5 * np.minimum(after["thickness"][lo], after["thickness"][hi])
    ridge = state["contact_ridge_thickness"].values
    thick = np.where(ridge > 0, np.maximum(ridge, thin), ridge)
    # What is open and has built no ridge starts anew, with the ice of then, where it touches.
    anew = (elastic <= 0) & (state["contact_ridge_closing"].values == 0)
    length = state["contact_ridge_length"].values
    shifted = state.assign(
        contact_rest_overlap=("contact", rest),
        contact_slip=("contact", state["contact_slip"].values * softer),
        contact_ridge_thickness=("contact", np.where(anew, 0.0, thick)),
        contact_ridge_length=("contact", np.where(anew, 0.0, length)),
    )
    near = (rest < 0) & (elastic > -NEAR * reach)
    return shifted.isel(contact=np.flatnonzero((elastic > 0) | (shrunk > distance) | near))


def _with_neighbours(state: xr.Dataset, before: Arrays, after: Arrays) -> xr.Dataset:
    """State whose contacts include the open pairs beside elements that became smaller."""
    ids, radius, fixed = before["id"], before["radius"], before["type"] == COAST
    smaller = (after["radius"] < radius) | (after["x"] != before["x"])
    smaller |= after["y"] != before["y"]
    places = np.column_stack([before["x"], before["y"]])
    widest = 2 * (1 + NEAR) * float(radius.max(initial=0.0))
    period = period_of(state.attrs)
    pairs = tree_of(places, period).query_pairs(widest, output_type="ndarray").reshape(-1, 2)
    lo, hi = np.sort(pairs, axis=1).T
    reach = radius[lo] + radius[hi]
    gap = apart(places, lo, hi, period) - reach
    near = (gap >= 0) & (gap < NEAR * reach) & (smaller[lo] | smaller[hi])
    near &= ~(fixed[lo] & fixed[hi])
    for kind in ("bond", "contact"):
        if f"{kind}_id_lo" in state:
            one, two = (element_rows(ids, state[f"{kind}_id_{e}"].values) for e in ("lo", "hi"))
            near &= ~np.isin(lo * len(ids) + hi, one * len(ids) + two)
    names = [str(name) for name in state.variables if str(name).startswith("contact_")]
    fresh = {name: np.zeros(near.sum(), state[name].dtype) for name in names}
    fresh |= {"contact_id_lo": ids[lo[near]], "contact_id_hi": ids[hi[near]]}
    table = {name: np.append(state[name].values, fresh[name]) for name in names}
    order = np.lexsort((table["contact_id_hi"], table["contact_id_lo"]))
    return state.drop_vars(names).assign(
        {name: ("contact", values[order]) for name, values in table.items()}
    )
