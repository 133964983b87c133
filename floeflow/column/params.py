# SPDX-License-Identifier: GPL-2.0-or-later
"""Constants of zero-layer columns, and what a run asks of its columns.

Constants that scenes can change come from their block ``physics``, as those of the layered
schemes do; broadband albedos are the two of CCSM3 (Briegleb et al. 2004) at 52 % visible light.
"""

from __future__ import annotations

from dataclasses import dataclass

from floeflow.core.constants import (
    ICE_DENSITY,
    LATENT_FUSION,
    LATENT_VAPOUR,
    MELTING_SLOPE,
    SNOW_DENSITY,
    ZERO_CELSIUS,
)
from floeflow.scene.physics import ColumnPhysics

# Shares of short-wave radiation below and above 0.7 um (Hunke et al. 2015).
VISIBLE, INFRARED = 0.52, 0.48

_KEYS = ColumnPhysics()


def broadband(visible: float, infrared: float) -> float:
    """Mean of two albedos over the light of the sun.

    Parameters
    ----------
    visible : float
        Albedo below and above 0.7 um (1).
    infrared : float
        Albedo below and above 0.7 um (1).

    Returns
    -------
    float
        With 52 % of the light visible (Hunke et al. 2015).
    """
    return VISIBLE * visible + INFRARED * infrared


@dataclass(frozen=True)
class ColumnParams:
    """Constants of zero-layer columns, SI units.

    Parameters
    ----------
    new_ice_thickness : float
        Thickness at which new ice gathers in open water (m).
    ocean_salinity : float
        Salinity of the ocean (1e-3); sets the freezing point.
    ice_density, snow_density : float
        kg/m3.
    latent_fusion, latent_vapour : float
        J/kg; sublimation takes their sum.
    melting_temperature : float
        Of the surface of ice and snow (K).
    albedo_ramp : float
        Width of the ramp from melting to cold albedo (K).
    mixed_layer_depth : float
        Depth of the slab of sea under an element (m), read where it has one.
    frazil, lateral_melt : bool
        Whether open water freezes, and whether warm water melts the sides of the ice; what would
        have done it is the ocean's then.
    keys : ColumnPhysics
        Constants that scenes can change.
    """

    new_ice_thickness: float = 0.1
    ocean_salinity: float = 34.0
    ice_density: float = ICE_DENSITY
    snow_density: float = SNOW_DENSITY
    latent_fusion: float = LATENT_FUSION
    latent_vapour: float = LATENT_VAPOUR
    melting_temperature: float = ZERO_CELSIUS
    albedo_ramp: float = 1.0
    mixed_layer_depth: float = 20.0
    frazil: bool = True
    lateral_melt: bool = True
    keys: ColumnPhysics = _KEYS

    @property
    def albedo_ice_cold(self) -> float:
        """Of thick bare ice colder than the ramp."""
        return broadband(self.keys.albedo_ice_visible, self.keys.albedo_ice_infrared)

    @property
    def albedo_ice_melting(self) -> float:
        """Of thick bare ice that melts."""
        return self.albedo_ice_cold - self.keys.albedo_ice_warming

    @property
    def albedo_snow_cold(self) -> float:
        """Of snow colder than the ramp."""
        return broadband(self.keys.albedo_snow_visible, self.keys.albedo_snow_infrared)

    @property
    def albedo_snow_melting(self) -> float:
        """Of snow that melts."""
        keys = self.keys
        warming = keys.albedo_snow_visible_warming, keys.albedo_snow_infrared_warming
        return self.albedo_snow_cold - broadband(*warming)

    @property
    def freezing_temperature(self) -> float:
        """Freezing point of the ocean (K), 54 mK lower for each unit of salinity."""
        return ZERO_CELSIUS - MELTING_SLOPE * self.ocean_salinity

    @property
    def latent_sublimation(self) -> float:
        """Latent heat of sublimation (J/kg)."""
        return self.latent_fusion + self.latent_vapour

    @property
    def ice_energy(self) -> float:
        """Energy that melts a cubic metre of ice (J/m3); the zero-layer ice holds no heat."""
        return self.ice_density * self.latent_fusion

    @property
    def snow_energy(self) -> float:
        """Energy that melts a cubic metre of snow (J/m3)."""
        return self.snow_density * self.latent_fusion


@dataclass(frozen=True)
class Settings:
    """What a run asks of its columns.

    Parameters
    ----------
    scheme : str
        zero_layer, bl99 or mushy.
    processes : tuple of str
        Of snow, shortwave, lateral_melt, frazil, mixed_layer: what is simulated beside the
        vertical growth and melt.
    categories, layers : int
        Thickness categories; layers of ice, where the scheme has any.
    step : float
        Longest time step (s).
    new_ice_thickness : float
        Thickness at which new ice gathers in open water (m).
    ocean_salinity : float
        1e-3.
    mixed_layer_depth : float
        m.
    light : str
        ccsm3, or delta_eddington, which asks for the height of the sun; of layered ice.
    variant : str
        convergent, or icepack: ponds, flushing and light in melting layers.
    physics : ColumnPhysics
        Constants that scenes can change.
    """

    scheme: str = "zero_layer"
    processes: tuple[str, ...] = ("snow", "shortwave", "lateral_melt", "frazil")
    categories: int = 1
    layers: int = 7
    step: float = 3600.0
    new_ice_thickness: float = 0.1
    ocean_salinity: float = 34.0
    mixed_layer_depth: float = 20.0
    light: str = "ccsm3"
    variant: str = "convergent"
    physics: ColumnPhysics = _KEYS

    @property
    def needs_sun(self) -> bool:
        """Whether the forcing has to tell the height of the sun."""
        many = self.light == "delta_eddington" and self.scheme != "zero_layer"
        return many and self.has("shortwave")

    def has(self, process: str) -> bool:
        """Whether a process is simulated.

        Parameters
        ----------
        process : str
            Name of the process.

        Returns
        -------
        bool
            True if the settings name it.
        """
        return process in self.processes


def zero_layer_params(settings: Settings) -> ColumnParams:
    """Constants of zero-layer ice under these settings.

    Parameters
    ----------
    settings : Settings
        What the column is asked for.

    Returns
    -------
    ColumnParams
        SI units; temperatures in K.
    """
    return ColumnParams(
        new_ice_thickness=settings.new_ice_thickness,
        ocean_salinity=settings.ocean_salinity,
        mixed_layer_depth=settings.mixed_layer_depth,
        frazil=settings.has("frazil"),
        lateral_melt=settings.has("lateral_melt"),
        keys=settings.physics,
    )
