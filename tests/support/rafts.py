# SPDX-License-Identifier: GPL-2.0-or-later
"""Small groups of elements for the tests of the engine."""

from __future__ import annotations

import math

import numpy as np

from floeflow.dynamics.engine.params import Forcing
from floeflow.state.bonds import Arrays, new_bonds

ICE = 917.0


def discs(x, y, radius=1000.0, thickness=1.0) -> Arrays:
    """Elements at rest."""
    x, y = np.atleast_1d(np.asarray(x, float)), np.atleast_1d(np.asarray(y, float))
    n = len(x)
    radius, thickness = np.broadcast_to(radius, n) * 1.0, np.broadcast_to(thickness, n) * 1.0
    area = np.pi * radius**2
    zero = np.zeros(n)
    return {
        "id": np.arange(1, n + 1),
        "type": np.ones(n, np.int8),
        "x": x.copy(),
        "y": y.copy(),
        "theta": zero.copy(),
        "u": zero.copy(),
        "v": zero.copy(),
        "omega": zero.copy(),
        "radius": radius,
        "mass": ICE * thickness * area,
        "thickness": thickness,
        "ice_area": area,
    }


def lattice(columns: int, rows: int, radius: float = 1000.0, thickness: float = 1.0) -> Arrays:
    """Touching discs in a triangular lattice."""
    i, j = np.meshgrid(np.arange(columns), np.arange(rows))
    x, y = 2 * radius * (i + 0.5 * (j % 2)), math.sqrt(3) * radius * j
    return discs(x.ravel(), y.ravel(), radius, thickness)


def bonded(elements: Arrays, gap: float = 1.0, share: float = 1 / math.sqrt(3)) -> Arrays:
    """Bonds between all discs no further apart than the gap; lines as in a hexagonal tiling."""
    x, y, r = elements["x"], elements["y"], elements["radius"]
    distance = np.hypot(x[:, None] - x, y[:, None] - y)
    near = np.triu(distance < r[:, None] + r + gap, 1)
    lo, hi = np.nonzero(near)
    d = distance[lo, hi]
    nx, ny = (x[hi] - x[lo]) / d, (y[hi] - y[lo]) / d
    mx, my = x[lo] + nx * r[lo], y[lo] + ny * r[lo]
    half = share * np.minimum(r[lo], r[hi])
    thickness = np.minimum(elements["thickness"][lo], elements["thickness"][hi])
    ids = elements["id"]
    ends = (mx + ny * half, my - nx * half, mx - ny * half, my + nx * half)
    return new_bonds(elements, ids[lo], ids[hi], *ends, thickness)


def uniform(
    wind=(0.0, 0.0), ocean=(0.0, 0.0), coriolis: float = 0.0, depth: float = 0.0
) -> Forcing:
    """Forcing that is the same everywhere and always."""
    one = np.ones((1, 2, 2))
    fields = {
        "wind_u": wind[0] * one,
        "wind_v": wind[1] * one,
        "ocean_u": ocean[0] * one,
        "ocean_v": ocean[1] * one,
        "coriolis": coriolis * one[0],
        "sea_floor_depth": depth * one[0],
    }
    edge = np.array([-1e6, 1e6])
    return Forcing(np.array([0.0]), edge, edge, fields)


def angular_momentum(elements: Arrays) -> tuple[float, float]:
    """About the origin, and the sum of the absolute parts."""
    m, r = elements["mass"], elements["radius"]
    parts = np.concatenate(
        [
            m * elements["x"] * elements["v"],
            -m * elements["y"] * elements["u"],
            0.5 * m * r**2 * elements["omega"],
        ]
    )
    return float(parts.sum()), float(np.abs(parts).sum())
