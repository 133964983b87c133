# SPDX-License-Identifier: GPL-2.0-or-later
# mypy: disable-error-code="no-untyped-def"
"""Frazil: ice that the freezing potential of the sea makes in open water."""

from __future__ import annotations

from floeflow.column.physics import TINY, jit
from floeflow.column.records import NEW_ICE, NEW_ICE_ENERGY


@jit
def freeze_leads(c, energy, freezing, bounds, sums, p):
    """Make ice of the energy (J/m2) that the sea lacks (Hunke et al. 2015; theory, eq. 23).

    New ice has the enthalpy of fresh ice at its melting point. It gathers in open water, at least
    ``new_ice_thickness`` thick, in the thinnest category; what would fill that beyond nine tenths
    of its range, and all where there is no open water, thickens all categories alike.

    Parameters
    ----------
    c : Column
        Advanced.
    energy : float
        To be taken from the sea, not negative (J/m2).
    freezing : float
        Freezing point of the sea (degC).
    bounds : ndarray
        Of categories (m), (ncat + 1,).
    sums : ndarray
        Budget terms, added to.
    p : Physics
        Constants.
    """
    if energy <= 0.0:
        return
    enthalpy = -p.ice_density * p.fusion
    volume = -energy / enthalpy
    sums[NEW_ICE] += volume
    sums[NEW_ICE_ENERGY] -= energy
    total = 0.0
    for n in range(c.area.size):
        total += c.area[n]
    water = max(1.0 - total, 0.0)
    area = 0.0
    if water > TINY:
        thickness = max(volume / water, p.new_ice_thickness)
        area = min(volume / thickness, water)
        most = 0.9 * bounds[1] * water
        surplus = 0.0
        if c.area.size > 1 and thickness > 0.9 * bounds[1] and total > TINY:
            area = water
            surplus = max(volume - most, 0.0)
    else:
        surplus = volume
    if surplus > 0.0:
        for n in range(c.area.size):
            thicken(c, n, surplus * c.area[n] / total, enthalpy)
    if area > 0.0:
        c.surface[0] = (c.surface[0] * c.area[0] + freezing * area) / (c.area[0] + area)
        c.surface[0] = min(c.surface[0], 0.0)
        c.area[0] += area
        thicken(c, 0, volume - surplus, enthalpy)


@jit
def thicken(c, n, volume, enthalpy):
    """Mix new ice into all layers of category n."""
    total = c.ice[n] + volume
    if volume <= 0.0 or total <= 0.0:
        return
    for k in range(c.ice_enthalpy.shape[1]):
        c.ice_enthalpy[n, k] = (c.ice_enthalpy[n, k] * c.ice[n] + enthalpy * volume) / total
    c.ice[n] = total
