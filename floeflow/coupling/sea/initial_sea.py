# SPDX-License-Identifier: GPL-2.0-or-later
"""The mixed layer at the scene's start."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.column.params import Settings
from floeflow.coupling.sea.places import SeaPlaces, cell_means
from floeflow.coupling.sea.water import DIMS, freezing_points

Array = NDArray[np.float64]


def first_sea(
    places: SeaPlaces, mask: xr.Dataset, settings: Settings
) -> dict[str, tuple[tuple[str, str], Array]]:
    """Variables of the sea at the start, (sea_y, sea_x) each.

    Water under ice is at its freezing point, open water has the temperature that the mask's file
    gives it, but not below freezing. What the file does not tell is the scene's salinity, and
    water at its freezing point.

    Parameters
    ----------
    places : SeaPlaces
        The sea.
    mask : xarray.Dataset
        Mask on the mask grid; its ``sst`` (K) and ``sss`` (1e-3) are read where they are there.
    settings : Settings
        Of the columns.

    Returns
    -------
    dict of (tuple of str, ndarray)
        Dimensions and values by name: temperature (K), pending freeze (J/m2), salinities (1e-3),
        (sea_y, sea_x) each.
    """
    everywhere = np.ones(mask["land"].shape)
    salinity = np.full(places.area.shape, settings.ocean_salinity)
    if "sss" in mask and settings.scheme != "zero_layer":
        known = cell_means(places, mask, mask["sss"].values, everywhere)
        salinity = np.where(np.isfinite(known), known, salinity)
    temperature = freezing_points(salinity, settings)
    if "sst" in mask:
        share = 1.0 - mask["siconc"].values
        warmer = cell_means(places, mask, mask["sst"].values, share) - temperature
        part = cell_means(places, mask, share, everywhere)
        gain = np.maximum(warmer, 0.0) * part
        temperature = temperature + np.where(np.isfinite(gain), gain, 0.0)
    values = {
        "sea_temperature": temperature,
        "pending_freeze": np.zeros_like(temperature),
        "sea_salinity": salinity,
        "deep_salinity": salinity.copy(),
    }
    return {name: (DIMS, value) for name, value in values.items()}
