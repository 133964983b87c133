# SPDX-License-Identifier: GPL-2.0-or-later
"""Tendencies of the ice's mass and area by process, under CMIP6's names, as means over the scene.

The series tell of whole scenes, not of cells: each tendency is one number a window, per area of the
scene's sea. What the scene's effects lack is absent.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.core.constants import ICE_DENSITY
from floeflow.diagnostics.budgets import rim_terms

Array = NDArray[np.float64]

# Terms of the budget of ice volume by CMIP6's name and sign.
MASS = {
    "sidmassgrowthbot": ("growth_base", 1.0, "growth at the base"),
    "sidmassgrowthwat": ("growth_new_ice", 1.0, "new ice on open water"),
    "sidmasssi": ("growth_snow_ice", 1.0, "snow that turned into ice"),
    "sidmassmelttop": ("growth_melt_top", 1.0, "melt at the top"),
    "sidmassmeltbot": ("growth_melt_base", 1.0, "melt at the base"),
    "sidmasslat": ("growth_melt_lateral", 1.0, "melt at the sides"),
    "sidmassevapsubl": ("growth_sublimation", -1.0, "sublimation, upwards"),
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
        On ``window``: sidmass* (kg m-2 s-1), whose sum sidmassth is; sidmassdyn, what came in
        through the sides; sidconcdyn and sidconcth (1/s), where ice that leaves counts as motion.
    """
    if not sea > 0.0:
        return xr.Dataset()
    found: dict[str, tuple[str, Array, dict[str, str]]] = {}
    per = 1.0 / (sea * window)

    def add(name: str, values: Array, unit: str, text: str) -> None:
        attrs = {"units": unit, "long_name": f"{text}, mean over the sea", "cell_methods": METHOD}
        found[name] = ("window", values * per, attrs)

    growth = [str(name) for name in scalars.data_vars if str(name).startswith("growth_")]
    for name, (term, sign, text) in MASS.items():
        if term in scalars:
            add(name, sign * ICE_DENSITY * scalars[term].values, "kg m-2 s-1", text)
    if growth:
        total = np.asarray(sum(scalars[name].values for name in growth))
        add("sidmassth", ICE_DENSITY * total, "kg m-2 s-1", "growth less melt")
    came = ICE_DENSITY * _through_sides(scalars, "ice_volume")
    add("sidmassdyn", came, "kg m-2 s-1", "ice that came in through the sides, less what left")
    if growth and "ice_area_dynamics" in scalars:
        before, moved, after = (
            scalars[f"ice_area_{moment}"].values for moment in ("start", "dynamics", "end")
        )
        sides = _through_sides(scalars, "ice_area")
        add("sidconcth", after - moved - sides, "s-1", "ice area by growth and melt")
        add("sidconcdyn", moved - before + sides, "s-1", "ice area by motion and through the sides")
    return xr.Dataset(found)


def _through_sides(scalars: xr.Dataset, what: str) -> Array:
    """What the effect rims let in less what they took out in each window."""
    zero = np.zeros(scalars.sizes["window"])
    return np.asarray(sum((np.asarray(v) for v in rim_terms(scalars, what).values()), zero))
