# SPDX-License-Identifier: GPL-2.0-or-later
"""Energy that comes out of nothing: how a run that diverges is known before it is non-finite.

A step above the stable limit feeds energy into the fastest motion until bonds break or discs part;
what is left looks calm again. The budget does not forget: what is stored and lost then exceeds
what was there and what wind, water and walls have done.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from floeflow.core.errors import FloeError
from floeflow.dynamics.engine.params import FIXED
from floeflow.state.bonds import Arrays

STORES = ("kinetic_now", "rotational_now", "elastic_bond", "elastic_contact")
# Works among the elements themselves; all others come from outside.
INTERNAL = ("work_contact", "work_spin")
# A step of the default's size misses a few percent; a run that diverges makes many times what it
# has within some hundred steps.
MOST = 2.0
# Speed (m/s) of round-off: packs at rest have no energy to compare with.
STILL = 1.0e-4


def stored_energy(sums: Mapping[str, float]) -> float:
    """Kinetic and elastic energy of now, J, from `Engine.diagnostics`.

    Parameters
    ----------
    sums : mapping of float
        By name (J, kg m/s).

    Returns
    -------
    float
        J, at the time of the positions.
    """
    return sum(sums[name] for name in STORES)


def external_work(sums: Mapping[str, float]) -> float:
    """Work of wind, water and walls since `load`, J.

    Parameters
    ----------
    sums : mapping of float
        By name (J, kg m/s).

    Returns
    -------
    float
        J, positive where it was done on the ice.
    """
    return sum(value for name, value in sums.items() if is_external(name))


def is_external(name: str) -> bool:
    """Whether a sum of `Engine.diagnostics` is a work of wind, water or walls.

    Parameters
    ----------
    name : str
        Of the sum.

    Returns
    -------
    bool
        True for each ``work_`` but that of contacts and of torques.
    """
    return name.startswith("work_") and name not in INTERNAL


def lost_energy(sums: Mapping[str, float]) -> float:
    """Energy dissipated since `load`, J: damping, friction, fracture, ridging.

    Parameters
    ----------
    sums : mapping of float
        By name (J, kg m/s).

    Returns
    -------
    float
        J, positive where the ice has lost it.
    """
    return sum(value for name, value in sums.items() if name.startswith("dissipation_"))


def check_energy(
    first: Mapping[str, float], now: Mapping[str, float], elements: Arrays, steps: int
) -> None:
    """Refuse to go on where there is far more energy than came from anywhere.

    Parameters
    ----------
    first, now : mapping
        `Engine.diagnostics` after `load` and now.
    elements : dict of ndarray
        Elements now; the fastest is named.
    steps : int
        Steps since `load`.

    Raises
    ------
    FloeError
        Says how much and by which step.
    """
    mobile = np.asarray(elements["type"]) != FIXED
    mass = float(elements["mass"][mobile].sum())
    worked = sum(abs(value) for name, value in now.items() if is_external(name))
    given = stored_energy(first) + worked + 0.5 * mass * STILL**2
    found = stored_energy(now) + lost_energy(now)
    if found > MOST * given:
        speed = np.where(mobile, np.hypot(elements["u"], elements["v"]), 0.0)
        k = int(np.argmax(speed))
        raise FloeError(
            f"Energy came out of nothing by step {steps}: {found:.3g} J are stored or lost, but "
            f"only {given:.3g} J were there or came from outside. The time step is too long; the "
            f"fastest is element {elements['id'][k]} with {speed[k]:.3g} m/s."
        )
