# SPDX-License-Identifier: GPL-2.0-or-later
"""The ridging law once more, as functions of the path (docs/theory/contact.md), by itself."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

EDGE = 1 / math.sqrt(3)  # contact length over the diameter


@dataclass(frozen=True)
class RidgeLaw:
    """Start (N/m2), hardening (N/m4), thickness of crushing (m), compressive strength (Pa)."""

    start: float = 26126.0
    hardening: float = 928.0
    thin: float = 0.3
    strength: float = 1e5

    def per_length(self, thickness: float, closing: float) -> float:
        """Ridging force per contact length, N/m."""
        if thickness > self.thin:
            share = min(thickness / self.thin - 1, 1.0)
            piled = self.per_length(self.thin, closing)
            return (1 - share) * piled + share * thickness * self.strength
        piled = self.start * thickness + self.hardening * thickness**2 * closing
        return min(piled, thickness * self.strength)


@dataclass(frozen=True)
class Ridging:
    """A contact that began at the span (m) with ice of this thickness (m)."""

    law: RidgeLaw
    length: float  # of the contact, m
    span: float
    thickness: float

    def thick(self, closing: float) -> float:
        """Ridge thickness, m: the ice between the centres keeps its volume."""
        return self.thickness * self.span / (self.span - closing)

    def force(self, closing: float) -> float:
        """Ridging force, N."""
        return self.length * self.law.per_length(self.thick(closing), closing)

    def closing_at(self, force: float) -> float:
        """Plastic closing (m) at which the ridging force has risen to this one, from 0 on."""
        return rising(self.force, force, 0.999 * self.span)

    def closing_after(self, travel: float, stiffness: float) -> float:
        """Plastic closing (m) after the discs were pressed together by so much."""
        return rising(lambda c: self.force(c) + stiffness * c, stiffness * travel, travel)


def rising(function: Callable[[float], float], value: float, last: float) -> float:
    """Where a growing function reaches the value, from 0 to `last`; 0 where it begins above it."""
    if function(0.0) >= value:
        return 0.0
    return float(brentq(lambda c: function(c) - value, 0.0, last, xtol=1e-12, rtol=1e-14))


def demsi_force(travel: np.ndarray, speed: float, step: float) -> np.ndarray:
    """Force (N) of DEMSI's unbonded law while two discs are pressed together at a speed (m/s).

    As in its published source, for its two-element case: discs of 2500 m, 1 m thick, Young's
    modulus 1e9 Pa, damping 0.1, ridge thickness 0.2 m, which never changes. `travel` is the overlap
    (m) in each step since the contact began.
    """
    length, k_e, damping, ridge = 5000.0, 1e9 / 5000.0 * 0.5, 0.1, 0.2
    k_r, k_p = 26126.0 * ridge, 928.0 * ridge**2
    out, last = [], 0.0
    for overlap in travel:
        elastic = length * (k_e * overlap + damping * speed)
        right = last / (k_p * step) + length * speed
        right += (length * k_e * overlap + k_e * k_r / k_p) / damping
        plastic = right / (1 / (k_p * step) + (1 + k_e / k_p) / damping)
        last = min(elastic, plastic)
        out.append(last)
    return np.array(out)
