# SPDX-License-Identifier: GPL-2.0-or-later
"""The vortex of the reference data: unbonded ice in a box under a wind that turns (Flato 1993).

The box has walls on four sides. DEMSI's wind stress is rho C |u_a - u| u_a, which FloeFlow does
not have. Here the absolute one, rho C |w| w, makes it, by a wind w = u_a (|u_a - u| / |u_a|)^(1/2):
every minute the test takes the velocities u of the ice and hands over such a wind.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from mpi4py import MPI

from floeflow.dynamics.engine.engine import Engine, EngineParams, Forcing
from floeflow.state import walls
from floeflow.state.bonds import Arrays
from support.full_ice import full_params
from support.rafts import discs

BOX, RADIUS = 500e3, 2500.0
AIR, WATER, DENSITY = 1.225 * 0.015, 1017 * 0.0045, 900.0
STIFFNESS = 1e8  # N/m of a contact for each metre of thickness
REFRESH = 60.0  # s between two winds
AXIS = np.linspace(0.0, BOX, 501)


def rim() -> Arrays:
    """The four sides of the box."""
    sides = (
        ((0.0, 0.0), (1, 0)),
        ((BOX, 0.0), (-1, 0)),
        ((0.0, 0.0), (0, 1)),
        ((0.0, BOX), (0, -1)),
    )
    return walls.join([walls.plane(*point, normal) for point, normal in sides])


def box(places: np.ndarray, thickness: float | np.ndarray, seed: int) -> Arrays:
    """Elements at the places (n, 2), moved by up to 1e-9 m at random."""
    moved = places + np.random.default_rng(seed).uniform(-1e-9, 1e-9, places.shape)
    elements = discs(*moved.T, RADIUS, thickness)
    elements["mass"] = DENSITY * elements["thickness"] * elements["ice_area"]
    return elements


def springs(step: float) -> EngineParams:
    """Springs without damping or friction. Two slabs in series have half of the modulus."""
    return full_params(
        time_step=step, friction=False, contact_damping=0.0, contact_modulus=2 * STIFFNESS,
        wind=True, ocean_drag=True, wind_stress_factor=AIR, ocean_stress_factor=WATER,
    )  # fmt: skip


def wind(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Wind (m/s), anticlockwise around (250, 200) km, shape (2, *x.shape)."""
    dx, dy = x - 250e3, y - 200e3
    r = np.maximum(np.hypot(dx, dy), 1.0)
    share = np.minimum(0.5e-3, 8e5 / r**2)
    return np.stack([-share * dy, share * dx])


STILL = wind(*np.meshgrid(AXIS, AXIS))


def turning_wind(ice: Arrays) -> Forcing:
    """Wind whose absolute stress is DEMSI's |u_a - u| u_a for ice that moves as it does now.

    Each element has the nodes around it for itself, so it meets its own factor to round-off: the
    lattice buckles from the smallest differences.
    """
    there = wind(ice["x"], ice["y"])
    speed = np.maximum(np.hypot(*there), 1e-9)
    own = np.sqrt(np.hypot(there[0] - ice["u"], there[1] - ice["v"]) / speed)
    factor = np.ones((len(AXIS), len(AXIS)))
    column, row = (np.floor(ice[name] / (AXIS[1] - AXIS[0])).astype(int) for name in ("x", "y"))
    for dx in range(-1, 3):
        for dy in range(-1, 3):
            factor[row + dy, column + dx] = own
    u, v = (STILL * factor)[:, None]
    zero = np.zeros_like(u)
    fields = {"wind_u": u, "wind_v": v, "ocean_u": zero, "ocean_v": zero}
    return Forcing(np.array([0.0]), AXIS, AXIS, fields)


def drift(log: Path, elements: Arrays, params: EngineParams, hours: int) -> Iterator[Engine]:
    """The engine at the end of each hour."""
    steps = round(REFRESH / params.time_step)
    with Engine(MPI.COMM_SELF, params, log, rim()) as engine:
        engine.load(elements)
        for _ in range(hours):
            for _ in range(round(3600 / REFRESH)):
                engine.set_forcing(turning_wind(engine.elements()))
                engine.run(steps)
            yield engine


def lattice() -> np.ndarray:
    """The start of the reference run: 100 x 50 places (m) in the upper half of the box."""
    across, up = np.arange(RADIUS, BOX, 2 * RADIUS), np.arange(BOX / 2 + RADIUS, BOX, 2 * RADIUS)
    x, y = np.meshgrid(across, up, indexing="ij")
    return np.column_stack([x.ravel(), y.ravel()])


def quadrants(x: np.ndarray, v: np.ndarray, first: np.ndarray) -> np.ndarray:
    """Means of place (m) and velocity (m/s) of the ice that began in each quadrant of its area.

    Shape (4, 4): quadrant (west low, east low, west high, east high); x, y, u, v.
    """
    east = first[:, 0] > np.median(first[:, 0])
    high = first[:, 1] > np.median(first[:, 1])
    number = east + 2 * high
    both = np.column_stack([x, v])
    return np.array([both[number == k].mean(0) for k in range(4)])
