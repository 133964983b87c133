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

# Shares smear areas over a cell or two; so much above the sea may be no more than that.
SLACK = 0.02
# Regions are so many elements wide. What they hold beyond their sea would be pushed out of them by
# the next remap, from one to the other as far as the ice edge, so less of it may be.
REGION, REGION_SLACK = 5.0, 0.001


def fitting(shares: Shares, grid: Grid, area: Array) -> Array:
    """Share of what elements claim in each cell that the sea there and around it has room for.

    Parameters
    ----------
    shares : Shares
        Of the elements.
    grid : Grid
        The scene's grid.
    area : ndarray
        Effective areas of the elements (m2), (n,).

    Returns
    -------
    ndarray
        0 to 1, (cells,).
    """
    fits = np.minimum((1.0 + SLACK) * shares.sea / np.maximum(shares.claimed, 1.0), 1.0)
    if not len(area):
        return fits
    wide = REGION * float(np.sqrt(area.mean()))
    sides = [max(1, round(wide / step)) for step in reversed(grid.spacing)]
    sea, claimed = (
        uniform_filter(cells.reshape(grid.shape), sides, mode="constant").ravel()
        for cells in (shares.sea, shares.claimed * fits)
    )
    return fits * np.minimum((1.0 + REGION_SLACK) * sea / np.maximum(claimed, 1.0), 1.0)


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
    shares = build_shares(x, y, area, places.grid, places.area)
    fits = fitting(shares, places.grid, area)
    closed = np.zeros(state.sizes["element"])
    closed[mobile] = area * (1.0 - np.asarray(shares.matrix @ fits))
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
