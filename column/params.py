# SPDX-License-Identifier: GPL-2.0-or-later
"""Constants of the column: one frozen record, so that a run's physics is one value.

Broadband albedos are the CCSM3 ones (Briegleb et al. 2004) at 52 % visible light. The bulk
coefficients are those of Parkinson and Washington (1979), the conductivities those of
Semtner (1976).
"""

from __future__ import annotations

from dataclasses import dataclass

from floeflow.constants import ICE_DENSITY, SNOW_DENSITY, ZERO_CELSIUS


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
