# SPDX-License-Identifier: GPL-2.0-or-later
"""What a scene holds before it runs: typical wind, current, ice, weather, and their spread.

All values are means over the scene's ice and duration, so that an estimate needs a dozen numbers.
Analytic forcing is sampled where the ice is; a file is read on the scene's grid in its first,
middle and last window.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from floeflow.analysis.estimate.weather import weather, wind_and_current
from floeflow.core.constants import AIR_DENSITY, EARTH_ROTATION, ICE_DENSITY, SEAWATER_DENSITY

if TYPE_CHECKING:
    import xarray as xr

    from floeflow.scene import Scene


@dataclass(frozen=True)
class Conditions:
    """Means over ice and duration, SI units.

    Parameters
    ----------
    seconds, window : float
        Duration of the scene and of a coupling window.
    latitude : float
        Degrees.
    wind, current : float
        Root mean square speed.
    wind_spread : float
        Root mean square difference of the wind from its mean over the ice, m/s: it tears the pack.
    wind_gradient : float
        Root mean square gradient of the wind, 1/s.
    convergence : float
        Mean convergence of the wind over the ice where it converges, 1/s.
    concentration, thickness, snow : float
        Of the ice at the start; thickness and snow are means over the ice.
    concentration_spread : float
        Standard deviation of the concentration over the sea that has ice.
    coast_share : float
        Share of the ice within an element of land.
    element_size, fetch : float
        Side of a square of an element's area; width of the ice.
    elements : int
        Number aimed at.
    air_temperature, shortwave_down, longwave_down, snowfall, ocean_heat_flux : float
        As in the forcing.
    specific_humidity, air_pressure : float
        As in the forcing.
    air_drag, ocean_drag : float
        Drag coefficients.
    turning_angle : float
        Radians.
    strength, tensile_share : float
        Compressive strength (Pa), share of it in tension.
    friction : float
        Coefficient of friction.
    bond_concentration : float
        Ice that is less dense has no bonds.
    refreeze_time, refreeze_temperature : float
        When elements in touch freeze together.
    mixed_layer_depth, new_ice_thickness : float
        Of the sea under an element, and of the ice that open water makes, m.
    layered : bool
        Whether the ice has layers: its area then shrinks as it thins.
    relaxation_time : float
        In which the sea is drawn to a given temperature, s.
    grounded_share : float
        Share of the ice that the seabed can hold against the mean wind.
    """

    seconds: float
    window: float
    latitude: float
    wind: float
    current: float
    wind_spread: float
    wind_gradient: float
    convergence: float
    concentration: float
    thickness: float
    snow: float
    coast_share: float
    element_size: float
    fetch: float
    elements: int
    air_temperature: float
    shortwave_down: float
    longwave_down: float
    snowfall: float
    ocean_heat_flux: float
    specific_humidity: float
    air_pressure: float
    air_drag: float
    ocean_drag: float
    turning_angle: float
    strength: float
    tensile_share: float
    friction: float
    bond_concentration: float
    refreeze_time: float
    refreeze_temperature: float
    concentration_spread: float
    mixed_layer_depth: float
    new_ice_thickness: float
    layered: bool
    relaxation_time: float
    grounded_share: float = 0.0

    @property
    def coriolis(self) -> float:
        """Coriolis parameter, 1/s."""
        return 2.0 * EARTH_ROTATION * math.sin(math.radians(self.latitude))

    @property
    def mass(self) -> float:
        """Ice mass per area of ice, kg/m2."""
        return ICE_DENSITY * self.thickness

    @property
    def wind_stress(self) -> float:
        """Pa."""
        return AIR_DENSITY * self.air_drag * self.wind**2

    @property
    def nansen(self) -> float:
        """Speed of free drift over the wind's (Leppäranta 2011, eq. 6.7)."""
        if not self.ocean_drag:
            return 0.0
        ratio = AIR_DENSITY * self.air_drag / (SEAWATER_DENSITY * self.ocean_drag)
        return math.sqrt(ratio)

    @property
    def slip(self) -> float:
        """Speed of free drift relative to the water, m/s."""
        return max(self.nansen * self.wind, 1.0e-3)

    @property
    def drag_rate(self) -> float:
        """Rate at which the ocean's drag stops the ice, 1/s."""
        return SEAWATER_DENSITY * self.ocean_drag * self.slip / max(self.mass, 1.0e-6)

    @cached_property
    def closing(self) -> float:
        """Share of the area that convergence of free drift closes over the run."""
        return min(1.0, self.nansen * self.convergence * self.seconds)

    @cached_property
    def compaction(self) -> float:
        """From 0 (floes apart) to 1 (jammed): discs in the plane touch from 0.8 on."""
        packed = self.concentration * (1.0 + self.closing)
        return min(1.0, max(0.0, (packed - 0.7) / 0.2))

    @property
    def crushing(self) -> float:
        """Compressive strength of the pack over the wind's push across it: σ_c h / (τ_a L)."""
        push = self.wind_stress * self.fetch
        return self.strength * self.thickness / push if push > 0 else math.inf

    @property
    def yielding(self) -> float:
        """Share of the closing to which a jammed pack yields: what its strength leaves of it."""
        return self.compaction * max(0.0, 1.0 - self.crushing)

    @property
    def spread(self) -> float:
        """Difference of free drift speeds within the ice, m/s."""
        return self.nansen * self.wind_spread


