# SPDX-License-Identifier: GPL-2.0-or-later
"""Forcing of one coupling window, whatever its source."""

from __future__ import annotations

from pathlib import Path

import xarray as xr

from floeflow.forcings.analytic import make_analytic, write_cf
from floeflow.forcings.files import forcing_files
from floeflow.forcings.forcing import make_forcing
from floeflow.scene import Scene


def window_forcing(scene: Scene, window: int, scratch: Path) -> xr.Dataset:
    """Make the forcing of a window on the scene's grid.

    Parameters
    ----------
    scene : Scene
        Its domain, forcing, effects and time are read.
    window : int
        From 1.
    scratch : Path
        Folder for a file that lives as long as the call: formulae go the way of a user's file, so
        that both are read alike.

    Returns
    -------
    xarray.Dataset
        As `floeflow.forcings.forcing.make_forcing` returns it.

    Raises
    ------
    FloeError
        For what is missing, does not cover scene or window, or cannot be.
    """
    if scene.forcing.source != "analytic":
        return make_forcing(scene, forcing_files(scene), window)
    path = scratch / f"analytic_{window:04d}.nc"
    scratch.mkdir(parents=True, exist_ok=True)
    try:
        write_cf(make_analytic(scene, window), path)
        return make_forcing(scene, path, window)
    finally:
        path.unlink(missing_ok=True)
