# SPDX-License-Identifier: GPL-2.0-or-later
"""What stands in for quantities that no forcing file has: formulae, weather, a synthetic year.

One function a stand-in, in the table `STAND_INS`.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from floeflow.core.grids import scene_crs, scene_grid, to_lonlat
from floeflow.forcings import climatology
from floeflow.forcings.analytic import cyclone_wind, gyre_current, humidity
from floeflow.scene.blocks import Scene

Array = NDArray[np.float64]
Fields = dict[str, Array]


def fields(scene: Scene, name: str, stand_in: str, time: Array) -> Fields:
    """Fields of a quantity on the scene grid.

    Parameters
    ----------
    scene : Scene
        Its domain and forcing are read.
    name : str
        ``wind``, ``ocean``, or a scalar's name.
    stand_in : str
        A key of `STAND_INS`.
    time : ndarray
        Seconds since the scene's start, (n,).

    Returns
    -------
    dict of ndarray
        By the forcing's variable: ``wind_u`` and ``wind_v``, ... (n, places), SI.
    """
    return STAND_INS[stand_in](scene, name, time)


def _rest(scene: Scene, name: str, time: Array) -> Fields:
    still = np.zeros((time.size, scene_grid(scene.domain).x.size * scene_grid(scene.domain).y.size))
    return {f"{name}_u": still, f"{name}_v": still}


def _cyclone(scene: Scene, name: str, time: Array) -> Fields:
    grid = scene_grid(scene.domain)
    x, y = grid.mesh()
    _, lat = to_lonlat(scene_crs(scene.domain), x, y)
    northern = bool(lat.mean() > 0)
    winds = [cyclone_wind(scene.forcing.cyclone, x, y, float(t), northern) for t in time]
    return {
        f"{name}_{axis}": np.stack([wind[k].ravel() for wind in winds])
        for k, axis in enumerate("uv")
    }


def _gyre(scene: Scene, name: str, time: Array) -> Fields:
    current = gyre_current(scene.forcing.gyre, *scene_grid(scene.domain).mesh())
    return {
        f"{name}_{axis}": np.broadcast_to(part.ravel(), (time.size, part.size))
        for axis, part in zip("uv", current, strict=True)
    }


def _weather(scene: Scene, name: str, time: Array) -> Fields:
    weather = scene.forcing.weather
    value = humidity(weather) if name == "specific_humidity" else float(getattr(weather, name))
    grid = scene_grid(scene.domain)
    return {name: np.full((time.size, grid.x.size * grid.y.size), value)}


def _climatology(scene: Scene, name: str, time: Array) -> Fields:
    """The synthetic year: of a vector both components, along the scene's axes."""
    names = [f"{name}_u", f"{name}_v"] if name in ("wind", "ocean") else [name]
    return climatology.scene_fields(scene, time, names)


STAND_INS: dict[str, Callable[[Scene, str, Array], Fields]] = {
    "rest": _rest,
    "cyclone": _cyclone,
    "gyre": _gyre,
    "weather": _weather,
    "climatology": _climatology,
}
