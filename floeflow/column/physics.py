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
import numpy as np

from floeflow.column.unsolved import LARGEST_LEFT
from floeflow.core import constants
from floeflow.scene.physics import ColumnPhysics

_LEAN: dict[str, Any] = {"_nrt": False, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
jit: Any = numba.njit(error_model="numpy", nogil=True, **_LEAN)
"""Compile a small function that only compiled functions call; what Python calls is in kernel.py.

Types in their signatures are for readers and mypy: Numba finds those of each call by itself.
Without counting references to arrays (`_nrt`), which takes half the time otherwise: they can view
arrays but not make any, for which there is `jit_making`. A function that counts (`jit_making`, and
what Python calls) must take no array, view or record of them from one that does not: it would give
back a reference that nobody took. Without wrappers for Python, which take a third of the
compilation.

Never with fast-math: a function that Numba has just compiled calls the first copies of the
functions in it, which were optimised alone, one loaded from the cache calls its own copies, which
were optimised together. Sums that may be taken in any order then depend on which it was.
"""

jit_making: Any = numba.njit(error_model="numpy", nogil=True)
"""Compile a function that makes arrays."""

TINY = 1e-11  # smallest area fraction and thickness (m) that count as ice
KELVIN = constants.ZERO_CELSIUS

# What scenes can change has its default there.
_KEYS = ColumnPhysics()


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
    mushy : bool
        Mushy layers with salt of their own (Turner et al. 2013), else Bitz and Lipscomb (1999).
    mixed, frazil : bool
        A mixed layer stores heat, else the sea stays at its freezing point; open water freezes.
    delta_eddington : bool
        Light of many directions (Briegleb and Light 2007), else that of CCSM3.
    drained_by_depth : bool
        The upper quarter of the ice is drained (light of many directions), else the first layer
        counts as a quarter of the ice, as in the column physics that made the reference.
    redistribute_light : bool
        Light that would bring a layer near its melting point is absorbed at the surface instead.
    ponds : bool
        Level-ice melt ponds (Hunke et al. 2013).
    ponds_cover_level : bool
        Ponds as in the column physics that made the reference: those that have water spread over
        all level ice at each step, with their depth. Else area follows the water.
    flush_time : float
        Time (s) in which at most 0.5 % of the brine of the tightest layer, as thick as a seventh of
        the ice, is washed out; 0: a step and a layer, as in the column physics that made the
        reference.
    pond_lids : bool
        Ponds freeze over (Hunke et al. 2013), else they shrink in the cold (Holland et al. 2012).
    flushing : bool
        Ponds drain through mush and carry its salt off (Turner et al. 2013).
    flooding : bool
        Snow below the water line becomes ice.
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
    snow_grain_tuning, ice_scatter_tuning, pond_scatter_tuning : float
        Standard deviations by which snow grains are smaller, ice and ponded ice scatter more.
    melting_grain, fresh_grain : float
        Radius of grains of melting snow, and the least radius (um).
    grain_warming : float
        Snow grains grow from this far below melting (K).
    algae : float
        Absorption of visible light by algae in the lowest ice layer (1/m over half a metre).
    snow_cover_depth : float
        Snow that covers all ice (m); 0: any does that counts.
    lid_snow_depth : float
        Snow on lids that hides ponds (m).
    least_catch, most_catch : float
        Share of the melt water that ponds catch at no ice and at full cover.
    pond_aspect : float
        Depth of a pond over its share of the ice (m).
    pond_drain_time : float
        Time in which ponds drain through flaws of mush (s).
    pond_seepage : float
        Factor of the flow through Bitz-Lipscomb ice; 0: none.
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
    mush_ice_conductivity, mush_brine_conductivity : float
        Of a mush without and of nothing but brine (W/m/K).
    viscosity, diffusivity : float
        Of brine (kg/m/s) and its diffusivity of heat (m2/s).
    channel_radius, critical_rayleigh, channel_aspect : float
        Of rapid gravity drainage (m, 1, 1); Turner et al. (2013).
    slow_drainage, slow_liquid : float
        Rate of slow drainage (m/s/K, negative) and the liquid fraction that it leaves.
    bottom_liquid : float
        Liquid fraction of new ice at the bottom.
    frazil_liquid, frazil_freshening, warmest_frazil : float
        Liquid fraction of new ice in open water, its salinity below the sea's (1e-3), degC.
    surface_tolerance, flux_tolerance : float
        Of the iteration: K, W/m2.
    iterations, fallback_iterations, mush_iterations : int
        Of the temperatures, before the second method takes over; of that; of the surface of mush.
    largest_left : float
        Temperatures that still change by more (K) when their iterations end stop the run.
    """

    ice_density: float = constants.ICE_DENSITY
    snow_density: float = constants.SNOW_DENSITY
    water_density: float = constants.SEAWATER_DENSITY
    heat_ice: float = 2106.0
    heat_water: float = 4218.0
    fusion: float = constants.LATENT_FUSION
    vapour: float = constants.LATENT_VAPOUR
    melting_slope: float = constants.MELTING_SLOPE
    mushy: bool = False
    mixed: bool = True
    frazil: bool = True
    delta_eddington: bool = False
    drained_by_depth: bool = False
    redistribute_light: bool = False
    ponds: bool = False
    ponds_cover_level: bool = True
    flush_time: float = 0.0
    pond_lids: bool = True
    flushing: bool = True
    flooding: bool = True
    bubbly: bool = True
    fresh_conductivity: float = _KEYS.ice_conductivity
    snow_conductivity: float = _KEYS.snow_conductivity
    brine_conductivity: float = 0.13
    least_conductivity: float = 0.1
    least_snow: float = 1e-4
    top_salinity_floor: float = 0.1
    bottom_salinity: float = 3.2
    emissivity: float = _KEYS.emissivity
    stefan_boltzmann: float = constants.STEFAN_BOLTZMANN
    heat_air: float = constants.HEAT_AIR
    heat_vapour: float = 1810.0
    virtual: float = 0.606
    karman: float = 0.4
    gravity: float = 9.80616
    forcing_height: float = 10.0
    reference_height: float = 10.0
    ice_roughness: float = _KEYS.ice_roughness
    least_wind: float = 1.0
    windless: float = 1.0
    stability_iterations: int = 5
    vapour_ice: float = constants.VAPOUR_ICE
    vapour_ice_exponent: float = constants.VAPOUR_ICE_EXPONENT
    vapour_sea: float = 627572.4
    vapour_sea_exponent: float = 5107.4
    albedo_ice_visible: float = _KEYS.albedo_ice_visible
    albedo_ice_infrared: float = _KEYS.albedo_ice_infrared
    albedo_snow_visible: float = _KEYS.albedo_snow_visible
    albedo_snow_infrared: float = _KEYS.albedo_snow_infrared
    albedo_ice_warming: float = _KEYS.albedo_ice_warming
    albedo_snow_visible_warming: float = _KEYS.albedo_snow_visible_warming
    albedo_snow_infrared_warming: float = _KEYS.albedo_snow_infrared_warming
    albedo_ramp: float = 1.0
    albedo_ocean: float = _KEYS.albedo_ocean
    albedo_thickness: float = _KEYS.albedo_thickness
    snow_patchiness: float = _KEYS.snow_patchiness
    penetrating: float = 0.7
    extinction: float = 1.4
    snow_grain_tuning: float = _KEYS.snow_grain_tuning
    ice_scatter_tuning: float = _KEYS.ice_scatter_tuning
    pond_scatter_tuning: float = _KEYS.pond_scatter_tuning
    melting_grain: float = 1500.0
    fresh_grain: float = 100.0
    grain_warming: float = 1.5
    algae: float = 0.6
    snow_cover_depth: float = 0.0
    lid_snow_depth: float = 0.03
    least_catch: float = 0.15
    most_catch: float = 1.0
    pond_aspect: float = _KEYS.pond_aspect
    pond_drain_time: float = 864000.0
    pond_seepage: float = 1e-3
    ocean_transfer: float = _KEYS.ocean_transfer
    least_friction_velocity: float = 5e-4
    lateral_rate: float = 1.6e-6
    lateral_power: float = 1.36
    floe_diameter: float = _KEYS.floe_diameter
    floe_shape: float = 0.66
    largest_potential: float = 1000.0
    new_ice_thickness: float = 0.05
    least_thickness: float = 0.01
    mush_ice_conductivity: float = 2.3
    mush_brine_conductivity: float = 0.5375
    viscosity: float = 1.79e-3
    diffusivity: float = 8.824e-8
    channel_radius: float = 5e-4
    critical_rayleigh: float = 10.0
    channel_aspect: float = 1.0
    slow_drainage: float = -5e-8
    slow_liquid: float = 0.05
    bottom_liquid: float = 0.85
    frazil_liquid: float = 0.75
    frazil_freshening: float = 3.0
    warmest_frazil: float = -0.1
    surface_tolerance: float = 5e-4
    flux_tolerance: float = 9e-4
    iterations: int = 30
    fallback_iterations: int = 200
    mush_iterations: int = 100
    largest_left: float = LARGEST_LEFT


def as_records(p: Physics) -> Any:
    """Return the constants as a NumPy array of one record.

    Compiled functions take its address, where of the tuple they would pass all numbers in every
    call: that compiles much faster.

    Parameters
    ----------
    p : Physics
        Constants, SI.

    Returns
    -------
    ndarray
        Structured, (1,), with a field for each constant, aligned as C aligns them.
    """
    kinds = {float: "f8", int: "i8", bool: "?"}
    defaults = Physics._field_defaults
    dtype = np.dtype([(name, kinds[type(defaults[name])]) for name in p._fields], align=True)
    return np.array([tuple(p)], dtype)
