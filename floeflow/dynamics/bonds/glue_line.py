# SPDX-License-Identifier: GPL-2.0-or-later
"""Glue lines as ice freezes on between the windows: what displacement they are given.

Ice that forms is free of stress, so what a bond bears must stay as its ice grows. The displacement
of a line follows from its ends in the body frames, so it is those that are moved. Places are
complex numbers, x + i y, in m.
"""

from __future__ import annotations

import math

import numpy as np

from floeflow.dynamics.engine.params import EngineParams
from floeflow.state.bonds import Arrays, element_rows, line_length

# Cracks below this share of the line are closed by the ice around them.
SHORTEST = 1e-3


def displacements(bonds: Arrays, elements: Arrays) -> tuple[np.ndarray, np.ndarray]:
    """Displacement, hi less lo, at the ends a and b of each line, complex m, shapes (m,).

    Parameters
    ----------
    bonds : Arrays
        Bond table of m bonds, by the names of `BOND_COLUMNS`.
    elements : Arrays
        Table of n elements, sorted by id.

    Returns
    -------
    tuple of ndarray
        At the end a and at the end b.
    """
    lo, hi = _ends(bonds, elements, "lo"), _ends(bonds, elements, "hi")
    return hi[0] - lo[0], hi[1] - lo[1]


def displaced(bonds: Arrays, elements: Arrays, a: np.ndarray, b: np.ndarray) -> Arrays:
    """Bonds with these displacements at the ends a and b.

    The midline stays: each element's line moves by half of the change.

    Parameters
    ----------
    bonds : Arrays
        Bond table of m bonds, by the names of `BOND_COLUMNS`.
    elements : Arrays
        Table of n elements, sorted by id.
    a : ndarray
        Displacements, hi less lo, complex m, (m,).
    b : ndarray
        Displacements, hi less lo, complex m, (m,).

    Returns
    -------
    Arrays
        A new table.
    """
    before = displacements(bonds, elements)
    out = dict(bonds)
    for end, old, new in zip("ab", before, (a, b), strict=True):
        for side, share in (("lo", -0.5), ("hi", 0.5)):
            turn = _turn(elements, bonds, side)
            body = share * (new - old) * np.conj(turn)
            out[f"{side}_{end}x"] = bonds[f"{side}_{end}x"] + body.real
            out[f"{side}_{end}y"] = bonds[f"{side}_{end}y"] + body.imag
    return out


def thickened(bonds: Arrays, elements: Arrays, thickness: np.ndarray) -> Arrays:
    """Bonds that have grown to a thickness (m) and bear what they bore.

    Line force is stiffness times displacement, and stiffness grows with thickness.

    Parameters
    ----------
    bonds : Arrays
        Bond table of m bonds, by the names of `BOND_COLUMNS`.
    elements : Arrays
        Table of n elements, sorted by id.
    thickness : ndarray
        m, (m,).

    Returns
    -------
    Arrays
        A new table.
    """
    factor = bonds["thickness"] / thickness
    a, b = displacements(bonds, elements)
    return displaced(bonds, elements, factor * a, factor * b) | {"thickness": thickness}


def healed(bonds: Arrays, elements: Arrays, left: np.ndarray) -> Arrays:
    """Bonds whose cracks have closed to a share of their lengths, bearing what they bore.

    Force and moment, the integrals over the part that holds (docs/theory/contact.md), have to come
    out of a longer line: that fixes the normal displacement at its middle, its slope along the
    line, and the tangential displacement.

    Parameters
    ----------
    bonds, elements : dict of ndarray
        Bond table (m,) and elements, ids ascending.
    left : ndarray, shape (m,)
        Share of both cracks that is left, 0..1. What is shorter than `SHORTEST` is closed; bonds
        whose cracks stay as they are keep their bits.

    Returns
    -------
    dict of ndarray
        Bond table (m,) in the same order; cracks shorter, anchors and lengths moved with them.
    """
    names = ("crack_a", "crack_b")
    cracks = {name: left * bonds[name] for name in names}
    cracks = {name: np.where(crack < SHORTEST, 0.0, crack) for name, crack in cracks.items()}
    changed = np.any([cracks[name] != bonds[name] for name in names], axis=0)
    (w, mid), (wide, middle) = (
        (1.0 - t["crack_a"] - t["crack_b"], 0.5 * (1.0 + t["crack_a"] - t["crack_b"]))
        for t in (bonds, cracks)
    )
    along, (a, b) = _in_frame(bonds, elements)
    slope = -(b - a).imag
    at_mid = -a.imag + mid * slope
    moment = w * ((mid - 0.5) * at_mid + slope * w**2 / 12.0)
    at_middle = at_mid * w / wide
    slope = 12.0 / wide**3 * (moment - wide * (middle - 0.5) * at_middle)
    ends = [
        along * (0.5 * (a + b).real * w / wide - 1j * (at_middle + (end - middle) * slope))
        for end in (0.0, 1.0)
    ]
    out = displaced(bonds, elements, ends[0], ends[1]) | cracks
    # Turning the lines has left their lengths but for the square of a small angle.
    out["length"] = line_length(out)
    return {name: np.where(changed, out[name], bonds[name]) for name in bonds}


