# SPDX-License-Identifier: GPL-2.0-or-later
"""The linear system of surface and layers that every sweep of the temperatures solves."""

from __future__ import annotations

from typing import TYPE_CHECKING

from floeflow.column.physics import jit

if TYPE_CHECKING:
    from floeflow.column.thermodynamics.profile import Profile


@jit
def fill_surface(w: Profile, top: int, temperature: float, net: float, slope: float) -> None:
    """Row 0: the linearised surface balance with the layer below (theory, eq. 8).

    Parameters
    ----------
    w : Profile
        Row 0 of its system is set.
    top : int
        Uppermost layer that counts.
    temperature : float
        Of the surface, around which is linearised (degC).
    net : float
        Flux into the surface (W/m2), and its derivative (W/m2/K).
    slope : float
        Flux into the surface (W/m2), and its derivative (W/m2/K).
    """
    w.diagonal[0] = slope - w.conductance[top]
    w.upper[0] = w.conductance[top]
    w.right[0] = slope * temperature - net


@jit
def fill_layer(
    w: Profile, top: int, layer: int, capacity: float, start: float, bottom: float, dt: float
) -> None:
    """Row of a layer of a heat capacity (J/m3/K), backward Euler (theory, eq. 13).

    ``start`` is the temperature from which light and conduction take it (degC), ``bottom`` that of
    the ice's bottom.

    Parameters
    ----------
    w : Profile
        The row of its system is set.
    top : int
        Uppermost layer that counts.
    layer : int
        Row of the layer in the profile.
    capacity : float
        Heat capacity (J/m3/K).
    start : float
        Temperature from which light and conduction take the layer (degC).
    bottom : float
        Temperature of the ice's bottom (degC).
    dt : float
        Time step (s).
    """
    k, row, z = w.conductance, layer - top + 1, w.thickness.size
    step = dt / (w.thickness[layer] * capacity)
    w.lower[row] = -step * k[layer]
    w.upper[row] = -step * k[layer + 1]
    w.diagonal[row] = 1.0 + step * (k[layer] + k[layer + 1])
    w.right[row] = start + step * w.source[layer]
    if layer == z - 1:
        w.right[row] += step * k[z] * bottom


@jit
def solve(w: Profile, begin: int, end: int) -> None:
    """Eliminate rows begin to end - 1 (Thomas); the right side is overwritten.

    Parameters
    ----------
    w : Profile
        Its ``solution`` is set, its ``right`` overwritten.
    begin : int
        First row, and the one after the last.
    end : int
        First row, and the one after the last.
    """
    pivot = w.diagonal[begin]
    w.solution[begin] = w.right[begin] / pivot
    for row in range(begin + 1, end):
        w.right[row - 1] = w.upper[row - 1] / pivot
        pivot = w.diagonal[row] - w.lower[row] * w.right[row - 1]
        w.solution[row] = (w.right[row] - w.lower[row] * w.solution[row - 1]) / pivot
    for row in range(end - 2, begin - 1, -1):
        w.solution[row] -= w.right[row] * w.solution[row + 1]
