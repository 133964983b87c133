# SPDX-License-Identifier: GPL-2.0-or-later
"""Constants of the layered column, one record of numbers that compiled functions can take.

The values are those of the CICE consortium's column physics (Hunke et al. 2015; Icepack 1.4), so
that reference columns can be compared number by number. Temperatures are in degrees Celsius in
all compiled functions: enthalpies are counted from the melting point, and differences of a few
microkelvin matter there.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numba

_UNCOUNTED: dict[str, Any] = {"_nrt": False}
jit: Any = numba.njit(error_model="numpy", nogil=True, **_UNCOUNTED)
"""Compile a small function that compiled functions call; what Python calls is in kernel.py.

Without counting references to arrays (`_nrt`), which takes half the time otherwise: such functions
can view arrays but not make any, for which there is `jit_making`.

Their arguments carry no types: Numba finds them, and mypy is told not to ask in those files.
"""

jit_making: Any = numba.njit(error_model="numpy", nogil=True)
"""Compile a function that makes arrays."""

TINY = 1e-11  # smallest area fraction and thickness (m) that count as ice
KELVIN = 273.15


class Physics(NamedTuple):
    """Constants, SI units, temperatures in degrees Celsius.

    Parameters
    ----------
    ice_density, snow_density, water_density : float
        kg/m3.
    heat_ice, heat_water : float
        Specific heat of fresh ice (snow too) and of sea water (J/kg/K).
    fusion, vapour : float
        Latent heat of fusion and of vaporisation (J/kg); sublimation takes their sum.
    melting_slope : float
        Freezing point depression (K per 1e-3 of salinity).
    bubbly : bool
        Conductivity of Pringle et al. (2007), else of Maykut and Untersteiner (1971).
    fresh_conductivity, snow_conductivity : float
        W/m/K; the former is used where not ``bubbly``.
    brine_conductivity : float
        Coefficient of salinity over temperature (W/m per 1e-3) where not ``bubbly``.
    least_conductivity : float
        Of ice (W/m/K).
    least_snow : float
        Snow thinner than this (m) neither conducts nor changes its temperature.
    top_salinity_floor, bottom_salinity : float
        Of the fixed salinity profile (1e-3).
    reference_salinity : float
        Of the ice in exchanges of salt with the ocean (1e-3).
    emissivity, stefan_boltzmann : float
        Of ice and snow; W/m2/K4.
    heat_air, heat_vapour : float
        J/kg/K.
    virtual : float
        Virtual temperature: 1 + virtual * humidity.
    karman, gravity : float
        1; m/s2.
    forcing_height, reference_height : float
        Of wind, temperature and humidity; of the neutral coefficients (m).
    ice_roughness : float
        m.
    least_wind : float
        m/s.
    windless : float
        Sensible heat exchange in calm air (W/m2/K), Jordan et al. (1999).
    stability_iterations : int
        Of the turbulent fluxes.
    vapour_ice, vapour_ice_exponent, vapour_sea, vapour_sea_exponent : float
        Saturation density is vapour * exp(-exponent / T) (kg/m3; K), T in K.
    albedo_ice_visible, albedo_ice_infrared, albedo_snow_visible, albedo_snow_infrared : float
        Of cold thick ice and cold snow.
    albedo_ice_warming, albedo_snow_visible_warming, albedo_snow_infrared_warming : float
        Decrease from ``albedo_ramp`` below melting to melting.
    albedo_ramp : float
        K.
    albedo_ocean, albedo_thickness, snow_patchiness : float
        Of the ocean; ice as thick (m) has the albedo of thick ice; snow (m) that covers half.
    penetrating, extinction : float
        Share of the absorbed visible light that enters bare ice; 1/m.
    ocean_transfer, least_friction_velocity : float
        Stanton number of the ice's bottom; m/s.
    lateral_rate, lateral_power : float
        Melt rate of sides m/s per K**power (Maykut and Perovich 1987).
    floe_diameter, floe_shape : float
        m; Steele (1992).
    largest_potential : float
        Freezing or melting potential that a step may use (W/m2).
    new_ice_thickness, least_thickness : float
        Of new ice in open water; of the thinnest category's ice (m).
    surface_tolerance, flux_tolerance : float
        Of the iteration: K, W/m2.
    iterations : int
        Of the temperatures, before the sure method takes over.
    """

    ice_density: float = 917.0
    snow_density: float = 330.0
    water_density: float = 1026.0
    heat_ice: float = 2106.0
    heat_water: float = 4218.0
    fusion: float = 334000.0
    vapour: float = 2.501e6
    melting_slope: float = 0.054
    bubbly: bool = True
    fresh_conductivity: float = 2.03
    snow_conductivity: float = 0.3
    brine_conductivity: float = 0.13
    least_conductivity: float = 0.1
    least_snow: float = 1e-4
    top_salinity_floor: float = 0.1
    bottom_salinity: float = 3.2
    reference_salinity: float = 4.0
    emissivity: float = 0.985
    stefan_boltzmann: float = 5.67e-8
    heat_air: float = 1005.0
    heat_vapour: float = 1810.0
    virtual: float = 0.606
    karman: float = 0.4
    gravity: float = 9.80616
    forcing_height: float = 10.0
    reference_height: float = 10.0
    ice_roughness: float = 5e-4
    least_wind: float = 1.0
    windless: float = 1.0
    stability_iterations: int = 5
    vapour_ice: float = 11637800.0
    vapour_ice_exponent: float = 5897.8
    vapour_sea: float = 627572.4
    vapour_sea_exponent: float = 5107.4
    albedo_ice_visible: float = 0.78
    albedo_ice_infrared: float = 0.36
    albedo_snow_visible: float = 0.98
    albedo_snow_infrared: float = 0.70
    albedo_ice_warming: float = 0.075
    albedo_snow_visible_warming: float = 0.10
    albedo_snow_infrared_warming: float = 0.15
    albedo_ramp: float = 1.0
    albedo_ocean: float = 0.06
    albedo_thickness: float = 0.3
    snow_patchiness: float = 0.02
    penetrating: float = 0.7
    extinction: float = 1.4
    ocean_transfer: float = 0.006
    least_friction_velocity: float = 5e-4
    lateral_rate: float = 1.6e-6
    lateral_power: float = 1.36
    floe_diameter: float = 300.0
    floe_shape: float = 0.66
    largest_potential: float = 1000.0
    new_ice_thickness: float = 0.05
    least_thickness: float = 0.01
    surface_tolerance: float = 5e-4
    flux_tolerance: float = 9e-4
    iterations: int = 30
