# SPDX-License-Identifier: GPL-2.0-or-later
"""Bonds that freeze in a window: how cold it was where, and how fast ice grows there."""

from __future__ import annotations

import numpy as np
import xarray as xr

from floeflow.column.forcing import sample_series
from floeflow.column.params import ColumnParams, zero_layer_params
from floeflow.column.settings import column_settings
from floeflow.dynamics.bonds.refreeze import Cold, refreeze
from floeflow.dynamics.motion import engine_params
from floeflow.scene import Scene
from floeflow.state.elements import Arrays


def column_params(scene: Scene) -> ColumnParams:
    """Constants of zero-layer ice in the scene.

    Parameters
    ----------
    scene : Scene
        Its keys.

    Returns
    -------
    ColumnParams
        SI units; temperatures in K.
    """
    return zero_layer_params(column_settings(scene))


def freeze_window(
    scene: Scene,
    state: xr.Dataset,
    touched: Arrays,
    forcing: xr.Dataset,
    window: tuple[float, float],
) -> tuple[xr.Dataset, int]:
    """Let cracks and contacts of a window refreeze; see `floeflow.dynamics.bonds.refreeze`.

    Parameters
    ----------
    scene : Scene
        The scene.
    state : xarray.Dataset
        State after the dynamics and the column of the window.
    touched : dict of ndarray
        Contact table at the window's start.
    forcing : xarray.Dataset
        The window's forcing on the scene's grid.
    window : tuple of float
        Start and end of the window, s since the scene's start.

    Returns
    -------
    tuple of xarray.Dataset and int
        New state, and the number of bonds that formed.
    """
    ice, d = column_params(scene), scene.dynamics
    growth = 2.0 * ice.keys.ice_conductivity / (ice.ice_density * ice.latent_fusion)
    cold = Cold(
        *(d.refreeze_time, d.refreeze_temperature, d.refreeze_thickness),
        *(ice.freezing_temperature, growth, scene.packing.coast_bonds),
    )

    def air(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        sample = sample_series(forcing, ("air_temperature",), x, y)
        return sample(0.5 * (window[0] + window[1]))["air_temperature"]

    return refreeze(state, touched, air, cold, engine_params(scene), window[1] - window[0])
