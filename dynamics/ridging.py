# SPDX-License-Identifier: GPL-2.0-or-later
"""What ridging leaves at a window's end: smaller elements of thicker ice, and open water.

The dynamics count how much of each element's area its contacts turned into ridges. Here the
elements lose that area; their ice keeps its volume and their contacts keep their force.
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from floeflow.dynamics.bondtable import Arrays, element_rows
from floeflow.dynamics.elements import element_arrays
from floeflow.dynamics.wallridges import shift_wall_contacts, wall_overlaps
from floeflow.errors import FloeError
from floeflow.state.schema import COAST

# Ridges may overlap by this share of the smaller radius at a window's end; no disc shrinks below
# the second share of the radius of a disc with its area.
OVERLAP, SMALLEST = 0.05, 0.1
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
    after["radius"] = closed["radius"].values - _crushed(closed, before, after, time)
    after |= _pushed_along(closed, before, after)
    for name in ("radius", "x", "y"):
        closed[name] = ("element", after[name])
    closed = _shift_contacts(closed, before, after)
    walled = "wall_contact_id" in closed
    return shift_wall_contacts(closed, before, after, time) if walled else closed


def contact_share(elements: Arrays, lo: np.ndarray, hi: np.ndarray) -> np.ndarray:
    """Contact stiffness over the contact modulus, m: h_i h_j / (h_i + h_j)."""
    a, b = elements["thickness"][lo], elements["thickness"][hi]
    return np.asarray(a * b / (a + b))


def _crushed(state: xr.Dataset, before: Arrays, after: Arrays, time: float) -> np.ndarray:
    """How much (m) each disc must shrink so that ridges overlap no more than `OVERLAP`, (n,).

    A ridge takes ice from one side, a smaller disc takes it from all: where elements have ridged
    far on one side, the disc is the largest that stands clear of its ridges. Its other contacts
    reach across the gaps that it leaves.
    """
    lo, hi, over, share = _excess(state, before, after)
    radius, coast = after["radius"], after["type"] == COAST
    out = np.zeros(len(radius))
    for row, part in ((lo, share), (hi, 1.0 - share)):
        np.maximum.at(out, row, part * over)
    if "wall_contact_id" in state:
        held = wall_overlaps(state, before, after, time)
        clear = (1.0 - OVERLAP) * radius[held.row] - np.maximum(held.elastic, 0.0)
        closing = state["wall_contact_ridge_closing"].values
        np.maximum.at(out, held.row, np.minimum(clear - held.distance, closing))
    least = SMALLEST * np.sqrt(state["area"].values / np.pi)
    return np.where(coast, 0.0, np.clip(out, 0.0, np.maximum(radius - least, 0.0)))


def _pushed_along(state: xr.Dataset, before: Arrays, after: Arrays) -> Arrays:
    """Places (m) of the elements: one whose disc cannot stand clear any more is pushed along.

    That is thin ice of which a ridge has used up all that lay on one side. Its forces stay: what
    moves is the place from which its contacts are measured. Bonded elements stay where they are.
    """
    lo, hi, over, share = _excess(state, before, after)
    dx, dy = after["x"][hi] - after["x"][lo], after["y"][hi] - after["y"][lo]
    over = np.maximum(over, 0.0) / np.maximum(np.hypot(dx, dy), 1.0)
    x, y = after["x"].copy(), after["y"].copy()
    for row, part in ((lo, -share), (hi, 1.0 - share)):
        np.add.at(x, row, part * over * dx)
        np.add.at(y, row, part * over * dy)
    stays = after["type"] == COAST
    if "bond_id_lo" in state:
        ids = np.concatenate([state["bond_id_lo"].values, state["bond_id_hi"].values])
        stays |= np.isin(after["id"], ids)
    return {"x": np.where(stays, after["x"], x), "y": np.where(stays, after["y"], y)}


def _excess(
    state: xr.Dataset, before: Arrays, after: Arrays
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Rows of each contact's elements, overlap beyond `OVERLAP` (m), share of it that lo gives."""
    lo, hi, elastic, _ = _elastic(state, before, after)
    radius = after["radius"]
    distance = np.hypot(after["x"][hi] - after["x"][lo], after["y"][hi] - after["y"][lo])
    over = radius[lo] + radius[hi] - distance - np.maximum(elastic, 0.0)
    over = over - OVERLAP * np.minimum(radius[lo], radius[hi])
    # Overlap of other origin (a broken bond, a disc that the rim cuts) stays.
    over = np.minimum(over, state["contact_ridge_closing"].values)
    h, coast = after["thickness"], after["type"] == COAST
    share = np.where(coast[lo], 0.0, np.where(coast[hi], 1.0, h[hi] / (h[lo] + h[hi])))
    return lo, hi, over, share


def _elastic(
    state: xr.Dataset, before: Arrays, after: Arrays
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Rows of both elements of each contact, its elastic overlap (m) and old over new stiffness."""
    ids = before["id"]
    lo, hi = (element_rows(ids, state[f"contact_id_{end}"].values) for end in ("lo", "hi"))
    distance = np.hypot(before["x"][hi] - before["x"][lo], before["y"][hi] - before["y"][lo])
    overlap = before["radius"][lo] + before["radius"][hi] - distance
    elastic = overlap - state["contact_rest_overlap"].values
    # Thicker ice is stiffer: less overlap holds the same force. A gap stays as wide as it is.
    softer = contact_share(before, lo, hi) / contact_share(after, lo, hi)
    return lo, hi, np.where(elastic > 0, elastic * softer, elastic), softer


def _shift_contacts(state: xr.Dataset, before: Arrays, after: Arrays) -> xr.Dataset:
    """Let contacts keep their elastic forces; those that are open and apart are forgotten."""
    lo, hi, elastic, softer = _elastic(state, before, after)
    distance = np.hypot(after["x"][hi] - after["x"][lo], after["y"][hi] - after["y"][lo])
    now = after["radius"][lo] + after["radius"][hi] - distance
    # Where an element is nearly used up, its ridges are no thinner than half of its ice.
    thin = 0.5 * np.minimum(after["thickness"][lo], after["thickness"][hi])
    ridge = state["contact_ridge_thickness"].values
    shifted = state.assign(
        contact_rest_overlap=("contact", now - elastic),
        contact_slip=("contact", state["contact_slip"].values * softer),
        contact_ridge_thickness=("contact", np.where(ridge > 0, np.maximum(ridge, thin), ridge)),
    )
    return shifted.isel(contact=np.flatnonzero((elastic > 0) | (now > 0)))
