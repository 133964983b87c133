# SPDX-License-Identifier: GPL-2.0-or-later
"""Fresh ice of constant properties against exact solutions of conduction and freezing."""

import math

import numpy as np
from scipy.optimize import brentq
from scipy.special import erf

from floeflow.column.layered import LayeredState, pack_forcing, step
from floeflow.column.physics import Physics
from floeflow.column.thickness.categories import category_bounds

COLD = -20.0  # degC, of the surface
# Fresh ice, no vapour, no long-wave radiation; the air holds the surface at its temperature.
FRESH = Physics(
    bottom_salinity=0.0,
    melting_slope=0.0,
    bubbly=False,
    emissivity=0.0,
    vapour_ice=0.0,
    windless=1e8,
)
DIFFUSIVITY = FRESH.fresh_conductivity / (FRESH.ice_density * FRESH.heat_ice)


def ice(thickness: float, temperature: np.ndarray, p: Physics) -> LayeredState:
    """One column of fresh ice at the freezing point of fresh water."""
    enthalpy = -p.ice_density * (p.fusion - p.heat_ice * temperature)
    one = np.ones((1, 1))
    return LayeredState(
        one, thickness * one, 0 * one, COLD * one, enthalpy[None, None, :], np.zeros((1, 1, 1)),
        0.0 * enthalpy[None, None, :],
        np.zeros(1), np.zeros(1),
    )  # fmt: skip


def freeze(state: LayeredState, seconds: float, steps: int, p: Physics) -> LayeredState:
    forcing = dict.fromkeys(
        ("humidity", "wind", "longwave", "visible", "infrared", "snowfall", "sea_salinity",
         "deep_heat", "ocean_friction"), np.zeros(1),
    )  # fmt: skip
    forcing |= {
        "potential_temperature": np.full(1, 273.15 + COLD),
        "density": np.ones(1),
        "mixed_depth": np.full(1, 20.0),
    }
    packed = pack_forcing(forcing, steps, 1)
    return step(state, packed, seconds / steps, category_bounds(1), p)[0]


def middles(layers: int) -> np.ndarray:
    return (np.arange(layers) + 0.5) / layers


def orders(errors: list[float]) -> np.ndarray:
    return np.log2(np.array(errors[:-1]) / np.array(errors[1:]))


def test_conduction_is_second_order_in_layers() -> None:
    # Without freezing the bottom stays: a sine of temperature decays on top of the linear profile.
    p = FRESH._replace(fusion=1e9)
    thickness, seconds = 0.5, 20000.0
    decay = math.exp(-DIFFUSIVITY * (math.pi / thickness) ** 2 * seconds)
    errors = []
    for layers in (4, 8, 16, 32):
        z = middles(layers)
        start = ice(thickness, COLD * (1.0 - z) - 5.0 * np.sin(math.pi * z), p)
        end = freeze(start, seconds, 5000, p)
        found = (p.fusion + end.ice_enthalpy[0, 0] / p.ice_density) / p.heat_ice
        exact = COLD * (1.0 - z) - 5.0 * decay * np.sin(math.pi * z)
        errors.append(float(np.abs(found - exact).max()))
        assert abs(end.ice_volume[0, 0] - thickness) < 1e-5
    assert errors[-1] < 3e-3
    assert np.all(orders(errors) > 1.8)


def test_freezing_follows_neumann() -> None:
    # Similarity solution of Neumann (Carslaw and Jaeger 1959, section 11.2): h = 2 x sqrt(k t).
    stefan = FRESH.heat_ice * -COLD / FRESH.fusion
    x = brentq(lambda v: math.sqrt(math.pi) * v * math.exp(v * v) * erf(v) - stefan, 1e-3, 1.0)
    thin, thick = 0.3, 0.6
    t0, t1 = (h**2 / (4.0 * x * x * DIFFUSIVITY) for h in (thin, thick))
    errors = []
    for layers in (6, 12, 24, 48):
        profile = COLD * (1.0 - erf(x * middles(layers)) / erf(x))
        end = freeze(ice(thin, profile, FRESH), t1 - t0, 400 * layers, FRESH)
        errors.append(abs(float(end.ice_volume[0, 0]) - thick))
    assert errors[-1] < 5e-4 * (thick - thin)
    # Equal layers that follow the growing bottom mix heat like an upwind scheme: first order.
    assert np.all(orders(errors) > 0.9) and orders(errors)[-1] > 0.97
