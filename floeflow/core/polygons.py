# SPDX-License-Identifier: GPL-2.0-or-later
"""Outlines of the elements, for meshes and maps: the cells of the packing, or those of a remap.

They are kept in the body frames of their elements, and carried and turned with them. Elements
without a cell, as those of the coast, are discs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.core.errors import FloeError

Array = NDArray[np.float64]
Index = NDArray[np.int64]

DISC_CORNERS = 24


@dataclass(frozen=True)
class Outlines:
    """Outlines of elements as open rings, anticlockwise.

    Parameters
    ----------
    id : ndarray
        Ids of the elements, ascending, (element,).
    start : ndarray
        First corner of each, and the end, (element + 1,).
    x, y : ndarray
        Corners (m), (corner,).
    """

    id: Index
    start: Index
    x: Array
    y: Array

    def take(self, ids: Index) -> Outlines:
        """Outlines of some of the elements, by their ids, all known.

        Parameters
        ----------
        ids : ndarray
            (m,).

        Returns
        -------
        Outlines
            In the order of the ids.
        """
        rows = np.searchsorted(self.id, ids)
        corners = np.diff(self.start)[rows]
        start = np.concatenate([[0], np.cumsum(corners)])
        place = np.repeat(self.start[rows] - start[:-1], corners) + np.arange(start[-1])
        return Outlines(ids, start, self.x[place], self.y[place])


def _turned(outlines: Outlines, angle: Array) -> tuple[Array, Array]:
    angle = np.repeat(angle, np.diff(outlines.start))
    cos, sin = np.cos(angle), np.sin(angle)
    return cos * outlines.x - sin * outlines.y, sin * outlines.x + cos * outlines.y


def body_outlines(packing: xr.Dataset, first: xr.Dataset) -> Outlines:
    """Outlines in the body frames of the elements: about their centres, unturned.

    Parameters
    ----------
    packing : xarray.Dataset
        Cells of the elements, and radii for those that have none.
    first : xarray.Dataset
        State that was made from this packing.

    Returns
    -------
    Outlines
        Corners about the elements' centres (m).

    Raises
    ------
    FloeError
        Where the two do not have the same elements.
    """
    ids, corners = packing["id"].values, np.diff(packing["cell_start"].values)
    if not np.array_equal(ids, first["id"].values):
        raise FloeError("mesh: the packing does not have the elements of the first state")
    has_cell = corners >= 3
    count = np.where(has_cell, corners, DISC_CORNERS)
    start = np.concatenate([[0], np.cumsum(count)])
    of = np.repeat(np.arange(len(ids)), count)
    rank = np.arange(start[-1]) - start[of]
    turn = 2.0 * np.pi * rank / DISC_CORNERS
    x = packing["radius"].values[of] * np.cos(turn)
    y = packing["radius"].values[of] * np.sin(turn)
    cell = has_cell[of]
    place = packing["cell_start"].values[of[cell]] + rank[cell]
    x[cell] = packing["cell_x"].values[place] - first["x"].values[of[cell]]
    y[cell] = packing["cell_y"].values[place] - first["y"].values[of[cell]]
    there = Outlines(ids, start, x, y)
    return Outlines(ids, start, *_turned(there, -first["theta"].values))


def own_outlines(state: xr.Dataset) -> Outlines:
    """Outlines that a state of remapped elements holds, in the form of `body_outlines`.

    Parameters
    ----------
    state : xarray.Dataset
        After a remap.

    Returns
    -------
    Outlines
        Corners about the elements' centres (m).
    """
    count = state.sizes["element"]
    data = {name: ("element", state[name].values) for name in ("id", "radius")}
    held = xr.Dataset(
        data
        | {"cell_start": ("bound", np.append(0, np.cumsum(state["cell_corners"].values)))}
        | {f"cell_{axis}": ("vertex", state[f"corner_{axis}"].values) for axis in ("x", "y")}
    )
    still = {name: ("element", np.zeros(count)) for name in ("x", "y", "theta")}
    return body_outlines(held, xr.Dataset(still | {"id": ("element", state["id"].values)}))


def carried_outlines(body: Outlines, state: xr.Dataset) -> Outlines:
    """Outlines of a state's elements where they are: turned by their orientation, then shifted.

    Parameters
    ----------
    body : Outlines
        From `body_outlines`.
    state : xarray.Dataset
        State at a window boundary; elements that it has lost are left out.

    Returns
    -------
    Outlines
        Corners on the map (m).

    Raises
    ------
    FloeError
        Where the state has an element that has no outline.
    """
    ids = state["id"].values
    new = np.setdiff1d(ids, body.id)
    if len(new):
        raise FloeError(
            f"mesh: element {new[0]} of state {int(state.attrs['window']):04d} is not in the "
            "packing, so it has no cell"
        )
    own = body.take(ids)
    corners = np.diff(own.start)
    x, y = _turned(own, state["theta"].values)
    x += np.repeat(state["x"].values, corners)
    y += np.repeat(state["y"].values, corners)
    return Outlines(ids, own.start, x, y)
