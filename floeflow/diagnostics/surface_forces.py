# SPDX-License-Identifier: GPL-2.0-or-later
"""Stresses of air and water and body forces per area of ice, at the instants of gridded output.

They follow from the gridded ice and the scene's own forcing on the same grid, by the balance of
docs/theory/forces.md. What the scene's effects lack is absent. Elements with hardly any ice, which
move as if they had more, count with the ice that they have.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floeflow.core.constants import AIR_DENSITY, ICE_DENSITY, SEAWATER_DENSITY, SNOW_DENSITY
from floeflow.scene import Scene

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

# Effects whose forcing the forces need.
NEEDED = ("wind", "ocean_drag", "coriolis", "tilt", "turning_angle")


def forcing_at(scene: Scene, seconds: float) -> dict[str, Array]:
    """Wind, current and Coriolis parameter on the scene's grid at an instant of the run, (ny, nx).

    Parameters
    ----------
    scene : Scene
        Its effects say what is there: wind_u, wind_v, ocean_u, ocean_v (m/s), coriolis (1/s).
    seconds : float
        Since its start; a boundary takes the end of the window before it.

    Returns
    -------
    dict of ndarray
        m/s, the Coriolis parameter 1/s, (ny, nx), by name; those that the scene's effects read.
    """
    # A second to import, and what makes no grid has no need of it.
    from floeflow.core.grids import scene_grid
    from floeflow.forcings.climatology import scene_fields
    from floeflow.forcings.window import window_forcing
    from floeflow.scene.effects import forcing_variables

    asked = scene.model_copy(update={"effects": tuple(e for e in scene.effects if e in NEEDED)})
    names = list(forcing_variables(asked.effects))
    if not names:
        return {}
    if scene.forcing.source == "climatology":
        time = np.array([seconds])
        shape = scene_grid(scene.domain).shape
        found = scene_fields(asked, time, [name for name in names if name != "coriolis"])
        made = {name: values[0].reshape(shape) for name, values in found.items()}
        if "coriolis" in names:
            made["coriolis"] = _coriolis(scene)
        return made
    window = max(1, int(np.ceil(seconds / scene.time.window - 1e-9)))
    with tempfile.TemporaryDirectory() as scratch:
        forcing = window_forcing(asked, window, Path(scratch))
    at = int(np.abs(forcing["time"].values - seconds).argmin())
    return {
        name: np.asarray(forcing[name].values if name == "coriolis" else forcing[name].values[at])
        for name in names
    }


def _coriolis(scene: Scene) -> Array:
    from floeflow.core.constants import EARTH_ROTATION
    from floeflow.core.grids import scene_crs, scene_grid, to_lonlat

    _, lat = to_lonlat(scene_crs(scene.domain), *scene_grid(scene.domain).mesh())
    return np.asarray(2.0 * EARTH_ROTATION * np.sin(np.radians(lat)))


def surface_forces(
    scene: Scene, fields: Mapping[str, Array], forcing: Mapping[str, Array]
) -> dict[str, Array]:
    """Forces per area of ice (N/m2), (ny, nx), NaN where there is none.

    Parameters
    ----------
    scene : Scene
        Its effects and ``dynamics`` are read.
    fields : mapping
        siu, siv (m/s), sithick and, with snow, sisnthick (m), as
        `floeflow.diagnostics.gridded.gridded_fields` makes them.
    forcing : mapping
        From `forcing_at`.

    Returns
    -------
    dict of ndarray
        Of CMIP6's names: sistrxdtop, sistrydtop of the wind; sistrxubot, sistryubot of the water;
        siforcecoriolx, siforcecorioly; siforcetiltx, siforcetilty.
    """
    effects, dynamics = set(scene.effects), scene.dynamics
    ice = fields["siu"] + 1j * fields["siv"]
    mass = ICE_DENSITY * fields["sithick"]
    if "sisnthick" in fields:
        mass = mass + SNOW_DENSITY * np.nan_to_num(fields["sisnthick"])
    found: dict[str, Array] = {}

    def add(name: str, values: NDArray[Any]) -> None:
        for axis, part in (("x", values.real), ("y", values.imag)):
            found[name.format(axis)] = np.where(np.isfinite(ice), part, np.nan)

    water: Complex | None = None
    if "ocean_u" in forcing:
        water = forcing["ocean_u"] + 1j * forcing["ocean_v"]
    if "wind" in effects:
        wind = forcing["wind_u"] + 1j * forcing["wind_v"]
        blown = wind - ice if dynamics.relative_wind else wind
        add("sistr{}dtop", AIR_DENSITY * dynamics.air_drag * np.abs(blown) * blown)
    if "ocean_drag" in effects and water is not None:
        turn = np.ones(ice.shape, dtype=np.complex128)
        if "turning_angle" in effects:
            turn = np.exp(1j * np.radians(dynamics.turning_angle) * np.sign(forcing["coriolis"]))
        slip = water - ice
        drag = SEAWATER_DENSITY * dynamics.ocean_drag * np.abs(slip) * turn * slip
        add("sistr{}ubot", drag)
    if "coriolis" in effects:
        add("siforcecoriol{}", -1j * mass * forcing["coriolis"] * ice)
    if "tilt" in effects and water is not None:
        add("siforcetilt{}", 1j * mass * forcing["coriolis"] * water)
    return found
