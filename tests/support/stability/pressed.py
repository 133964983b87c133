# SPDX-License-Identifier: GPL-2.0-or-later
"""Packs that contacts alone hold: pressed into a frame of fixed discs, and their exact limit.

Contacts push and never pull, so a free pack flies apart after its first swing, at any step. Between
fixed discs its contacts stay closed, and a step beyond the limit shows.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from mpi4py import MPI

from floeflow.dynamics.engine.engine import Engine, EngineParams
from floeflow.dynamics.engine.params import FIXED
from floeflow.dynamics.ridging.overlaps import overlapping_pairs
from floeflow.dynamics.step.critical import critical_step
from floeflow.state.bonds import Arrays
from support.full_ice import full_params
from support.rafts import ICE, lattice, uniform
from support.stability.packs import chain, mixed_lattice

# A row under pressure buckles; under so little, in more time than a run takes.
GENTLE = 1e-7
# Share of the relative velocity of a pair that damping takes in a step (docs/theory/contact.md).
MOST_DAMPED = 0.1


def unlike_radii() -> Arrays:
    """A lattice of discs of 0.8 to 1.2 km, thicknesses at random."""
    pack, random = mixed_lattice(), np.random.default_rng(5)
    pack["radius"] = pack["radius"] * random.uniform(0.8, 1.2, len(pack["id"]))
    pack["mass"] = ICE * pack["thickness"] * np.pi * pack["radius"] ** 2
    return pack


def framed(pack: Arrays, share: float) -> Arrays:
    """The same pack with its outer discs fixed, centres drawn together by a share."""
    outer = np.zeros(len(pack["id"]), bool)
    for axis in ("x", "y"):
        low, high = float(pack[axis].min()), float(pack[axis].max())
        if high > low:
            edge = 0.75 * float(pack["radius"].mean())
            outer |= (pack[axis] < low + edge) | (pack[axis] > high - edge)
    middle = {a: (pack[a] - pack[a].mean()) * (1.0 - share) for a in ("x", "y")}
    return pack | middle | {"type": np.where(outer, FIXED, pack["type"]).astype(np.int8)}


PRESSED = {
    "pair": lambda: framed(chain(4), GENTLE),
    "chain": lambda: framed(chain(), GENTLE),
    "lattice": lambda: framed(lattice(8, 8), GENTLE),
    "lattice, mixed thickness": lambda: framed(mixed_lattice(), GENTLE),
    "lattice, mixed radius": lambda: framed(unlike_radii(), 0.05),
}


def at_rest(log: Path, name: str) -> Arrays:
    """A pressed pack that has come to rest, without friction, in strongly damped contacts."""
    pack = PRESSED[name]()
    laws = full_params(time_step=1.0, friction=False, contact_damping=1.0, ocean_drag=True)
    laws = replace(laws, time_step=0.65 * critical_step(pack, None, laws)[0])
    with Engine(MPI.COMM_SELF, laws, log) as engine:
        engine.load(pack)
        engine.set_forcing(uniform())
        engine.run(30000)
        pack = engine.elements()
    still = np.zeros(len(pack["id"]))
    return pack | {"u": still, "v": still.copy(), "omega": still.copy()}


def network_step(pack: Arrays, laws: EngineParams, gap: float = 0.0) -> float:
    """Exact critical step (s) of the contacts between discs that touch now; all stick.

    Discs count as touching up to a gap of so much of their radii.
    """
    wider = pack | {"radius": pack["radius"] * (1.0 + gap)}
    lo, hi, _ = overlapping_pairs(wider)
    mobile = pack["type"] != FIXED
    kept = mobile[lo] | mobile[hi]
    lo, hi = lo[kept], hi[kept]
    n, ratio = len(mobile), laws.contact_shear_ratio if laws.friction else 0.0
    inverse = np.where(mobile, 1.0 / pack["mass"], 0.0)
    d = np.stack([pack[axis][hi] - pack[axis][lo] for axis in ("x", "y")], axis=1)
    d /= np.hypot(*d.T)[:, None]
    h = pack["thickness"]
    k = laws.contact_modulus * h[lo] * h[hi] / (h[lo] + h[hi])
    reduced = 1.0 / (inverse[lo] + inverse[hi])
    c = 2.0 * laws.contact_damping * np.sqrt(k * reduced)
    opening, sliding = np.zeros((2, len(lo), n, 3))
    row = np.arange(len(lo))
    for side, sign in ((lo, -1.0), (hi, 1.0)):
        opening[row, side, :2] = sign * d
        sliding[row, side, :2] = sign * np.stack([-d[:, 1], d[:, 0]], axis=1)
        sliding[row, side, 2] = -np.sqrt(2.0)
    scale = np.repeat(np.sqrt(inverse), 3)
    opening, sliding = (modes.reshape(len(lo), -1) * scale for modes in (opening, sliding))

    def weighed(value: np.ndarray, part: float) -> np.ndarray:
        return opening.T @ (value[:, None] * opening) + sliding.T @ (
            part * value[:, None] * sliding
        )

    stiffness = weighed(k, ratio)
    low, high = 0.0, 1e6
    while high - low > 1e-4 * high:
        step = 0.5 * (low + high)
        # In a step the law takes at most a share of the relative velocity.
        damping = weighed(np.minimum(c, MOST_DAMPED * reduced / step), np.sqrt(ratio))
        top = np.linalg.eigvalsh(step**2 * stiffness + 2.0 * step * damping)[-1]
        low, high = (step, high) if top < 4.0 else (low, step)
    return low
