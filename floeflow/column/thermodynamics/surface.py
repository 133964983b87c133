# SPDX-License-Identifier: GPL-2.0-or-later
"""The surface of zero-layer ice and of leads beside it: albedo, fluxes and their balance.

Constant transfer coefficients (Maykut and Untersteiner 1971; Parkinson and Washington 1979). Of
what lies below the surface only the conductance to the freezing bottom is used. Layered ice has
`boundary_layer.py` and `floeflow.column.shortwave`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from floeflow.column.params import ColumnParams
from floeflow.column.state import Array, ColumnForcing
from floeflow.column.unsolved import LARGEST_LEFT, UnsolvedError
from floeflow.core.constants import GAS_AIR, HEAT_AIR, STEFAN_BOLTZMANN

MAX_ITERATIONS = 60
TOLERANCE = 1e-9  # K
COLDEST = 100.0  # K: below every surface under a sky, above the pole of the vapour formula


@dataclass(frozen=True)
class SurfaceFluxes:
    """Fluxes into a surface (W/m2), and the derivative of their sum with its temperature.

    Parameters
    ----------
    net : ndarray
        Short-wave, long-wave, sensible and latent heat together.
    slope : ndarray
        d(net)/dT, negative (W/m2/K).
    vapour : ndarray
        Vapour that leaves (kg/m2/s).
    """

    net: Array
    slope: Array
    vapour: Array


def saturation(temperature: Array, pressure: Array, ice: bool) -> tuple[Array, Array]:
    """Specific humidity at saturation and its derivative, by Murray (1967).

    Parameters
    ----------
    temperature : ndarray
        K, above 40 K.
    pressure : ndarray
        Pa.
    ice : bool
        Over ice, else over water.

    Returns
    -------
    tuple of ndarray
        kg/kg and kg/kg/K.
    """
    a, b = (9.5, 7.66) if ice else (7.5, 35.86)
    a *= np.log(10.0)
    offset = temperature - b
    vapour = 611.0 * np.exp(a * (temperature - 273.16) / offset)
    slope = vapour * a * (273.16 - b) / offset**2
    dry = pressure - 0.378 * vapour
    return 0.622 * vapour / dry, 0.622 * pressure * slope / dry**2


def surface_fluxes(
    temperature: Array,
    forcing: ColumnForcing,
    albedo: Array | float,
    ice: bool,
    params: ColumnParams,
) -> SurfaceFluxes:
    """Fluxes into a surface of given temperature (Maykut and Untersteiner 1971, eq. 2).

    Parameters
    ----------
    temperature : ndarray
        Of the surface (K), (n, ncat).
    forcing : ColumnForcing
        Its arrays (n,).
    albedo : ndarray or float
        (n, ncat).
    ice : bool
        Vapour rises from ice or snow and takes the heat of sublimation, else from water.
    params : ColumnParams
        Constants.

    Returns
    -------
    SurfaceFluxes
        Net flux into the surface (W/m2), its slope over the surface's temperature (W/m2/K) and the
        vapour that leaves it (kg/m2/s), (n, ncat) each.
    """
    air = forcing.air_temperature[:, None]
    pressure = forcing.air_pressure[:, None]
    density = params.keys.air_density or pressure / (GAS_AIR * air)
    exchange = density * forcing.wind_speed[:, None]
    latent = params.latent_sublimation if ice else params.latent_vapour
    humidity, humidity_slope = saturation(temperature, pressure, ice)
    heat = exchange * HEAT_AIR * params.keys.bulk_transfer
    moisture = exchange * params.keys.bulk_transfer
    vapour = moisture * (humidity - forcing.specific_humidity[:, None])
    emitted = params.keys.emissivity * STEFAN_BOLTZMANN * temperature**3
    net = (
        (1.0 - albedo) * forcing.shortwave_down[:, None]
        + params.keys.emissivity * forcing.longwave_down[:, None]
        - emitted * temperature
        + heat * (air - temperature)
        - latent * vapour
    )
    slope = -4.0 * emitted - heat - latent * moisture * humidity_slope
    return SurfaceFluxes(net, slope, vapour)


def ice_albedo(thickness: Array, snow: Array, temperature: Array, params: ColumnParams) -> Array:
    """Broadband albedo of ice and snow, in the form of CCSM3 (Briegleb et al. 2004).

    Parameters
    ----------
    thickness, snow : ndarray
        Of ice and of snow on it (m).
    temperature : ndarray
        Of the surface (K). Give the one of the step's start: an albedo that falls while the
        surface warms would make its balance ambiguous.
    params : ColumnParams
        Constants.

    Returns
    -------
    ndarray
        1, of the shape of the arguments.
    """
    cold = (params.melting_temperature - temperature) / params.albedo_ramp
    cold = np.clip(cold, 0.0, 1.0)
    ice = params.albedo_ice_melting + cold * (params.albedo_ice_cold - params.albedo_ice_melting)
    thick = np.arctan(4.0 * thickness) / np.arctan(4.0 * params.keys.albedo_thickness)
    ice = params.keys.albedo_ocean + np.minimum(thick, 1.0) * (ice - params.keys.albedo_ocean)
    brightening = params.albedo_snow_cold - params.albedo_snow_melting
    white = params.albedo_snow_melting + cold * brightening
    covered = snow / (snow + params.keys.snow_patchiness)
    return np.asarray(ice + covered * (white - ice))


def balance(
    first: Array,
    conductance: Array,
    forcing: ColumnForcing,
    albedo: Array,
    params: ColumnParams,
) -> tuple[Array, Array, SurfaceFluxes]:
    """Surface temperature at which the fluxes from above and from below balance.

    Solves ``net(T) + conductance (T_freezing - T) = 0`` by Newton's method. The left side falls
    with T and is concave, so that Newton's steps come down to the root from above and never pass
    it; the first one may come from below and is cut at melting. Both facts make it safe without a
    second method; a lower bound keeps it where the vapour formula holds.

    Parameters
    ----------
    first : ndarray
        First guess (K), (n, ncat).
    conductance : ndarray
        Of ice and snow together (W/m2/K), (n, ncat).
    forcing : ColumnForcing
        Its arrays (n,).
    albedo : ndarray
        (n, ncat).
    params : ColumnParams
        Constants.

    Returns
    -------
    temperature : ndarray
        K, at most melting.
    excess : ndarray
        Flux left for melting at the top (W/m2), zero below melting.
    fluxes : SurfaceFluxes
        At that temperature.

    Raises
    ------
    UnsolvedError
        Where temperatures still change when the iterations end, or are not numbers.
    """
    top, bottom = params.melting_temperature, params.freezing_temperature

    def fluxes_at(temperature: Array) -> SurfaceFluxes:
        return surface_fluxes(temperature, forcing, albedo, True, params)

    melting = fluxes_at(np.full_like(first, top)).net + conductance * (bottom - top)
    melts = melting > 0.0
    temperature = np.where(melts, top, np.clip(first, COLDEST, top))
    done, near = melts, melts
    for _ in range(MAX_ITERATIONS):
        if done.all():
            break
        fluxes = fluxes_at(temperature)
        gap = fluxes.net + conductance * (bottom - temperature)
        change = gap / (conductance - fluxes.slope)
        new = np.where(done, temperature, np.clip(temperature + change, COLDEST, top))
        # A column stops by itself, so that its bits do not depend on its neighbours in the slice.
        done = done | (np.abs(new - temperature) < TOLERANCE)
        near = done | (np.abs(new - temperature) <= LARGEST_LEFT)
        temperature = new
    if not near.all():
        rows = np.flatnonzero(~near.all(axis=1))
        raise UnsolvedError(rows, len(near), LARGEST_LEFT)
    return temperature, np.where(melts, melting, 0.0), fluxes_at(temperature)
