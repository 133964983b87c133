# SPDX-License-Identifier: GPL-2.0-or-later
"""Where ridges took the ice from: the centre of what is left of each element.

A ridge closes one side of an element. What is left has its centre further from that side. Its disc
moves there: it keeps to its other neighbours, and stands clear of the ridge by half of the
closing, where a disc that only shrank about its centre would by a sixth.
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from floeflow.core.period import period_of, shortest
from floeflow.state.bonds import Arrays, element_rows
from floeflow.state.elements import pair_arrays
from floeflow.state.schema import COAST
from floeflow.state.walls import nearest_points, unsafe

# No centre moves by more than this share of its radius in a window.
MOST = 0.5


def centre_shifts(
    state: xr.Dataset, held: dict[str, Arrays], before: Arrays, ridged: np.ndarray, time: float
) -> np.ndarray:
    """How far the centres of what is left lie from those before the ridging, (n, 2), m.

    A strip of area a_k at the distance e_k from the centre, in the direction n_k of the contact,
    is gone from an element of area A: the centre moves by - sum a_k e_k n_k / (A - sum a_k).

    Parameters
    ----------
    state : xarray.Dataset
        State after the motion, areas not yet reduced.
    held : dict of dict of ndarray
        Tables ``contact`` and, with walls, ``wall_contact`` at the window's start.
    before : dict of ndarray
        Elements as from `element_arrays`, before they lost area.
    ridged : ndarray
        Area that each element gave, m2, (n,).
    time : float
        At which walls are where they are, s.

    Returns
    -------
    ndarray
        Along x and y (m), (n, 2); no longer than the share `MOST` of the radius, and 0 for what
        would come ashore.
    """
    count = len(before["id"])
    area, moment = np.zeros(count), np.zeros((count, 2))
    for row, towards, closed, width in _sides(state, held, before, time):
        strip = closed * width
        np.add.at(area, row, strip)
        arm = strip * np.maximum(before["radius"][row] - 0.5 * closed, 0.0)
        np.add.at(moment, row, arm[:, None] * towards)
    # What the contacts tell is scaled to what the plugin summed: contacts may have ended since.
    scale = np.divide(ridged, area, out=np.zeros(count), where=area > 0)
    whole = state["area"].values
    left = np.maximum(whole - ridged, 0.1 * whole)
    fixed = before["type"] == COAST
    scale = np.where(fixed | (whole <= 0), 0.0, scale / np.where(left > 0, left, 1.0))
    shift = -scale[:, None] * moment
    size = np.hypot(*shift.T)
    most = MOST * before["radius"]
    shift = shift * np.minimum(1.0, most / np.maximum(size, 1e-300))[:, None]
    return np.where(_ashore(state, before, shift, time)[:, None], 0.0, shift)


def _ashore(state: xr.Dataset, before: Arrays, shift: np.ndarray, time: float) -> np.ndarray:
    """Whether a shift takes an element across a wall or leaves it no room for ridges, (n,)."""
    out = np.zeros(len(shift), dtype=bool)
    if "wall_face_ax" not in state or state.sizes["wall_face"] == 0:
        return out
    faces, moved = pair_arrays(state, "wall_face"), np.flatnonzero(shift.any(axis=1))
    places = np.column_stack([before["x"], before["y"]])[moved]
    out[moved] = unsafe(faces, places, places + shift[moved], before["radius"][moved], time)
    return out


def _sides(
    state: xr.Dataset, held: dict[str, Arrays], before: Arrays, time: float
) -> list[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]:
    """Rows, directions (k, 2), closing of that side (m) and its width (m), for all sides."""
    contacts = pair_arrays(state, "contact")
    grown = _growth(contacts, held.get("contact"), ("id_lo", "id_hi"))
    lo, hi = (element_rows(before["id"], contacts[f"id_{end}"]) for end in ("lo", "hi"))
    x, y = (before[a][hi] - before[a][lo] for a in ("x", "y"))
    way = np.column_stack(shortest((x, y), period_of(state.attrs)))
    way /= np.maximum(np.hypot(*way.T), 1e-300)[:, None]
    h, fixed = before["thickness"], before["type"] == COAST
    share = h[hi] / (h[lo] + h[hi])
    share = np.where(fixed[lo], 0.0, np.where(fixed[hi], 1.0, share))
    width = contacts["ridge_length"]
    out = [(lo, way, share * grown, width), (hi, -way, (1.0 - share) * grown, width)]
    if "wall_contact_ridge_closing" in state:
        walled, faces = (pair_arrays(state, f"wall_{kind}") for kind in ("contact", "face"))
        grown = _growth(walled, held.get("wall_contact"), ("id", "face"))
        row = element_rows(before["id"], walled["id"])
        face = {name: values[walled["face"]] for name, values in faces.items()}
        place = np.column_stack([before["x"][row], before["y"][row]])
        way = nearest_points(face, place, time) - place
        way /= np.maximum(np.hypot(*way.T), 1e-300)[:, None]
        out.append((row, way, grown, walled["ridge_length"]))
    return out


def _growth(now: Arrays, then: Arrays | None, ends: tuple[str, str]) -> np.ndarray:
    """By how much each contact closed plastically since the window's start, m."""
    if then is None or not len(then[ends[0]]):
        return now["ridge_closing"]
    base = 1 + max(int(t[ends[1]].max(initial=0)) for t in (now, then))
    key, known = (t[ends[0]] * base + t[ends[1]] for t in (now, then))
    order = np.argsort(known, kind="stable")
    place = np.minimum(np.searchsorted(known[order], key), len(known) - 1)
    found = known[order][place] == key
    # Ridges that a table does not know of had not begun.
    closing = then.get("ridge_closing", np.zeros(len(known)))
    past = np.where(found, closing[order][place], 0.0)
    grown = now["ridge_closing"] - past
    # One that closed by less than before has begun anew.
    return np.where(grown >= 0, grown, now["ridge_closing"])
