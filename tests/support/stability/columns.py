# SPDX-License-Identifier: GPL-2.0-or-later
"""Columns at the edges, weather without mercy, and what must hold of every step of them."""

from __future__ import annotations

import math

import numpy as np

from floeflow.column.kernel import HOUR
from floeflow.column.layered import (
    LayeredState,
    ice_energy,
    ice_residual,
    pack_forcing,
    pond_residual,
    salt_residual,
    sea_residual,
    step,
    water_residual,
)
from floeflow.column.physics import Physics
from floeflow.column.thermodynamics.enthalpy import salinity_profile
from floeflow.column.thermodynamics.mush import brine_salinity, liquidus
from floeflow.column.thickness.categories import category_bounds
from support.sound_columns import sound

DEPTH = 20.0  # m of the mixed layer
LAYERS = 7
BOUNDS = category_bounds(5)
FULL = {"ponds": True, "delta_eddington": True}
PHYSICS = {
    "bl99": Physics(),
    "bl99, ponds, delta-Eddington": Physics(**FULL),
    "mushy": Physics(mushy=True),
    "mushy, ponds, delta-Eddington": Physics(mushy=True, **FULL),
}


def freezing(p: Physics, salinity: float = 34.0) -> float:
    """Freezing point of the sea, degC."""
    return float(liquidus.py_func(salinity) if p.mushy else -p.melting_slope * salinity)


def columns(
    p: Physics,
    thickness: object,
    snow: object = 0.0,
    area: object = 1.0,
    below: object = 5.0,
    salinity: object = 4.0,
    sea: object = None,
) -> LayeredState:
    """Columns of one thickness each, in the category where it belongs; scalars or (n,).

    Parameters
    ----------
    p : Physics
        Of the scheme.
    thickness, snow : array_like
        Of the ice and of the snow on it, m.
    area : array_like
        Share under ice; 0 is open water.
    below : array_like
        How far all layers are below their melting point, K.
    salinity : array_like
        Of mush, 1e-3; ice of Bitz and Lipscomb has its profile.
    sea : array_like, optional
        Temperature of the mixed layer, degC; its freezing point where left out.
    """
    sea = freezing(p) if sea is None else sea
    h, s, a, b, salt, sea = (
        np.array(v, float) for v in np.broadcast_arrays(
            *np.atleast_1d(thickness, snow, area, below, salinity, sea)
        )
    )  # fmt: skip
    n, there = len(h), a > 0.0
    where = np.clip(np.searchsorted(BOUNDS, h, side="right") - 1, 0, 4)
    row = np.arange(n)

    def spread(values: np.ndarray) -> np.ndarray:
        out = np.zeros((n, 5, *values.shape[1:]))
        out[row, where] = np.where(there.reshape(-1, *(1,) * (values.ndim - 1)), values, 0.0)
        return out

    if p.mushy:
        profile = np.repeat(salt[:, None], LAYERS, axis=1)
        melting = np.vectorize(liquidus.py_func)(profile)
        # Brine takes all heat close to melting: what is asked for is a temperature of the mush.
        temperature = np.maximum(melting - b[:, None], -50.0)
        brine = np.vectorize(brine_salinity.py_func)(temperature)
        liquid = np.divide(profile, np.maximum(brine, profile), out=0.0 * profile, where=brine > 0)
        enthalpy = liquid * p.heat_water * p.water_density * temperature
        solid = p.ice_density * (p.heat_ice * temperature - p.fusion)
        enthalpy = enthalpy + (1.0 - liquid) * solid
    else:
        profile = np.broadcast_to(salinity_profile(LAYERS, p), (n, LAYERS))
        melting = -p.melting_slope * profile
        temperature = melting - b[:, None]
        brine = 1.0 - melting / temperature
        enthalpy = p.heat_ice * (melting - temperature) + p.fusion * brine
        enthalpy = -p.ice_density * (enthalpy - p.heat_water * melting)
    white = -p.snow_density * (p.fusion + p.heat_ice * np.repeat(b[:, None], 1, axis=1))
    surface = np.full((n, 5), freezing(p))
    surface[row, where] = np.where(there, np.minimum(temperature[:, 0], 0.0), freezing(p))
    return LayeredState(
        ice_fraction=spread(a),
        ice_volume=spread(a * h),
        snow_volume=spread(a * s),
        surface_temperature=surface,
        ice_enthalpy=spread(enthalpy),
        snow_enthalpy=spread(white),
        ice_salinity=spread(profile),
        sea_temperature=sea.copy(),
        pending_freeze=np.zeros(n),
    )


def weather(steps: int, n: int, **given: object) -> np.ndarray:
    """Calm cold winter's night, but for what is given: scalars, (n,) or (steps, 1)."""
    values: dict[str, object] = {
        "potential_temperature": 250.0,
        "humidity": 5e-4,
        "density": 1.3,
        "wind": 5.0,
        "longwave": 180.0,
        "sun": 0.0,
        "snowfall": 0.0,
        "rain": 0.0,
        "sea_salinity": 34.0,
        "deep_heat": 2.0,
        "mixed_depth": DEPTH,
        "ocean_friction": 0.005,
        "sun_height": 0.5,
    }
    values |= given
    sun = np.asarray(values.pop("sun"), float)
    values |= {"visible": 0.52 * sun, "infrared": 0.48 * sun}
    shaped = {k: np.broadcast_to(np.asarray(v, float), (steps, n)) for k, v in values.items()}
    return pack_forcing(shaped, steps, n)


def advance(
    before: LayeredState, forcing: np.ndarray, dt: float, p: Physics, at_once: int = 1
) -> tuple[LayeredState, dict[str, np.ndarray]]:
    """Steps, so many at once; state and budgets are looked at after each lot."""
    state, total = before, {}
    for k in range(0, len(forcing), at_once):
        lot = forcing[k : k + at_once]
        after, sums = step(state, lot, dt, BOUNDS, p)
        sound(after)
        closed(state, after, sums, dt, p, len(lot) * math.ceil(dt / HOUR))
        state = after
        total = {name: total.get(name, 0.0) + sums[name] for name in sums}
    return state, total


def closed(
    before: LayeredState,
    after: LayeredState,
    sums: dict[str, np.ndarray],
    dt: float,
    p: Physics,
    steps: int = 1,
) -> None:
    """Budgets of energy, water, salt and ponds, to the round-off of so many steps."""
    # Mush near melting holds next to no energy, but it is the difference of large ones.
    most = p.ice_density * p.fusion * (before.ice_volume + after.ice_volume).sum(axis=1)
    most = np.maximum(most, np.abs(ice_energy(before)) + np.abs(ice_energy(after)))
    allowed = steps * np.maximum(1e-8 * dt, 1e-14 * most)
    assert (np.abs(ice_residual(before, after, sums)) <= allowed).all()
    warm = np.maximum(np.abs(before.sea_temperature), np.abs(after.sea_temperature)) + 1.0
    sea = p.heat_water * p.water_density * DEPTH * warm
    allowed = steps * (1e-8 * dt + 2e-15 * sea)
    assert (np.abs(sea_residual(before, after, sums, DEPTH, p)) <= allowed).all()
    ice, snow = water_residual(before, after, sums)
    assert np.abs(ice).max() < steps * 2e-14 and np.abs(snow).max() < steps * 2e-15
    if p.mushy:
        assert np.abs(salt_residual(before, after, sums)).max() < steps * 1e-12
    if p.ponds:
        assert np.abs(pond_residual(before, after, sums)).max() < steps * 1e-12
