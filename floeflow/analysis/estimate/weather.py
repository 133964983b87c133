# SPDX-License-Identifier: GPL-2.0-or-later
"""Typical wind, current and weather over a scene's ice and duration.

Analytic forcing is sampled where the ice is; a file is read on the scene's grid in its first,
middle and last window.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from floeflow.scene import Scene

WEATHER = (
    "air_temperature",
    "shortwave_down",
    "longwave_down",
    "snowfall",
    "ocean_heat_flux",
    "specific_humidity",
    "air_pressure",
)
# Wind is sampled at so many moments; more change the means by per cents.
MOMENTS = 5


def wind_and_current(scene: Scene, weight: np.ndarray) -> dict[str, float]:
    """Root mean squares of wind and current, and how the wind varies over the ice.

    Parameters
    ----------
    scene : Scene
        Its forcing is sampled, or read from its file.
    weight : ndarray
        Share of the ice in each cell of the scene's grid, (ny, nx).
    """
    from floeflow.core.grids import scene_grid

    spacing = scene.domain.spacing
    if scene.forcing.source != "analytic":
        fields = _file_fields(scene, ("wind_u", "wind_v", "ocean_u", "ocean_v"))
        winds = list(zip(fields["wind_u"], fields["wind_v"], strict=True))
        currents = list(zip(fields["ocean_u"], fields["ocean_v"], strict=True))
    else:
        from floeflow.core.grids import scene_crs, to_lonlat
        from floeflow.forcings.analytic import cyclone_wind, gyre_current

        x, y = scene_grid(scene.domain).mesh()
        _, lat = to_lonlat(scene_crs(scene.domain), x, y)
        north = float(np.mean(lat)) > 0
        duration = scene.time.windows * scene.time.window
        moments = np.linspace(0.0, duration, MOMENTS)
        winds = [cyclone_wind(scene.forcing.cyclone, x, y, t, north) for t in moments]
        currents = [gyre_current(scene.forcing.gyre, x, y)]
        winds = [(u.reshape(weight.shape), v.reshape(weight.shape)) for u, v in winds]
        currents = [(u.reshape(weight.shape), v.reshape(weight.shape)) for u, v in currents]
    gradients, inflow, uneven = [], [], []
    for u, v in winds:
        (uy, ux), (vy, vx) = np.gradient(u, spacing), np.gradient(v, spacing)
        gradients.append((weight * (ux**2 + uy**2 + vx**2 + vy**2)).sum())
        mean_u, mean_v = (weight * u).sum(), (weight * v).sum()
        uneven.append((weight * ((u - mean_u) ** 2 + (v - mean_v) ** 2)).sum())
        inflow.append((weight * np.maximum(-(ux + vy), 0.0)).sum())
    return {
        "wind": _rms(winds, weight),
        "current": _rms(currents, weight),
        "wind_spread": math.sqrt(float(np.mean(uneven))),
        "wind_gradient": math.sqrt(float(np.mean(gradients))),
        "convergence": float(np.mean(inflow)),
    }


def _rms(pairs: list[tuple[np.ndarray, np.ndarray]], weight: np.ndarray) -> float:
    return math.sqrt(float(np.mean([(weight * (u**2 + v**2)).sum() for u, v in pairs])))


def weather(scene: Scene, weight: np.ndarray) -> dict[str, float]:
    """Means of the weather over ice and duration; as `wind_and_current` takes them.

    Parameters
    ----------
    scene : Scene
        Its keys.
    weight : ndarray
        Of each grid cell, sum 1, (ny, nx).

    Returns
    -------
    dict of float
        By the names of the forcing, SI units.

    Raises
    ------
    FloeError
        For forcing that cannot be read.
    """
    if scene.forcing.source == "analytic":
        from floeflow.forcings.analytic import humidity

        said = scene.forcing.weather
        found = {name: getattr(said, name) for name in WEATHER if hasattr(said, name)}
        return {**found, "specific_humidity": humidity(said)}
    fields = _file_fields(scene, WEATHER)
    return {
        name: float(np.mean([(weight * values).sum() for values in fields[name]]))
        for name in WEATHER
    }


def _file_fields(scene: Scene, names: tuple[str, ...]) -> dict[str, list[np.ndarray]]:
    """Fields (y, x) at the start of the first, middle and last window; zeros where not in the file.

    A file need not hold the weather of a scene without thermodynamics.
    """
    from floeflow.core.errors import FloeError
    from floeflow.core.grids import scene_grid
    from floeflow.forcings.files import forcing_files
    from floeflow.forcings.forcing import make_forcing

    last = scene.time.windows
    windows = sorted({1, (1 + last) // 2, last})
    shape = scene_grid(scene.domain).shape
    found: dict[str, list[np.ndarray]] = {name: [] for name in names}
    for effect in ("wind", "ocean_drag", "thermodynamics"):
        asked = scene.model_copy(update={"effects": (effect,)})
        try:
            parts = [make_forcing(asked, forcing_files(scene), window) for window in windows]
        except FloeError:
            continue
        for name in set(names) & set(map(str, parts[0].data_vars)):
            found[name] = [part[name].values[0] for part in parts]
    return {name: values or [np.zeros(shape)] for name, values in found.items()}
