# SPDX-License-Identifier: GPL-2.0-or-later
"""Constants of the column: one frozen record, so that a run's physics is one value.

Broadband albedos are the CCSM3 ones (Briegleb et al. 2004) at 52 % visible light. The bulk
coefficients are those of Parkinson and Washington (1979), the conductivities those of
Semtner (1976).
"""

from __future__ import annotations

from dataclasses import dataclass

from floeflow.core.constants import ICE_DENSITY, SNOW_DENSITY, ZERO_CELSIUS


@dataclass(frozen=True)
class ColumnParams:
    """Constants of the column's schemes, SI units.

    Parameters
    ----------
    new_ice_thickness : float
        Thickness at which new ice gathers in open water (m).
    ocean_salinity : float
        Salinity of the ocean (1e-3); sets the freezing point.
    ice_density, snow_density : float
        kg/m3.
    ice_conductivity, snow_conductivity : float
        W/m/K.
    latent_fusion, latent_vapour : float
        J/kg; sublimation takes their sum.
    melting_temperature : float
        Of the surface of ice and snow (K).
    emissivity : float
        Long-wave emissivity of ice, snow and water.
    transfer_heat, transfer_vapour : float
        Bulk coefficients of the turbulent fluxes.
    albedo_ice_cold, albedo_ice_melting, albedo_snow_cold, albedo_snow_melting : float
        Cold applies from ``albedo_ramp`` below melting downwards.
    albedo_ocean : float
        Of open water, and of ice as its thickness goes to nothing.
    albedo_ramp : float
        Width of the ramp from melting to cold albedo (K).
    albedo_thickness : float
        From this thickness (m) on, ice has the albedo of thick ice.
    snow_patchiness : float
        Snow thickness (m) at which half of the ice shows through.
    mixed_layer_depth : float
        Depth of the slab of sea under an element (m), read where it has one.
    frazil, lateral_melt : bool
        Whether open water freezes, and whether warm water melts the sides of the ice; what would
        have done it is the ocean's then.
    """

    new_ice_thickness: float = 0.1
    ocean_salinity: float = 34.0
    ice_density: float = ICE_DENSITY
    snow_density: float = SNOW_DENSITY
    ice_conductivity: float = 2.04
    snow_conductivity: float = 0.31
    latent_fusion: float = 3.34e5
    latent_vapour: float = 2.501e6
    melting_temperature: float = ZERO_CELSIUS
    emissivity: float = 0.97
    transfer_heat: float = 1.75e-3
    transfer_vapour: float = 1.75e-3
    albedo_ice_cold: float = 0.58
    albedo_ice_melting: float = 0.50
    albedo_snow_cold: float = 0.85
    albedo_snow_melting: float = 0.72
    albedo_ocean: float = 0.06
    albedo_ramp: float = 1.0
    albedo_thickness: float = 0.3
    snow_patchiness: float = 0.02
    mixed_layer_depth: float = 20.0
    frazil: bool = True
    lateral_melt: bool = True

    @property
    def freezing_temperature(self) -> float:
        """Freezing point of the ocean (K), 54 mK lower for each unit of salinity."""
        return ZERO_CELSIUS - 0.054 * self.ocean_salinity

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

    @property
    def needs_sun(self) -> bool:
        """Whether the forcing has to tell the height of the sun."""
        many = self.light == "delta_eddington" and self.scheme != "zero_layer"
        return many and self.has("shortwave")

    def has(self, process: str) -> bool:
        """Whether a process is simulated."""
        return process in self.processes


def zero_layer_params(settings: Settings) -> ColumnParams:
    """Constants of zero-layer ice under these settings."""
    return ColumnParams(
        new_ice_thickness=settings.new_ice_thickness,
        ocean_salinity=settings.ocean_salinity,
        mixed_layer_depth=settings.mixed_layer_depth,
        frazil=settings.has("frazil"),
        lateral_melt=settings.has("lateral_melt"),
    )
