# SPDX-License-Identifier: GPL-2.0-or-later
"""Physical constants that more than one stage uses, SI.

Values as in CICE and Icepack's documentation (Hunke et al. 2015) unless stated.
"""

ICE_DENSITY = 917.0  # kg m-3
SNOW_DENSITY = 330.0  # kg m-3
SEAWATER_DENSITY = 1026.0  # kg m-3
AIR_DENSITY = 1.3  # kg m-3
CONTACT_SHEAR_RATIO = 0.5  # tangential over normal stiffness where unbonded ice touches
EARTH_ROTATION = 7.292115e-5  # rad s-1, WGS 84
EARTH_RADIUS = 6.371e6  # m
ZERO_CELSIUS = 273.15  # K
