# SPDX-License-Identifier: GPL-2.0-or-later
"""Growth and melt of one category at its top and bottom, sublimation, snowfall, flooding.

Order as in Bitz and Lipscomb (1999) and Hunke et al. (2015): hoar, growth at the bottom, then from
the top down sublimation and melt, melt from the bottom up, snowfall, flooding, equal layers. Each
process takes the energy of the very ice that it moves, so energy closes term by term.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from floeflow.column.physics import TINY, jit
from floeflow.column.thermodynamics.enthalpy import ice_enthalpy, snow_enthalpy
from floeflow.column.thermodynamics.layers import even_out, flood
from floeflow.column.thermodynamics.mush import liquid_fraction, melted_enthalpy, mush_enthalpy

if TYPE_CHECKING:
    from floeflow.column.physics import Physics
    from floeflow.column.records import Water
    from floeflow.column.thermodynamics.bl99 import Balance
    from floeflow.column.thermodynamics.profile import Profile


class Change(NamedTuple):
    """What a step moved in one category, per area of its ice.

    Parameters
    ----------
    ice, snow : float
        Thickness after (m).
    growth, snow_ice : float
        Ice grown at the bottom, and made of flooded snow (m).
    melt_top, melt_bottom, melt_snow : float
        m of ice, ice and snow.
    sublimation_ice, sublimation_snow : float
        Left as vapour; negative where hoar settled (m of ice and snow).
    snowfall, drowned : float
        Snow fallen; snow whose ice went, which the sea melts (m of snow).
    spare : float
        Energy that found nothing to melt, less what melts drowned snow in the sea (J/m2).
    salt : float
        Gained by mush in growth and melt (1e-3 m).
    """

    ice: float
    snow: float
    growth: float
    snow_ice: float
    melt_top: float
    melt_bottom: float
    melt_snow: float
    sublimation_ice: float
    sublimation_snow: float
    snowfall: float
    drowned: float
    spare: float
    salt: float


@jit
def change_thickness(
    w: Profile, first: int, found: Balance, water: Water, snowfall: float, dt: float, p: Physics
) -> Change:
    """Advance the thicknesses by the fluxes of a temperature solve.

    Parameters
    ----------
    w : Profile
        Its thickness and enthalpy are advanced.
    first : int
        Number of snow layers.
    found : bl99.Balance
        Fluxes at top and bottom.
    water : Water
        Under the ice; its salinity is for mush.
    snowfall : float
        kg/m2/s.
    dt : float
        s.
    p : Physics
        Constants.

    Returns
    -------
    Change
    """
    z = w.thickness.size
    for k in range(first, z):
        w.water[k] = melted_enthalpy(w.salt[k], p) if p.mushy else 0.0
    vapour = -found.latent * dt
    hoar_enthalpy = w.enthalpy[first]
    hoar_ice, hoar_snow = settle_hoar(w, first, max(-vapour, 0.0), p)
    base = (found.bottom + water.heat) * dt
    growth, brought = freeze_on(w, max(-base, 0.0), water.freezing, water.salinity, p)
    # Energy of what the ice loses to the sea beside its own melting: brine, and water of the mush.
    washed = -brought - hoar_ice * (hoar_enthalpy - min(hoar_enthalpy - w.water[first], 0.0))
    salt = growth * water.salinity + hoar_ice * w.salt[first]
    leaving, heat = max(vapour, 0.0), max((found.net - found.top) * dt, 0.0)
    gone_snow = gone_ice = melt_snow = melt_top = melt_bottom = 0.0
    for k in range(z):
        if p.mushy and k < first:
            melt_snow += melt_inside(w, k, p)
        density = p.snow_density if k < first else p.ice_density
        bound = min(w.enthalpy[k] - w.water[k], 0.0)
        taken, leaving = remove(w, k, leaving, bound - density * p.vapour)
        melted, heat = remove(w, k, heat, bound)
        washed += taken * (w.enthalpy[k] - bound) + melted * (w.enthalpy[k] - bound)
        salt -= (taken + melted) * w.salt[k]
        if k < first:
            gone_snow += taken
            melt_snow += melted
        else:
            gone_ice += taken
            melt_top += melted
    below = max(base, 0.0)
    for k in range(z - 1, -1, -1):
        bound = min(w.enthalpy[k] - w.water[k], 0.0)
        melted, below = remove(w, k, below, bound)
        washed += melted * (w.enthalpy[k] - bound)
        salt -= melted * w.salt[k]
        if k < first:
            melt_snow += melted
        else:
            melt_bottom += melted
    spare = leaving + heat + below + washed
    fallen = snow_on(w, first, snowfall * dt / p.snow_density, p)
    ice, snow, snow_ice, drowned, cost = settle(w, first, p)
    return Change(
        ice, snow, growth, snow_ice, melt_top, melt_bottom, melt_snow,
        gone_ice - hoar_ice, gone_snow - hoar_snow, fallen, drowned, spare + cost, salt,
    )  # fmt: skip


@jit
def remove(w: Profile, k: int, energy: float, enthalpy: float) -> tuple[float, ...]:
    """Take from layer k what energy (J/m2) removes at an enthalpy (J/m3); thickness and rest.

    A layer without ice to melt (mush all of brine) goes whole.

    Parameters
    ----------
    w : Profile
        Its layer's thickness is reduced.
    k : int
        Row of the layer.
    energy : float
        To be used (J/m2).
    enthalpy : float
        Of what is removed, negative (J/m3).

    Returns
    -------
    tuple of float
        Thickness removed (m), and energy left (J/m2).
    """
    if w.thickness[k] <= 0.0 or (energy <= 0.0 and enthalpy < 0.0):
        return 0.0, energy
    if enthalpy >= 0.0 or energy >= -w.thickness[k] * enthalpy:
        taken = w.thickness[k]
        w.thickness[k] = 0.0
        return taken, max(energy + taken * enthalpy, 0.0)
    taken = -energy / enthalpy
    w.thickness[k] -= taken
    return taken, 0.0


@jit
def melt_inside(w: Profile, k: int, p: Physics) -> float:
    """Melt of snow layer k what light has warmed past melting; thickness melted (m).

    Parameters
    ----------
    w : Profile
        Thickness and enthalpy of its layer are changed.
    k : int
        Row of the snow layer.
    p : Physics
        Constants.

    Returns
    -------
    float
        m of snow.
    """
    frozen = -p.snow_density * p.fusion
    if w.enthalpy[k] <= frozen:
        return 0.0
    melted = min(1.0 - w.enthalpy[k] / frozen, 1.0) * w.thickness[k]
    w.thickness[k] -= melted
    w.enthalpy[k] = frozen
    return melted


@jit
def settle_hoar(w: Profile, first: int, energy: float, p: Physics) -> tuple[float, ...]:
    """Add condensed vapour at the enthalpy of the top (theory, eq. 15); ice, snow added (m).

    Parameters
    ----------
    w : Profile
        Its uppermost layer grows.
    first : int
        Number of snow layers, which is the row of the uppermost ice layer.
    energy : float
        Latent heat of the vapour that condenses (J/m2).
    p : Physics
        Constants.

    Returns
    -------
    tuple of float
        Ice and snow added (m).
    """
    snow = 0.0
    for k in range(first):
        snow += w.thickness[k]
    if first > 0 and snow > TINY:
        gain = energy / (p.snow_density * p.vapour - w.enthalpy[0])
        w.thickness[0] += gain
        return 0.0, gain
    bound = min(w.enthalpy[first] - w.water[first], 0.0)
    gain = energy / (p.ice_density * p.vapour - bound)
    w.thickness[first] += gain
    return gain, 0.0


@jit
def freeze_on(
    w: Profile, energy: float, bottom: float, sea_salinity: float, p: Physics
) -> tuple[float, ...]:
    """Grow ice at the bottom with an energy (J/m2); thickness gained, energy brought with water.

    Theory, eq. 16: new ice has the salinity of the lowest layer and the temperature of the water,
    but at least half the enthalpy of fresh ice, in case these are close. New mush has the sea's
    salinity and temperature; a part of it must freeze, the rest comes as it is (Turner et al. 2013;
    theory of the mushy column, eq. 13).

    Parameters
    ----------
    w : Profile
        Its lowest layer grows.
    energy : float
        Taken from the bottom (J/m2).
    bottom : float
        Temperature of the water (degC).
    sea_salinity : float
        1e-3.
    p : Physics
        Constants.

    Returns
    -------
    tuple of float
        Thickness gained (m), and energy that the water brought along (J/m2).
    """
    if energy <= 0.0:
        return 0.0, 0.0
    last = w.thickness.size - 1
    if p.mushy:
        new = mush_enthalpy(bottom, liquid_fraction(bottom, sea_salinity), p)
        frozen = -p.fusion * p.ice_density * (1.0 - p.bottom_liquid)
    else:
        melting = w.melting[last]
        freezes = bottom < melting or melting == 0.0
        new = ice_enthalpy(bottom, melting, p) if freezes else 0.0
        new = min(new, -0.5 * p.ice_density * p.fusion)
        frozen = new
    gain = -energy / frozen
    total = w.thickness[last] + gain
    w.enthalpy[last] = (w.thickness[last] * w.enthalpy[last] + gain * new) / total
    if p.mushy:
        w.salt[last] = (w.thickness[last] * w.salt[last] + gain * sea_salinity) / total
        w.water[last] = melted_enthalpy(w.salt[last], p)
    w.thickness[last] = total
    return gain, gain * (new - frozen)


@jit
def snow_on(w: Profile, first: int, fallen: float, p: Physics) -> float:
    """Add snow at its melting point to the top snow layer; thickness added (m).

    Parameters
    ----------
    w : Profile
        Its uppermost layer grows.
    first : int
        Number of snow layers, which is the row of the uppermost ice layer.
    fallen : float
        Fresh snow (m).
    p : Physics
        Constants.

    Returns
    -------
    float
        m of snow; 0 where there are no snow layers.
    """
    if fallen <= 0.0 or first == 0:
        return 0.0
    total = w.thickness[0] + fallen
    new = snow_enthalpy(0.0, p)
    w.enthalpy[0] = (w.thickness[0] * w.enthalpy[0] + fallen * new) / total
    w.thickness[0] = total
    return fallen


@jit
def settle(w: Profile, first: int, p: Physics) -> tuple[float, ...]:
    """Flood, even out; ice, snow, snow-ice and drowned snow (m), energy of the latter (J/m2).

    Parameters
    ----------
    w : Profile
        Layers after growth and melt; made equally thick.
    first : int
        Number of snow layers, which is the row of the uppermost ice layer.
    p : Physics
        Constants.

    Returns
    -------
    tuple of float
        Thickness of ice and of snow (m), ice made of flooded snow (m), snow whose ice is gone (m),
        its energy (J/m2).
    """
    ice = snow = 0.0
    for k in range(w.thickness.size):
        if k < first:
            snow += w.thickness[k]
        else:
            ice += w.thickness[k]
    energy = drowned = snow_ice = 0.0
    if ice <= 0.0 or (p.mushy and snow <= TINY):
        for k in range(first):
            energy += w.thickness[k] * w.enthalpy[k]
            w.thickness[k] = 0.0
        snow, drowned = 0.0, snow
    if ice <= 0.0:
        return 0.0, 0.0, 0.0, drowned, energy
    if p.flooding and not p.mushy:
        snow_ice = flood(w, first, ice, snow, p)
    snow = even_out(w, 0, first, False)
    ice = even_out(w, first, w.thickness.size, p.mushy)
    return ice, snow, snow_ice, drowned, energy
