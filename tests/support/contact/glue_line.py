# SPDX-License-Identifier: GPL-2.0-or-later
"""The bond law written once more, point by point in complex numbers, for tests to compare with.

It knows the equations of docs/theory/contact.md and nothing of the plugin: line forces are sampled
or integrated numerically where the plugin has closed forms.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import quad


@dataclass(frozen=True)
class Side:
    """One element of a pair: centre (m, as x + iy), angle (rad) and its glue line's ends (m)."""

    centre: complex
    angle: float
    a: complex
    b: complex

    def point(self, xi: np.ndarray | float) -> np.ndarray | complex:
        """Places of the points of the line that move with this element."""
        return self.centre + np.exp(1j * self.angle) * (self.a + xi * (self.b - self.a))


def displacement(lo: Side, hi: Side, xi: np.ndarray) -> tuple[np.ndarray, np.ndarray, complex]:
    """Normal and tangential displacement (m) along the line, and the normal as a complex number."""
    tangent = (lo.point(1.0) - lo.point(0.0)) + (hi.point(1.0) - hi.point(0.0))
    normal = -1j * tangent / abs(tangent)
    d = (hi.point(xi) - lo.point(xi)) * np.conj(normal)
    return d.real, d.imag, normal


def failed(
    dn: np.ndarray, dt: np.ndarray, span: float, young: float, shear: float, tensile: float,
    compressive: float, tan_phi: float,
) -> np.ndarray:  # fmt: skip
    """Points whose stress (Pa) lies outside of the envelope."""
    sigma, tau = young * dn / span, shear * dt / span
    return (sigma > tensile) | (sigma < -compressive) | (np.abs(tau) > (tensile - sigma) * tan_phi)


def cracks(bad: np.ndarray) -> tuple[float, float]:
    """Cracked share from either end of samples in the middle of equal pieces of the line."""
    good = np.flatnonzero(~bad)
    if len(good) == 0:
        return 1.0, 0.0
    return good[0] / len(bad), 1 - (good[-1] + 1) / len(bad)


def load_on(side: Side, lo: Side, hi: Side, law: dict[str, float]) -> tuple[complex, float]:
    """Force (N) and torque (N m) on one side by adaptive quadrature.

    `law` has normal and tangential stiffness per length (Pa) and the cracked shares.
    """
    sign = 1.0 if side is lo else -1.0
    length = abs(lo.b - lo.a)

    def density(xi: float) -> tuple[complex, float]:
        dn, dt, normal = displacement(lo, hi, np.array([xi]))
        force = sign * length * (law["normal"] * dn[0] + 1j * law["shear"] * dt[0]) * normal
        arm = 0.5 * (lo.point(xi) + hi.point(xi)) - side.centre
        return force, (np.conj(arm) * force).imag

    parts = (
        lambda xi: density(xi)[0].real,
        lambda xi: density(xi)[0].imag,
        lambda xi: density(xi)[1],
    )
    ends = (law["crack_a"], 1.0 - law["crack_b"])
    fx, fy, torque = (quad(part, *ends, epsabs=0.0, epsrel=1e-12)[0] for part in parts)
    return complex(fx, fy), torque