def loaded_less_than(
    share: float, bonds: Arrays, elements: Arrays, params: EngineParams
) -> np.ndarray:
    """Whether the part of each line that holds is loaded by less than a share of its strength.

    A load that is larger by the share's inverse still lies within the envelope of failure
    (docs/theory/contact.md). Shape (m,), bool.

    Parameters
    ----------
    share : float
        Of the strength, above 0 and at most 1.
    bonds : Arrays
        Bond table of m bonds, by the names of `BOND_COLUMNS`.
    elements : Arrays
        Table of n elements, sorted by id.
    params : EngineParams
        Parameters of the engine.

    Returns
    -------
    ndarray
        True where the load is smaller.
    """
    normal, tau = line_stresses(bonds, elements, params, share)
    compressive = params.bond_strength(bonds["thickness"])
    tensile = params.tensile_share * compressive
    good = np.ones(len(tau), bool)
    for sigma in normal:
        good &= (sigma <= tensile) & (sigma >= -compressive)
        good &= tau <= (tensile - sigma) * math.tan(params.friction_angle)
    return good


def line_stresses(
    bonds: Arrays, elements: Arrays, params: EngineParams, share: float = 1.0
) -> tuple[np.ndarray, np.ndarray]:
    """Stresses of the part of each line that holds, without damping.

    Parameters
    ----------
    bonds : Arrays
        Bond table of m bonds, by the names of `BOND_COLUMNS`.
    elements : Arrays
        Table of n elements, sorted by id.
    params : EngineParams
        Parameters of the engine.
    share : float, optional
        By which they are divided.

    Returns
    -------
    tuple of ndarray
        Normal stress at both ends of that part, above 0 in tension (Pa), (2, m), and the size of
        the shear stress, the same all along it (Pa), (m,).
    """
    _, (a, b) = _in_frame(bonds, elements)
    young, shear = (m / bonds["span"] / share for m in (params.young_modulus, params.shear_modulus))
    ends = (bonds["crack_a"], 1.0 - bonds["crack_b"])
    normal = np.stack([-(a + xi * (b - a)).imag * young for xi in ends])
    return normal, np.abs(0.5 * (a + b).real) * shear


def _in_frame(bonds: Arrays, elements: Arrays) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray]]:
    """Direction of each midline from a to b, and the displacements at its ends in its frame.

    There the real part is tangential, and minus the imaginary one normal.
    """
    lo, hi = _ends(bonds, elements, "lo"), _ends(bonds, elements, "hi")
    along = (lo[1] - lo[0]) + (hi[1] - hi[0])
    along = along / np.abs(along)
    a, b = (d * np.conj(along) for d in displacements(bonds, elements))
    return along, (a, b)


def _turn(elements: Arrays, bonds: Arrays, side: str) -> np.ndarray:
    return np.exp(1j * elements["theta"][element_rows(elements["id"], bonds[f"id_{side}"])])


def _ends(bonds: Arrays, elements: Arrays, side: str) -> tuple[np.ndarray, np.ndarray]:
    """Ends a and b of the lines on one of the elements."""
    row = element_rows(elements["id"], bonds[f"id_{side}"])
    centre, turn = elements["x"][row] + 1j * elements["y"][row], _turn(elements, bonds, side)
    a, b = (centre + turn * (bonds[f"{side}_{e}x"] + 1j * bonds[f"{side}_{e}y"]) for e in "ab")
    return a, b
