# SPDX-License-Identifier: GPL-2.0-or-later
"""Ice that drifted together beyond the sea that there is: what does not fit has ridged.

Discs resist where they touch, but floes that stand for more than their discs, or pass over each
other, may claim more sea than a cell of the grid has. The rest is closed as ridging closes it, and
goes to ridges with `redistribution`: volumes stay.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from floeflow.coupling.sea.places import SeaPlaces
from floeflow.coupling.sea.shares import Shares, build_shares
from floeflow.dynamics.ridging.ridging import close_areas
from floeflow.scene import Scene
from floeflow.state.elements import pair_arrays
from floeflow.state.schema import MOBILE
from floeflow.transfer import Grid

Array = NDArray[np.float64]

# Shares smear areas over a cell or two, and a remap spreads what is local over neighbours.
SLACK = 0.1
# Regions are so many elements wide. What they hold beyond their sea would be pushed out of them by
# the next remap, from one to the other as far as the ice edge, so less of it may be.
REGION, REGION_SLACK = 5.0, 0.001
# Thinner ice is no weaker (m).
THINNEST = 0.1
# What a region has too much is taken from no element smaller than this share of the mean one: thin
# ice alone in a bay has no neighbour that it could join, and a small disc sets the time step.
SMALLEST = 0.2


def around(grid: Grid, width: float, cells: Array) -> Array:
    """Mean of the cells of a grid around each one, those beyond the rim being 0.

    Parameters
    ----------
    grid : Grid
        The scene's grid.
    width : float
        Of the square around a cell (m).
    cells : ndarray
        Values, (cells,).

    Returns
    -------
    ndarray
        In the unit of the cells, (cells,).
    """
    sides = [max(1, round(width / step)) for step in reversed(grid.spacing)]
    field = cells.reshape(grid.shape)
    return np.asarray(uniform_filter(field, sides, mode="constant")).ravel()


def crowded(shares: Shares, grid: Grid, area: Array, thickness: Array) -> Array:
    """Area of each element that the sea has no room for (m2), (n,).

    What a region has too much is taken from its weak ice: the work of ridging grows with the
    square of the thickness (Rothrock 1975), so an element gives by one over that.

    Parameters
    ----------
    shares : Shares
        Of the elements.
    grid : Grid
        The scene's grid.
    area : ndarray
        Effective areas of the elements (m2), (n,).
    thickness : ndarray
        Their ice (m3 per m2), (n,).

    Returns
    -------
    ndarray
        m2, (n,), below the element's own area.
    """
    if not len(area):
        return np.zeros(0)
    local = np.minimum((1.0 + SLACK) * shares.sea / np.maximum(shares.claimed, 1.0), 1.0)
    closed = area * (1.0 - np.asarray(shares.matrix @ local))
    width = REGION * float(np.sqrt(area.mean()))
    sea, claimed = (around(grid, width, v) for v in (shares.sea, shares.give(area - closed)))
    fits = np.minimum((1.0 + REGION_SLACK) * sea / np.maximum(claimed, 1.0), 1.0)
    wide = (area - closed) * (1.0 - np.asarray(shares.matrix @ fits))
    weak = np.maximum(thickness, THINNEST) ** -2.0
    even, uneven = (around(grid, width, shares.give(amount)) for amount in (wide, wide * weak))
    factor = np.divide(even, uneven, out=np.zeros_like(even), where=uneven > 0.0)
    most = np.clip(area - closed - SMALLEST * area.mean(), 0.0, 0.5 * (area - closed))
    return closed + np.minimum(wide * weak * shares.read(factor), most)


def close_crowded(
    scene: Scene, state: xr.Dataset, places: SeaPlaces
) -> tuple[xr.Dataset, dict[str, float]]:
    """Close the area that elements claim beyond the sea.

    Parameters
    ----------
    scene : Scene
        The scene.
    state : xarray.Dataset
        State after the dynamics of a window.
    places : SeaPlaces
        The sea.

    Returns
    -------
    tuple of xarray.Dataset and dict
        State, and ``crowded_area`` (m2): what was closed.
    """
    mobile = np.flatnonzero(state["type"].values == MOBILE)
    x, y, area = (state[name].values[mobile] for name in ("x", "y", "area"))
    shares = build_shares(x, y, area, places.grid, places.area, places.pull)
    thickness = state["ice_volume"].values[mobile].sum(axis=1)
    closed = np.zeros(state.sizes["element"])
    closed[mobile] = crowded(shares, places.grid, area, thickness)
    total = float(closed.sum())
    if total > 0.0:
        least = scene.dynamics.minimum_thickness
        end = float(state.attrs["time"]) + scene.time.window
        # No contact has closed for it: discs shrink about their centres.
        held = {
            kind: pair_arrays(state, kind)
            for kind in ("contact", "wall_contact")
            if f"{kind}_ridge_closing" in state
        }
        leads = "redistribution" not in scene.effects
        state = close_areas(state, closed, least, held, end, leads)
    return state, {"crowded_area": total}
