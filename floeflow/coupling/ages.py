# SPDX-License-Identifier: GPL-2.0-or-later
"""Age of the ice: how long ago it froze on open water, or since the start of the run.

An element has one age, the mean over its mass. Ice that grows below or from snow takes the age of
the ice that it grows on, as in CICE. Ice that froze on open water in a window has age 0 at its end.
What joins, leaves or is dealt out anew carries its age with its mass, as the schema says.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.core.constants import ICE_DENSITY, SNOW_DENSITY
from floeflow.state.schema import MOBILE

Array = NDArray[np.float64]


def grow_older(state: xr.Dataset, new_ice: Array | float, seconds: float) -> xr.Dataset:
    """State whose ice is older by a window, but for what froze on open water in it.

    Parameters
    ----------
    state : xarray.Dataset
        At the window's end, with `ice_age` as at its start.
    new_ice : ndarray or float
        Ice that froze on the open water of each mobile element (m3), (n,).
    seconds : float
        Length of the window.

    Returns
    -------
    xarray.Dataset
        With ice_age (s) of the mobile elements moved on; the state itself without that effect.
    """
    mobile = state["type"].values == MOBILE
    load = ICE_DENSITY * state["ice_volume"].values.sum(axis=1)
    if "snow_volume" in state:
        load = load + SNOW_DENSITY * state["snow_volume"].values.sum(axis=1)
    mass = (state["area"].values * load)[mobile]
    new = np.broadcast_to(ICE_DENSITY * np.asarray(new_ice), mass.shape)
    old = np.divide(mass - new, mass, out=np.zeros_like(mass), where=mass > 0.0)
    age = state["ice_age"].values.copy()
    # Ice that froze and melted in the window leaves less than what froze.
    age[mobile] = (age[mobile] + seconds) * np.clip(old, 0.0, 1.0)
    return state.assign(ice_age=("element", age))
