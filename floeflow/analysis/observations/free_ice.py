# SPDX-License-Identifier: GPL-2.0-or-later
"""Free drift under a run's own wind and current: what a buoy would do without neighbours."""

from __future__ import annotations

import tempfile
from functools import lru_cache
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from floeflow.analysis.observations.run_files import FinishedRun
from floeflow.core.constants import ICE_DENSITY
from floeflow.diagnostics.analyses import Analyses
from floeflow.diagnostics.wind_drift import FreeDrift, free_drift
from floeflow.forcings.window import window_forcing

Complex = NDArray[np.complex128]


class FreeIce:
    """Displacements of free ice of the run's mean thickness."""

    def __init__(self, run: FinishedRun) -> None:
        scene = run.scene
        wanted = tuple(e for e in scene.effects if e in ("wind", "ocean_drag"))
        self.scene = scene.model_copy(update={"effects": wanted})
        numbers = run.numbers
        area, volume = (
            numbers[f"{name}_start"] + numbers[f"{name}_end"] for name in ("ice_area", "ice_volume")
        )
        self.drags: FreeDrift = Analyses(scene, mass=[(area, ICE_DENSITY * volume)]).free_drift
        self.window = scene.time.window
        self.forcing = lru_cache(maxsize=16)(self._forcing)

    def _forcing(self, window: int) -> xr.Dataset:
        with tempfile.TemporaryDirectory() as scratch:
            return window_forcing(self.scene, window, Path(scratch))

    def displacement(self, window: int, places: Complex) -> Complex:
        """Displacement in a window at places (m, complex), NaN where they are.

        Parameters
        ----------
        window : int
            Number of the window.
        places : Complex
            x + i y (m), (n,).

        Returns
        -------
        Complex
            (n,).
        """
        out = np.full(places.shape, complex(np.nan, np.nan))
        known = np.isfinite(places)
        if not known.any():
            return out
        forcing = self.forcing(window)
        wind = self._mean(forcing, "wind", places[known])
        speed = np.abs(wind)
        free = free_drift(speed, self.drags)
        unit = np.divide(wind, speed, out=np.zeros_like(wind), where=speed > 0)
        drift = free * unit
        if "ocean_u" in forcing:
            drift = drift + self._mean(forcing, "ocean", places[known])
        out[known] = drift * self.window
        return out

    @staticmethod
    def _mean(forcing: xr.Dataset, name: str, places: Complex) -> Complex:
        """Mean over the window of a vector at places, bilinear; the edge holds outside."""
        time = forcing["time"].values
        at = [
            (place - axis[0]) / (axis[1] - axis[0])
            for place, axis in (
                (places.imag, forcing["y"].values),
                (places.real, forcing["x"].values),
            )
        ]
        u, v = (
            map_coordinates(
                np.trapezoid(forcing[f"{name}_{part}"].values, time, axis=0) / (time[-1] - time[0]),
                at,
                order=1,
                mode="nearest",
            )
            for part in "uv"
        )
        return np.asarray(u + 1j * v)
