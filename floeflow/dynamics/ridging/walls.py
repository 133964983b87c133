# SPDX-License-Identifier: GPL-2.0-or-later
"""Contacts with walls where ridging made their elements smaller and thicker (see `ridging`)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from floeflow.state.bonds import Arrays, element_rows
from floeflow.state.elements import pair_arrays
from floeflow.state.walls import distances


@dataclass(frozen=True)
class WallOverlaps:
    """Wall contacts of a state, (n,): element's row, distance of its new centre from the face (m).

    elastic is the overlap (m) that holds the same force with the new stiffness, softer the old
    stiffness over the new one.
    """

    row: np.ndarray
    distance: np.ndarray
    elastic: np.ndarray
    softer: np.ndarray


def wall_overlaps(state: xr.Dataset, before: Arrays, after: Arrays, time: float) -> WallOverlaps:
    """Overlaps of a state's wall contacts.

    Parameters
    ----------
    state : xarray.Dataset
        With walls.
    before, after : dict of ndarray
        Elements before and after they lost area to ridges.
    time : float
        At which the walls are where they are, s.

    Returns
    -------
    WallOverlaps
        Row of the element, distance of its centre from the wall (m), elastic overlap (m) and the
        factor by which the overlap shrank with the thickness, one for each contact.
    """
    contacts, faces = (pair_arrays(state, f"wall_{kind}") for kind in ("contact", "face"))
    row = element_rows(before["id"], contacts["id"])
    face = {name: values[contacts["face"]] for name, values in faces.items()}
    old, new = (distances(face, e["x"][row], e["y"][row], time) for e in (before, after))
    elastic = before["radius"][row] - old - contacts["rest_overlap"]
    # The stiffness is the element's thickness times the modulus: thicker ice overlaps less.
    softer = before["thickness"][row] / after["thickness"][row]
    return WallOverlaps(row, new, np.where(elastic > 0, elastic * softer, elastic), softer)


def shift_wall_contacts(
    state: xr.Dataset, before: Arrays, after: Arrays, time: float
) -> xr.Dataset:
    """Let wall contacts keep their elastic forces; those that are open and apart are forgotten.

    Parameters
    ----------
    state : xarray.Dataset
        With the table of wall contacts.
    before : Arrays
        Elements before and after their change.
    after : Arrays
        Elements before and after their change.
    time : float
        Since the start (s), by which walls have moved.

    Returns
    -------
    xarray.Dataset
        A new one.

    Raises
    ------
    FloeError
        For a wall contact of an element that does not exist.
    """
    held = wall_overlaps(state, before, after, time)
    now = after["radius"][held.row] - held.distance
    ridge = state["wall_contact_ridge_thickness"].values
    least = 0.5 * after["thickness"][held.row]  # as in a ridge of two elements
    thick = np.where(ridge > 0, np.maximum(ridge, least), ridge)
    shifted = state.assign(
        wall_contact_rest_overlap=("wall_contact", now - held.elastic),
        wall_contact_slip=("wall_contact", state["wall_contact_slip"].values * held.softer),
        wall_contact_ridge_thickness=("wall_contact", thick),
    )
    return shifted.isel(wall_contact=np.flatnonzero((held.elastic > 0) | (now > 0)))
