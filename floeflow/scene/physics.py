# SPDX-License-Identifier: GPL-2.0-or-later
"""Constants of the columns that modellers tune, with their defaults: the same for all schemes.

Values of Hunke et al. (2015) and Icepack unless stated. What no scene can change stands in
`floeflow.column.physics`.
"""

from __future__ import annotations

from typing import Literal

from floeflow.scene.block import Block, key


class ColumnPhysics(Block):
    """Constants of the columns (thermodynamics), for all schemes unless a line names some.

    The albedos are those of ``column.light: ccsm3`` and of zero_layer, which takes 0.52 of the
    visible and 0.48 of the infrared one.
    """

    air_density: float = key(
        0.0,
        "Density of the air in the turbulent fluxes; 0: from its pressure, temperature and "
        "humidity. Icepack's column alone takes 1.3.",
        "kg/m3",
        ge=0,
        le=2,
    )
    emissivity: float = key(
        0.985,
        "Long-wave emissivity of ice and snow, and of open water beside zero-layer ice.",
        "1",
        gt=0,
        le=1,
    )
    snow_conductivity: float = key(0.3, "Heat conductivity of snow.", "W/m/K", ge=0.03, le=2)
    ice_conductivity: float = key(
        2.03,
        "Heat conductivity of ice without brine (zero_layer; bonds that freeze; lids of ponds; "
        "bl99 with maykut_untersteiner).",
        "W/m/K",
        ge=0.5,
        le=5,
    )
    conductivity: Literal["pringle", "maykut_untersteiner"] = key(
        "pringle",
        "Conductivity of layers with brine (bl99): Pringle et al. 2007, or Maykut and Untersteiner "
        "1971.",
    )
    albedo_ice_visible: float = key(
        0.78, "Albedo of cold thick bare ice below 0.7 um.", "1", ge=0, le=1
    )
    albedo_ice_infrared: float = key(
        0.36, "Albedo of cold thick bare ice above 0.7 um.", "1", ge=0, le=1
    )
    albedo_ice_warming: float = key(
        0.075, "By how much both are less where bare ice melts.", "1", ge=0, le=0.3
    )
    albedo_snow_visible: float = key(0.98, "Albedo of cold snow below 0.7 um.", "1", ge=0, le=1)
    albedo_snow_infrared: float = key(0.70, "Albedo of cold snow above 0.7 um.", "1", ge=0, le=1)
    albedo_snow_visible_warming: float = key(
        0.10, "By how much it is less below 0.7 um where snow melts.", "1", ge=0, le=0.3
    )
    albedo_snow_infrared_warming: float = key(
        0.15, "By how much it is less above 0.7 um where snow melts.", "1", ge=0, le=0.3
    )
    albedo_thickness: float = key(
        0.3, "From this thickness on ice has the albedo of thick ice.", "m", gt=0, le=5
    )
    albedo_ocean: float = key(0.06, "Albedo of open water.", "1", ge=0, le=1)
    snow_patchiness: float = key(
        0.02, "Thickness of the snow that covers half of the ice.", "m", gt=0, le=1
    )
    snow_grain_tuning: float = key(
        1.5,
        "Standard deviations by which snow grains are smaller (delta_eddington).",
        "1",
        ge=-3,
        le=3,
    )
    ice_scatter_tuning: float = key(
        0.0, "Standard deviations by which ice scatters more (delta_eddington).", "1", ge=-3, le=3
    )
    pond_scatter_tuning: float = key(
        0.0,
        "Standard deviations by which ice under ponds scatters more (delta_eddington).",
        "1",
        ge=-3,
        le=3,
    )
    pond_aspect: float = key(
        0.8, "Depth of a pond over its share of the level ice (ponds).", "m", gt=0, le=10
    )
    bulk_transfer: float = key(
        1.75e-3,
        "Coefficient of sensible and latent heat (zero_layer; Parkinson and Washington 1979).",
        "1",
        gt=0,
        le=0.01,
    )
    ice_roughness: float = key(
        5e-4, "Roughness of the ice for heat from the air (bl99, mushy).", "m", gt=0, le=0.1
    )
    ocean_transfer: float = key(
        0.006,
        "Stanton number of the ice's bottom (mixed_layer; Maykut and McPhee 1995).",
        "1",
        gt=0,
        le=0.1,
    )
    floe_diameter: float = key(
        300.0,
        "Diameter of floes, for melt at their sides (lateral_melt on a mixed_layer).",
        "m",
        ge=1,
        le=1e5,
    )


_BROADBAND = {
    "albedo_ice_visible",
    "albedo_ice_infrared",
    "albedo_ice_warming",
    "albedo_snow_visible",
    "albedo_snow_infrared",
    "albedo_snow_visible_warming",
    "albedo_snow_infrared_warming",
    "albedo_thickness",
    "snow_patchiness",
}
_SCATTERED = {"snow_grain_tuning", "ice_scatter_tuning", "pond_scatter_tuning"}


def unread_keys(physics: ColumnPhysics, scheme: str, light: str, ponds: bool) -> list[str]:
    """Keys that differ from their defaults and that a scheme, kind of light and ponds leave out.

    Parameters
    ----------
    physics : ColumnPhysics
        Block ``physics`` of a scene.
    scheme : str
        Of the column.
    light : str
        ``ccsm3`` or ``delta_eddington``.
    ponds : bool
        Whether ponds are simulated.

    Returns
    -------
    list of str
        Names of keys.
    """
    layered = scheme != "zero_layer"
    scattered = layered and light == "delta_eddington"
    unread = set(_BROADBAND if scattered else _SCATTERED)
    unread |= {"bulk_transfer"} if layered else {"ice_roughness"}
    unread |= {"conductivity"} if scheme != "bl99" else set()
    unread |= set() if ponds else {"pond_aspect", "pond_scatter_tuning"}
    defaults = ColumnPhysics()
    fields = ColumnPhysics.model_fields
    return [n for n in fields if n in unread and getattr(physics, n) != getattr(defaults, n)]
