# SPDX-License-Identifier: GPL-2.0-or-later
"""Tendencies of the ice's mass and area by process, under CMIP6's names, as means over the scene.

Each tendency is one number a window, per area of the scene's sea, from the sums in the series.
`floeflow.diagnostics.gridded_tendencies` has them by cells. What the scene's effects lack is
absent.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.core.constants import ICE_DENSITY
from floeflow.diagnostics.budgets import rim_terms

Array = NDArray[np.float64]

# Terms of the budget of ice volume by CMIP6's name and sign. On a mixed layer, new ice that melts
# back in the same window is none, and the last ice of elements melts from below.
MASS: dict[str, tuple[tuple[tuple[str, float], ...], str]] = {
    "sidmassgrowthbot": ((("growth_base", 1.0),), "growth at the base"),
    "sidmassgrowthwat": (
        (("growth_new_ice", 1.0), ("sea_melted_back", -1.0)),
        "new ice on open water",
    ),
    "sidmasssi": ((("growth_snow_ice", 1.0),), "snow that turned into ice"),
    "sidmassmelttop": ((("growth_melt_top", 1.0),), "melt at the top"),
    "sidmassmeltbot": (
        (("growth_melt_base", 1.0), ("growth_dissolved", 1.0), ("sea_melted_back", 1.0)),
        "melt at the base",
    ),
    "sidmasslat": ((("growth_melt_lateral", 1.0),), "melt at the sides"),
    "sidmassevapsubl": ((("growth_sublimation", -1.0),), "sublimation, upwards"),
}
METHOD = "area: mean where sea time: mean"


def tendencies(scalars: xr.Dataset, sea: float, window: float) -> xr.Dataset:
    """Tendencies of each window.

    Parameters
    ----------
    scalars : xarray.Dataset
        From `floeflow.diagnostics.collect.read_series`.
    sea : float
        Area of the scene's sea (m2).
    window : float
        Length of the windows (s).

    Returns
    -------
    xarray.Dataset
        On ``window``: sidmass* (kg m-2 s-1), whose sum sidmassth is (sidmassevapsubl counts
        upwards); sidmassdyn, what came in through the sides; sidconcdyn and sidconcth (1/s), where
        ice that leaves counts as motion.
    """
    if not sea > 0.0:
        return xr.Dataset()
    found: dict[str, tuple[str, Array, dict[str, str]]] = {}
    per = 1.0 / (sea * window)

    def add(name: str, values: Array, unit: str, text: str) -> None:
        attrs = {"units": unit, "long_name": f"{text}, mean over the sea", "cell_methods": METHOD}
        found[name] = ("window", values * per, attrs)

    growth = [str(name) for name in scalars.data_vars if str(name).startswith("growth_")]
    for name, (terms, text) in MASS.items():
        if terms[0][0] in scalars:
            made = sum(sign * scalars[term].values for term, sign in terms if term in scalars)
            add(name, ICE_DENSITY * np.asarray(made), "kg m-2 s-1", text)
    if growth:
        total = np.asarray(sum(scalars[name].values for name in growth))
        add("sidmassth", ICE_DENSITY * total, "kg m-2 s-1", "growth less melt")
    came = ICE_DENSITY * _through_sides(scalars, "ice_volume")
    add("sidmassdyn", came, "kg m-2 s-1", "ice that came in through the sides, less what left")
    if "ice_area_grown" in scalars:
        changed = scalars["ice_area_end"].values - scalars["ice_area_start"].values
        names = ("ice_area_grown", "ice_area_dissolved")
        grown = np.asarray(sum(scalars[name].values for name in names if name in scalars))
        add("sidconcth", grown, "s-1", "ice area by growth and melt")
        text = "ice area by motion, ridging and through the sides"
        add("sidconcdyn", changed - grown, "s-1", text)
    return xr.Dataset(found)


def _through_sides(scalars: xr.Dataset, what: str) -> Array:
    """What the effect rims let in less what they took out in each window."""
    zero = np.zeros(scalars.sizes["window"])
    return np.asarray(sum((np.asarray(v) for v in rim_terms(scalars, what).values()), zero))
