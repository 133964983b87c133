# SPDX-License-Identifier: GPL-2.0-or-later
"""Physical constants that more than one stage uses, SI.

Values as in CICE and Icepack's documentation (Hunke et al. 2015) unless stated.
"""

ICE_DENSITY = 917.0  # kg m-3
SNOW_DENSITY = 330.0  # kg m-3
SEAWATER_DENSITY = 1026.0  # kg m-3
AIR_DENSITY = 1.3  # kg m-3
CONTACT_SHEAR_RATIO = 0.5  # tangential over normal stiffness where unbonded ice touches
# Side of a hexagon over the diameter of the circle in it: how long discs touch that tile a plane.
EDGE_SHARE = 0.577350269189626
EARTH_ROTATION = 7.292115e-5  # rad s-1, WGS 84
EARTH_RADIUS = 6.371e6  # m
ZERO_CELSIUS = 273.15  # K
STEFAN_BOLTZMANN = 5.67e-8  # W m-2 K-4
MELTING_SLOPE = 0.054  # K per 1e-3 of salinity
LATENT_FUSION = 3.34e5  # J kg-1
LATENT_VAPOUR = 2.501e6  # J kg-1
# Density of vapour at saturation over ice, VAPOUR_ICE exp(-VAPOUR_ICE_EXPONENT / T).
VAPOUR_ICE = 11637800.0  # kg m-3
VAPOUR_ICE_EXPONENT = 5897.8  # K
HEAT_AIR = 1005.0  # J kg-1 K-1
GAS_AIR = 287.05  # J kg-1 K-1, dry air
