# SPDX-License-Identifier: GPL-2.0-or-later
"""What ridging leaves at a window's end: smaller elements of thicker ice, and open water.

The dynamics count how much of each element's area its contacts turned into ridges. Here the
elements lose that area; their ice keeps its volume and their contacts keep their force.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from scipy.spatial import cKDTree

from floeflow.core.errors import FloeError
from floeflow.dynamics.ridging.crushing import stand_clear
from floeflow.dynamics.ridging.walls import shift_wall_contacts
from floeflow.state.bonds import Arrays, element_rows
from floeflow.state.elements import element_arrays
from floeflow.state.schema import COAST

# Neighbours whose discs are no further apart than this share of their radii's sum keep their gaps.
NEAR = 0.05
# Per effective area, so that they grow as it shrinks.
_VOLUMES = ("ice_volume", "snow_volume")


def close_areas(
    state: xr.Dataset, ridged: np.ndarray, minimum_thickness: float, time: float = 0.0
) -> xr.Dataset:
    """Take the area that was turned into ridges from the elements.

    Ice and leads of an element close in proportion (its ice fraction stays), ice and snow keep
    their volume, the radius follows the area, and what was closed becomes unclaimed water. Bonds
    hold their lines in the elements' body frames and need no change.

    Parameters
    ----------
    state : xarray.Dataset
        State after the motion.
    ridged : ndarray, shape (n,)
        Area turned into ridges, m2, in the order of the elements.
    minimum_thickness : float
        As in `element_arrays`, m.
    time : float
        At which walls, if there are any, are where they are, s.

    Returns
    -------
    xarray.Dataset
        New state: area, radius, volumes, contacts, ``unclaimed_water``.

    Raises
    ------
    FloeError
        If an element would lose all its area; names it.
    """
    area = state["area"].values
    coast = state["type"].values == COAST
    left = np.where(coast, area, area - ridged)
    gone = ~coast & ~(left > 0)
    if gone.any():
        row = int(np.flatnonzero(gone)[0])
        raise FloeError(
            f"Element {state['id'].values[row]} at ({state['x'].values[row]:.6g}, "
            f"{state['y'].values[row]:.6g}) m lost all its area to ridging in one window: shorten "
            "time.window."
        )
    share = np.divide(left, area, out=np.ones_like(area), where=~coast)
    closed = state.copy()
    closed["area"] = ("element", left)
    closed["radius"] = ("element", state["radius"].values * np.sqrt(share))
    for name in _VOLUMES:
        if name in state:
            closed[name] = (state[name].dims, state[name].values / share[:, None])
    water = float(state.attrs["unclaimed_water"]) + float((area - left).sum())
    closed.attrs = {**state.attrs, "unclaimed_water": water}
    before = element_arrays(state, minimum_thickness)
    after = element_arrays(closed, minimum_thickness)
    after |= stand_clear(closed, before, after, time)
    for name in ("radius", "x", "y"):
        closed[name] = ("element", after[name])
    closed = _shift_contacts(closed, before, after)
    walled = "wall_contact_ridge_closing" in closed
    return shift_wall_contacts(closed, before, after, time) if walled else closed


def contact_share(elements: Arrays, lo: np.ndarray, hi: np.ndarray) -> np.ndarray:
    """Contact stiffness over the contact modulus, m: h_i h_j / (h_i + h_j)."""
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
    distance = np.hypot(before["x"][hi] - before["x"][lo], before["y"][hi] - before["y"][lo])
    reach, shrunk = (r[lo] + r[hi] for r in (before["radius"], after["radius"]))
    elastic = reach - distance - state["contact_rest_overlap"].values
    # Thicker ice is stiffer: less overlap holds the same force. A gap stays as wide as it is.
    softer = contact_share(before, lo, hi) / contact_share(after, lo, hi)
    elastic = np.where(elastic > 0, elastic * softer, elastic)
    distance = np.hypot(after["x"][hi] - after["x"][lo], after["y"][hi] - after["y"][lo])
    rest = shrunk - distance - elastic
    # Where an element is nearly used up, its ridges are no thinner than half of its ice.
    thin = 0.5 * np.minimum(after["thickness"][lo], after["thickness"][hi])
    ridge = state["contact_ridge_thickness"].values
    shifted = state.assign(
        contact_rest_overlap=("contact", rest),
        contact_slip=("contact", state["contact_slip"].values * softer),
        contact_ridge_thickness=("contact", np.where(ridge > 0, np.maximum(ridge, thin), ridge)),
    )
    # What is open and has built no ridge starts anew, with the ice of then, where it touches.
    anew = (elastic <= 0) & (state["contact_ridge_closing"].values == 0)
    for name in ("contact_ridge_thickness", "contact_ridge_length"):
        shifted[name] = ("contact", np.where(anew, 0.0, shifted[name].values))
    near = (rest < 0) & (elastic > -NEAR * reach)
    return shifted.isel(contact=np.flatnonzero((elastic > 0) | (shrunk > distance) | near))


def _with_neighbours(state: xr.Dataset, before: Arrays, after: Arrays) -> xr.Dataset:
    """State whose contacts include the open pairs beside elements that became smaller."""
    ids, radius, fixed = before["id"], before["radius"], before["type"] == COAST
    smaller = after["radius"] < radius
    places = np.column_stack([before["x"], before["y"]])
    widest = 2 * (1 + NEAR) * float(radius.max(initial=0.0))
    pairs = cKDTree(places).query_pairs(widest, output_type="ndarray").reshape(-1, 2)
    lo, hi = np.sort(pairs, axis=1).T
    reach = radius[lo] + radius[hi]
    gap = np.hypot(*(places[hi] - places[lo]).T) - reach
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
