# SPDX-License-Identifier: GPL-2.0-or-later
"""The vortex of the reference data: unbonded ice in a box under a wind that turns (Flato 1993).

Walls are rows of fixed elements so dense that they are flat to 0.4 m: bumps of 6 m move quadrant
means by 0.2 km in the first hours. They end at 100 km, south of which no ice comes in a day.
DEMSI's wind stress is rho C |u_a - u| u_a; ours here is rho C |u_a| u_a times 1 - x, with x the
share of the wind's speed at which ice drifts freely, so that the two agree in free drift.
"""

from __future__ import annotations

import math

import numpy as np
from rafts import discs

from floeflow.dynamics.bondtable import Arrays
from floeflow.dynamics.engine import EngineParams, Forcing

BOX, RADIUS, SPACING = 500e3, 2500.0, 125.0
AIR, WATER, DENSITY = 1.225 * 0.015, 1017 * 0.0045, 900.0
STIFFNESS = 1e8  # N/m of a contact for each metre of thickness


def wall() -> np.ndarray:
    """Centres (k, 2) of fixed discs that touch the box from outside: west, east and north."""
    across = np.arange(-RADIUS, BOX + RADIUS + 1, SPACING)
    up = across[across > 100e3]
    west, east = (np.column_stack([np.full_like(up, x), up]) for x in (-RADIUS, BOX + RADIUS))
    return np.concatenate([west, east, np.column_stack([across, np.full_like(across, east[0, 0])])])


def box(places: np.ndarray, thickness: float | np.ndarray, seed: int) -> Arrays:
    """Elements at the places (n, 2), moved by up to 1e-9 m at random, and the walls behind them."""
    n, fixed = len(places), wall()
    moved = places + np.random.default_rng(seed).uniform(-1e-9, 1e-9, places.shape)
    everywhere = np.concatenate([moved, fixed])
    h = np.concatenate([np.broadcast_to(thickness, n), np.ones(len(fixed))])
    elements = discs(*everywhere.T, RADIUS, h)
    elements["type"][n:] = 2
    elements["mass"] = DENSITY * h * elements["ice_area"]
    return elements


def parameters(step: float) -> EngineParams:
    """Springs without damping or friction. Two slabs in series have half of the modulus."""
    root = math.sqrt(AIR / WATER)
    drift = root * (math.hypot(1, root / 2) - root / 2)
    return EngineParams(
        time_step=step, friction=False, contact_damping=0.0, contact_modulus=2 * STIFFNESS,
        wind=True, ocean_drag=True, wind_stress_factor=AIR * (1 - drift),
        ocean_stress_factor=WATER,
    )  # fmt: skip


def turning_wind() -> Forcing:
    """Anticlockwise around (250, 200) km."""
    axis = np.linspace(0.0, BOX, 501)
    x, y = np.meshgrid(axis - 250e3, axis - 200e3)
    r = np.maximum(np.hypot(x, y), 1.0)
    share = np.minimum(0.5e-3, 8e5 / r**2)
    zero = np.zeros((1, *r.shape))
    fields = {"wind_u": (-share * y)[None], "wind_v": (share * x)[None]}
    return Forcing(np.array([0.0]), axis, axis, fields | {"ocean_u": zero, "ocean_v": zero})


def quadrants(x: np.ndarray, v: np.ndarray, first: np.ndarray) -> np.ndarray:
    """Means of place (m) and velocity (m/s) of the ice that began in each quadrant of its area.

    Shape (4, 4): quadrant (west low, east low, west high, east high); x, y, u, v.
    """
    east = first[:, 0] > np.median(first[:, 0])
    high = first[:, 1] > np.median(first[:, 1])
    number = east + 2 * high
    both = np.column_stack([x, v])
    return np.array([both[number == k].mean(0) for k in range(4)])
