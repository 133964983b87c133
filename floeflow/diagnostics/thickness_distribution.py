# SPDX-License-Identifier: GPL-2.0-or-later
"""How much of the ice's area is how thick."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.state.schema import MOBILE

Array = NDArray[np.float64]

# Edges of the bins (m); the last bin takes all that is thicker.
EDGES = np.append(np.arange(0.0, 10.01, 0.25), np.inf)


def thickness_areas(state: xr.Dataset, edges: Array = EDGES) -> Array:
    """Area of the ice of the mobile elements by its thickness (m2), (bin,).

    Each category of each element counts with its own mean thickness.

    Parameters
    ----------
    state : xarray.Dataset
        A state or a snapshot.
    edges : ndarray
        Ascending (m), (bin + 1,).

    Returns
    -------
    ndarray
        m2, (bin,).
    """
    mobile = state["type"].values == MOBILE
    share, volume = (state[name].values[mobile] for name in ("ice_fraction", "ice_volume"))
    area = state["area"].values[mobile, None] * share
    thick = np.divide(volume, share, out=np.zeros_like(volume), where=share > 0.0)
    there = share > 0.0
    return np.histogram(thick[there], bins=edges, weights=area[there])[0].astype(float)
