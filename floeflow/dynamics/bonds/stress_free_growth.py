# SPDX-License-Identifier: GPL-2.0-or-later
"""Contacts of ice that has grown since it was pressed: new ice is not under stress.

The stiffness of a contact is that of the ice on both sides. Ice that freezes to the underside of
pressed elements is as long as they are then: it adds stiffness, but no force. Were the overlap left
as it is, a night's growth of thin ice would multiply forces and elastic energy, out of nothing.
What melts takes its share of the force with it, and so does area that is no longer covered by ice:
open water between the floes of an element takes up what pressed them.
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from floeflow.core.period import distances_of, period_of
from floeflow.dynamics.ridging.ridging import contact_share
from floeflow.state.bonds import element_rows
from floeflow.state.elements import element_arrays, pair_arrays
from floeflow.state.walls import distances


def keep_forces(
    before: xr.Dataset, after: xr.Dataset, minimum_thickness: float, time: float
) -> xr.Dataset:
    """Let contacts push no harder than before, and less where there is less ice to push.

    Parameters
    ----------
    before, after : xarray.Dataset
        State before and after the column, which moves no element and changes no pair.
    minimum_thickness : float
        As in `element_arrays`, m.
    time : float
        At which walls, if there are any, are where they are, s.

    Returns
    -------
    xarray.Dataset
        ``after`` with other rest overlaps and slips of contacts and wall contacts.
    """
    old, new = (element_arrays(state, minimum_thickness) for state in (before, after))
    lo, hi = (element_rows(old["id"], after[f"contact_id_{end}"].values) for end in ("lo", "hi"))
    apart = distances_of(old, lo, hi, period_of(before.attrs))
    overlap = old["radius"][lo] + old["radius"][hi] - apart
    softer = contact_share(old, lo, hi) / contact_share(new, lo, hi)
    had = old["ice_area"] > 0.0
    cover = np.divide(new["ice_area"], old["ice_area"], out=np.ones(len(had)), where=had)
    less = np.minimum(softer, np.minimum(cover[lo], cover[hi]))
    eased = _eased(after, "contact", overlap, less)
    if "wall_contact_id" not in after:
        return eased
    contacts, faces = (pair_arrays(after, f"wall_{kind}") for kind in ("contact", "face"))
    row = element_rows(old["id"], contacts["id"])
    face = {name: values[contacts["face"]] for name, values in faces.items()}
    overlap = old["radius"][row] - distances(face, old["x"][row], old["y"][row], time)
    less = np.minimum(old["thickness"][row] / new["thickness"][row], cover[row])
    return _eased(eased, "wall_contact", overlap, less)


def _eased(state: xr.Dataset, kind: str, overlap: np.ndarray, less: np.ndarray) -> xr.Dataset:
    """State with less elastic overlap and slip of the contacts that are pressed; never more."""
    rest, slip = (state[f"{kind}_{name}"].values for name in ("rest_overlap", "slip"))
    elastic = overlap - rest
    less = np.where(elastic > 0, np.minimum(less, 1.0), 1.0)
    # Where nothing has changed, not even a round-off does.
    moved = np.where(less < 1.0, overlap - elastic * less, rest)
    return state.assign(
        {f"{kind}_rest_overlap": (kind, moved), f"{kind}_slip": (kind, slip * less)}
    )
