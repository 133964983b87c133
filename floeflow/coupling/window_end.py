# SPDX-License-Identifier: GPL-2.0-or-later
"""Elements that come and go at the end of a window, beside remapping and merging."""

from __future__ import annotations

import xarray as xr

from floeflow.coupling.columns import settle_open_ice
from floeflow.coupling.rims import export_ice, inflow_ice
from floeflow.coupling.sea.birth import OpenIce
from floeflow.coupling.sea.ice import Returned
from floeflow.coupling.sea.places import SeaPlaces
from floeflow.scene import Scene


def end_at_sea(
    scene: Scene, state: xr.Dataset, found: OpenIce | None, places: SeaPlaces | None
) -> tuple[xr.Dataset, dict[str, float], Returned | None]:
    """Let elements come where water froze and go where ice melted or left the rectangle.

    Parameters
    ----------
    scene, state, places
        As for `advance_window`.
    found : OpenIce, optional
        Ice that formed in open water.

    Returns
    -------
    tuple of xarray.Dataset, dict, and Returned or None
        State, terms of the budgets, and ice that melted into the sea as a whole.
    """
    terms: dict[str, float] = {}
    back: Returned | None = None
    if found is not None and places is not None:
        state, terms, back = settle_open_ice(scene, state, found, places, True)
    if "rims" in scene.effects:
        state, left = export_ice(scene, state)
        terms |= left
        if places is not None and scene.rims.inflow:
            state, came = inflow_ice(scene, state, places)
            terms |= came
    return state, terms, back
