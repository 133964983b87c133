# SPDX-License-Identifier: GPL-2.0-or-later
# mypy: disable-error-code="no-untyped-def"
"""Equal layers again after growth and melt, conserving energy; flooding of heavy snow."""

from __future__ import annotations

from floeflow.column.physics import TINY, jit


@jit
def even_out(w, begin, end):
    """Make layers begin to end - 1 equally thick; returns their total thickness (m).

    A new layer takes the energy of what lies within its bounds (theory, eq. 19).
    """
    total = 0.0
    w.edges[begin] = 0.0
    for k in range(begin, end):
        total += w.thickness[k]
        w.edges[k + 1] = total
    count = end - begin
    if total <= 0.0:
        w.thickness[begin:end] = 0.0
        w.enthalpy[begin:end] = 0.0
        return 0.0
    for k in range(begin, end):
        # The solution of the temperatures is done with: its array carries the old enthalpies.
        w.solution[k] = w.enthalpy[k]
    thickness = total / count
    old = begin
    for k in range(begin, end):
        low = (k - begin) * thickness
        high = total if k == end - 1 else low + thickness
        energy = 0.0
        while True:
            overlap = min(w.edges[old + 1], high) - max(w.edges[old], low)
            energy += max(overlap, 0.0) * w.solution[old]
            if w.edges[old + 1] >= high or old == end - 1:
                break
            old += 1
        w.enthalpy[k] = energy / thickness
        w.thickness[k] = thickness
    return total


@jit
def flood(w, first, ice, snow, p):
    """Turn snow below the water line into ice of the top layer; returns the ice gained (m).

    Archimedes' balance of Leppaeranta (1983); theory, eq. 18. The mass of the snow becomes ice,
    its salt is not counted.
    """
    deep = snow - ice * (p.water_density - p.ice_density) / p.snow_density
    if not (deep > TINY and snow > TINY):
        return 0.0
    drowned = min(deep * p.ice_density / p.water_density, snow)
    gain = drowned * p.snow_density / p.ice_density
    if gain <= TINY:
        return 0.0
    energy = 0.0
    for k in range(first - 1, -1, -1):
        taken = min(drowned, w.thickness[k])
        w.thickness[k] -= taken
        drowned = max(drowned - taken, 0.0)
        energy += taken * w.enthalpy[k]
    total = w.thickness[first] + gain
    w.enthalpy[first] = (w.thickness[first] * w.enthalpy[first] + energy) / total
    w.thickness[first] = total
    return gain
