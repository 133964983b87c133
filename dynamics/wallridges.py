# SPDX-License-Identifier: GPL-2.0-or-later
"""Contacts with walls where ridging made their elements smaller and thicker."""

from __future__ import annotations

import numpy as np
import xarray as xr

from floeflow.dynamics.bondtable import element_rows
from floeflow.dynamics.elements import element_arrays, pair_arrays
from floeflow.dynamics.walls import distances


def shift_wall_contacts(
    before: xr.Dataset, after: xr.Dataset, minimum_thickness: float, time: float
) -> xr.Dataset:
    """Let wall contacts keep their forces at a window's end, as `close_areas` does for pairs.

    Parameters
    ----------
    before, after : xarray.Dataset
        State before and after its elements lost the area that was turned into ridges.
    minimum_thickness : float
        As in `element_arrays`, m.
    time : float
        Of the window's end, at which the walls are where they are, s.

    Returns
    -------
    xarray.Dataset
        ``after`` with other rest overlaps and slips; what is open and apart is forgotten.
    """
    contacts, faces = (pair_arrays(after, f"wall_{kind}") for kind in ("contact", "face"))
    row = element_rows(after["id"].values, contacts["id"])
    face = {name: values[contacts["face"]] for name, values in faces.items()}
    distance = distances(face, after["x"].values[row], after["y"].values[row], time)
    overlap, now = (state["radius"].values[row] - distance for state in (before, after))
    elastic = overlap - contacts["rest_overlap"]
    # The stiffness is the element's thickness times the modulus: thicker ice overlaps less.
    old, new = (element_arrays(s, minimum_thickness)["thickness"][row] for s in (before, after))
    softer = old / new
    elastic = np.where(elastic > 0, elastic * softer, elastic)
    shifted = after.assign(
        wall_contact_rest_overlap=("wall_contact", now - elastic),
        wall_contact_slip=("wall_contact", contacts["slip"] * softer),
    )
    return shifted.isel(wall_contact=np.flatnonzero((elastic > 0) | (now > 0)))