def conditions(scene: Scene) -> Conditions:
    """Sample a scene.

    Parameters
    ----------
    scene : Scene
        Its mask file and forcing are read; nothing else.

    Raises
    ------
    FloeError
        Where a file is missing or cannot be what it should be.
    """
    from floeflow.core.grids import cell_area, scene_crs, scene_grid, to_lonlat

    grid = scene_grid(scene.domain)
    mask = _mask(scene)
    siconc, sithick = mask["siconc"].values, mask["sithick"].values
    area = cell_area(grid, scene_crs(scene.domain)) * (siconc > 0)
    ice = area * siconc
    _, lat = to_lonlat(scene_crs(scene.domain), *grid.mesh())
    total = float(area.sum())
    weight = ice / ice.sum() if total else np.full(ice.shape, 1.0 / ice.size)
    moving = wind_and_current(scene, weight)
    d = scene.dynamics
    size = math.sqrt(total / scene.packing.elements) if total else grid.spacing
    near_land = _near(mask["land"].values > 0, max(1, round(size / grid.spacing)))
    found = Conditions(
        seconds=scene.time.windows * scene.time.window,
        window=scene.time.window,
        latitude=float((weight * lat.reshape(ice.shape)).sum()),
        **moving,
        concentration=float(ice.sum() / total) if total else 0.0,
        thickness=float((weight * sithick).sum()),
        snow=scene.mask.snow_thickness,
        coast_share=float((weight * near_land).sum()),
        element_size=size,
        fetch=math.sqrt(total),
        elements=scene.packing.elements if total else 0,
        **weather(scene, weight),
        air_drag=d.air_drag,
        ocean_drag=d.ocean_drag,
        turning_angle=math.radians(d.turning_angle),
        strength=d.compressive_strength if d.strength == "constant" else 1.285e6,
        tensile_share=d.tensile_share,
        friction=d.friction_coefficient,
        bond_concentration=scene.packing.bond_concentration,
        refreeze_time=d.refreeze_time,
        refreeze_temperature=d.refreeze_temperature,
        concentration_spread=_spread(siconc, area),
        mixed_layer_depth=scene.column.mixed_layer_depth,
        new_ice_thickness=scene.column.new_ice_thickness,
        layered=scene.column.scheme != "zero_layer",
        relaxation_time=scene.sea.relaxation_time,
    )
    held = _grounded(scene, siconc, sithick, found.wind_stress)
    return replace(found, grounded_share=float((weight * held).sum()))


def _grounded(
    scene: Scene, siconc: np.ndarray, sithick: np.ndarray, wind_stress: float
) -> np.ndarray:
    """Where the seabed can hold the ice against a wind stress (Pa), (ny, nx).

    Thickness is that where there is ice. No depth, no ground.
    """
    from floeflow.forcings.fixed_fields import sea_floor_depth

    g = scene.grounding
    if not (g.file or g.depth):
        return np.zeros(siconc.shape)
    excess = siconc * (sithick - sea_floor_depth(scene) / g.keel_ratio)
    stress = g.strength * np.maximum(excess, 0.0) * np.exp(-g.openness * (1.0 - siconc))
    return np.asarray(stress > wind_stress * siconc, dtype=float)


def _spread(siconc: np.ndarray, area: np.ndarray) -> float:
    """Standard deviation of the concentration over the sea that has ice."""
    total = float(area.sum())
    if not total:
        return 0.0
    mean = float((area * siconc).sum()) / total
    return math.sqrt(float((area * (siconc - mean) ** 2).sum()) / total)


def _mask(scene: Scene) -> xr.Dataset:
    """The ice on the scene grid; land from the file, as the 1 km mask takes seconds."""
    from floeflow.masks.mask import make_mask

    land = "none" if scene.mask.land == "none" else "mask"
    coarse = scene.mask.model_copy(update={"refine": 1, "land": land})
    return make_mask(scene.model_copy(update={"mask": coarse}), None)


def _near(land: np.ndarray, reach: int) -> np.ndarray:
    """Cells within so many cells of land."""
    from scipy.ndimage import binary_dilation

    return np.asarray(binary_dilation(land, iterations=reach)) if land.any() else land
