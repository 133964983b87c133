# SPDX-License-Identifier: GPL-2.0-or-later
"""Discs that stand clear of their ridges.

A ridge takes ice from one side of an element, a smaller disc takes it from all. Where elements
have ridged far on one side, their discs would lie deep in each other: here they shrink further.
What bears load does not change, since each contact keeps its force (`ridging`).
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from floeflow.dynamics.ridging.walls import wall_overlaps
from floeflow.state.bonds import Arrays, element_rows
from floeflow.state.schema import COAST

# Ridges may overlap by this share of the smaller radius at a window's end; no disc shrinks below
# the second share of the radius of a disc with its area.
OVERLAP, SMALLEST = 0.095, 0.1


def stand_clear(state: xr.Dataset, before: Arrays, after: Arrays, time: float) -> Arrays:
    """Radius, x and y (m) with which ridges overlap by no more than `OVERLAP`.

    Parameters
    ----------
    state : xarray.Dataset
        State after the motion, with contacts and areas.
    before, after : dict of ndarray
        Its elements before and after they lost area to ridges.
    time : float
        At which walls, if there are any, are where they are, s.

    Returns
    -------
    dict of ndarray, shape (n,)
        Discs shrink in the shares in which their elements gave the ice. One that cannot shrink any
        more is pushed along: thin ice of which a ridge has used up all that lay on one side.
        Bonded elements stay where they are.
    """
    radius = after["radius"] - _crushed(state, before, after, time)
    return {"radius": radius} | _pushed_along(state, before, after | {"radius": radius})


def _crushed(state: xr.Dataset, before: Arrays, after: Arrays, time: float) -> np.ndarray:
    lo, hi, over, share = _excess(state, before, after)
    radius = after["radius"]
    out = np.zeros(len(radius))
    for row, part in ((lo, share), (hi, 1.0 - share)):
        np.maximum.at(out, row, part * over)
    if "wall_contact_ridge_closing" in state:
        held = wall_overlaps(state, before, after, time)
        clear = (1.0 - OVERLAP) * radius[held.row] - np.maximum(held.elastic, 0.0)
        closing = state["wall_contact_ridge_closing"].values
        np.maximum.at(out, held.row, np.minimum(clear - held.distance, closing))
    least = SMALLEST * np.sqrt(state["area"].values / np.pi)
    room = np.maximum(radius - least, 0.0)
    return np.where(after["type"] == COAST, 0.0, np.clip(out, 0.0, room))


def _pushed_along(state: xr.Dataset, before: Arrays, after: Arrays) -> Arrays:
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
    ids = before["id"]
    lo, hi = (element_rows(ids, state[f"contact_id_{end}"].values) for end in ("lo", "hi"))
    distance = np.hypot(before["x"][hi] - before["x"][lo], before["y"][hi] - before["y"][lo])
    reach, now = (r[lo] + r[hi] - distance for r in (before["radius"], after["radius"]))
    elastic = np.maximum(reach - state["contact_rest_overlap"].values, 0.0)
    over = now - elastic - OVERLAP * np.minimum(after["radius"][lo], after["radius"][hi])
    # Overlap of other origin (a broken bond, a disc that the rim cuts) stays.
    over = np.minimum(over, state["contact_ridge_closing"].values)
    h, coast = after["thickness"], after["type"] == COAST
    share = np.where(coast[lo], 0.0, np.where(coast[hi], 1.0, h[hi] / (h[lo] + h[hi])))
    return lo, hi, over, share
