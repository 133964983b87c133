# SPDX-License-Identifier: GPL-2.0-or-later
"""DEMSI's bond law for bonds that do not break, as its published source and its results show it.

Written to tell what makes its cantilever differ from ours, not to be right: the ends of each line
are moved by rates, with a step that may be longer than the real one, and the viscous force acts
between the centres without a torque. Places, velocities and ends are complex numbers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from floeflow.state.bonds import Arrays, element_rows


@dataclass(frozen=True)
class DemsiLaw:
    """Young's modulus (Pa), Poisson's ratio, damping (N s/m3), and the stale step over the step."""

    young: float
    poisson: float
    damping: float
    stretch: float


def swing(
    elements: Arrays, bonds: Arrays, load: np.ndarray, law: DemsiLaw, times: np.ndarray, step: float
) -> np.ndarray:
    """Centres (time, n), complex, under a dead load (n,), complex N; fixed elements stay.

    `times` are multiples of the step, from 0 on.
    """
    lo, hi = (element_rows(elements["id"], bonds[f"id_{end}"]) for end in ("lo", "hi"))
    n = len(elements["id"])
    x, v = elements["x"] + 1j * elements["y"], np.zeros(n, complex)
    spin, mass = np.zeros(n), elements["mass"]
    inertia = 0.5 * mass * elements["radius"] ** 2
    free = np.asarray(elements["type"]) == 1
    # Ends a and b on lo, then on hi, without rotation at the start.
    side = np.array([lo, lo, hi, hi])
    names = ("lo_a", "lo_b", "hi_a", "hi_b")
    ends = x[side] + np.array([bonds[f"{name}x"] + 1j * bonds[f"{name}y"] for name in names])
    length = np.abs(ends[1] - ends[0])
    k_n = law.young * bonds["thickness"] / length
    k_t = k_n / (2 * (1 + law.poisson))
    c = law.damping * length * bonds["thickness"]
    out = [x]
    rows = np.rint(np.diff(times) / step).astype(int)
    for count in rows:
        for _ in range(count):
            apart = ends[2:] - ends[:2]
            first = ends[0] + 0.5 * apart[0]
            line = ends[1] + 0.5 * apart[1] - first
            along = line / np.abs(line)
            across = -1j * along
            normal = length * k_n * (apart * across.conj()).real
            force = 0.5 * normal.sum(0) * across
            slide = length * k_t * (apart * along.conj()).real
            force = force + 0.5 * slide.sum(0) * along
            total = load + _sum(force + c * (v[hi] - v[lo]), lo, hi, n)
            # The force's mean acts at the line's middle; its slope makes a moment besides.
            middle = first + 0.5 * line
            couple = (normal[1] - normal[0]) * np.abs(line) / 12.0
            on_lo = (np.conj(middle - x[lo]) * force).imag - couple
            on_hi = -(np.conj(middle - x[hi]) * force).imag + couple
            torque = np.bincount(lo, on_lo, n) + np.bincount(hi, on_hi, n)
            v = v + np.where(free, total * (step / mass), 0.0)
            spin = spin + np.where(free, torque * (step / inertia), 0.0)
            ends = ends + law.stretch * step * (v[side] + 1j * spin[side] * (ends - x[side]))
            x = x + step * v
        out.append(x)
    return np.array(out)


def _sum(force: np.ndarray, lo: np.ndarray, hi: np.ndarray, n: int) -> np.ndarray:
    """Forces on the elements (n,) from those on the lower id of each pair."""
    parts = [
        np.bincount(lo, part, n) - np.bincount(hi, part, n) for part in (force.real, force.imag)
    ]
    return np.asarray(parts[0] + 1j * parts[1])
