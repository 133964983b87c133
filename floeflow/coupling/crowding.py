# SPDX-License-Identifier: GPL-2.0-or-later
"""Ice that drifted together beyond the sea that there is: what does not fit has ridged.

Discs resist where they touch, but floes that stand for more than their discs, or pass over each
other, may claim more sea than a cell of the grid has. The rest is closed as ridging closes it, and
goes to ridges with `redistribution`: volumes stay.
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from floeflow.coupling.sea.places import SeaPlaces
from floeflow.coupling.sea.shares import build_shares
from floeflow.dynamics.ridging.ridging import close_areas
from floeflow.scene import Scene
from floeflow.state.elements import pair_arrays
from floeflow.state.schema import MOBILE

# Shares smear areas over a cell or two; so much above the sea may be no more than that.
SLACK = 0.02


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
    crowd = np.maximum(shares.claimed, 1.0)
    fits = np.minimum((1.0 + SLACK) * shares.sea / crowd, 1.0)
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
