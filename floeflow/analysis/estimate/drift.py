# SPDX-License-Identifier: GPL-2.0-or-later
"""Drift of one point of ice under the scene's typical wind and current, any effect on or off.

The balance of `floeflow`'s own element without neighbours (docs/theory/forces.md), stepped by
backward Euler from rest: m du/dt = τ_a + ρ_w C_w |w| e^{iφ} w - i m f (u - u_w), w = u_w - u.
"""

from __future__ import annotations

import cmath
import math
from functools import lru_cache

from floeflow.analysis.estimate.conditions import Conditions
from floeflow.core.constants import AIR_DENSITY, SEAWATER_DENSITY

STEPS = 400
# Effects that a run asks for: runs that differ in others alone are one.
ACTING = frozenset({"wind", "ocean_drag", "turning_angle", "coriolis", "tilt"})


def run_drift(c: Conditions, effects: frozenset[str]) -> complex:
    """Displacement (m) in the run, x along the wind, as a complex number.

    The current stands at right angles to the wind: nothing then cancels by chance.

    Parameters
    ----------
    c : Conditions
        Of the scene.
    effects : frozenset of str
        Effects of the run; those without a share in free drift are ignored.
    """
    return _run_drift(c, effects & ACTING)


@lru_cache(maxsize=256)
def _run_drift(c: Conditions, effects: frozenset[str]) -> complex:
    mass = max(c.mass, 1.0)
    stress = AIR_DENSITY * c.air_drag * c.wind**2 / mass if "wind" in effects else 0.0
    factor = SEAWATER_DENSITY * c.ocean_drag / mass if "ocean_drag" in effects else 0.0
    sign = math.copysign(1.0, c.coriolis)
    angle = sign * c.turning_angle if "turning_angle" in effects else 0.0
    turn = 1j * c.coriolis if "coriolis" in effects else 0j
    tilt = 1j * c.coriolis * 1j * c.current if "tilt" in effects else 0j
    water, push = 1j * c.current, stress + tilt
    drag = factor * cmath.exp(1j * angle)
    dt = c.seconds / STEPS
    velocity, place = 0j, 0j
    for _ in range(STEPS):
        speed = _slip(velocity, dt, push, drag, turn, water)
        velocity = (velocity + dt * (push + drag * speed * water)) / (
            1.0 + dt * (drag * speed + turn)
        )
        place += dt * velocity
    return place


def _slip(
    old: complex, dt: float, push: complex, drag: complex, turn: complex, water: complex
) -> float:
    """Speed relative to the water at the new time: the root of s = |u(s) - u_w|, by bisection."""
    if not drag:
        return 0.0

    def excess(speed: float) -> float:
        new = (old + dt * (push + drag * speed * water)) / (1.0 + dt * (drag * speed + turn))
        return abs(new - water) - speed

    low, high = 0.0, abs(old) + abs(water) + dt * abs(push) + 1.0e-9
    if excess(high) > 0:
        return high
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if excess(middle) > 0 else (low, middle)
        if high - low < 1e-12 * max(1.0, high):
            break
    return 0.5 * (low + high)
