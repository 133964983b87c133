# SPDX-License-Identifier: GPL-2.0-or-later
"""The largest stable time step, and which bond or contact sets it.

The leapfrog step with damping taken at the old velocity is stable while 4 M - 2 dt C - dt^2 K is
positive. A pair's stiffness matrix is at most twice its blocks on the diagonal (for any vectors
a, b: (a - b)^2 <= 2 a^2 + 2 b^2), so the condition can be asked element by element: a block form
of Gershgorin's bound, sharp for the translations of a regular lattice. Drag and Coriolis force
set no limit: they are implicit.
"""

from __future__ import annotations

import numpy as np

from floeflow.dynamics.bondtable import Arrays, element_rows, line_length
from floeflow.dynamics.engineparams import FIXED, EngineParams
from floeflow.errors import FloeError


def critical_step(
    elements: Arrays, bonds: Arrays | None, params: EngineParams
) -> tuple[float, str]:
    """Bound from below on the critical time step.

    Parameters
    ----------
    elements : dict of ndarray, shape (n,)
        As `Engine.load` takes them.
    bonds : dict of ndarray, shape (m,), or None
        Bond table; cracked bonds count as whole.
    params : EngineParams
        Law parameters; its time step plays no part.

    Returns
    -------
    float
        Time step, s.
    str
        What sets it, with ids.

    Raises
    ------
    FloeError
        If no element can move.
    """
    mobile = np.asarray(elements["type"]) != FIXED
    if not mobile.any():
        raise FloeError("All elements are fixed: there is no critical time step.")
    n = len(mobile)
    stiffness, damping = np.zeros((n, 3, 3)), np.zeros((n, 3, 3))
    neighbours = np.zeros(n)
    if params.bonds and bonds is not None and len(bonds["id_lo"]):
        for row, block, viscous in _bond_blocks(elements, bonds, params):
            np.add.at(stiffness, row, block)
            np.add.at(damping, row, viscous)
            np.add.at(neighbours, row, 1.0)
    from_bonds = _largest(stiffness, elements)
    _add_contacts(stiffness, damping, np.maximum(_room(elements) - neighbours, 0), elements, params)
    k, c = 2.0 * _largest(stiffness, elements), 2.0 * _largest(damping, elements)
    # dt^2 k + 2 dt c = 4
    with np.errstate(divide="ignore"):
        steps = np.where(mobile, 4.0 / (c + np.sqrt(c * c + 4.0 * k)), np.inf)
    worst = int(np.argmin(steps))
    by_bonds = from_bonds[worst] > 0.5 * 0.5 * k[worst]
    return float(steps[worst]), _reason(worst, by_bonds, elements, bonds, params)


def _largest(blocks: np.ndarray, elements: Arrays) -> np.ndarray:
    # Rotation in units of length times radius: mass m, m, m / 2.
    scale = np.array([1.0, 1.0, np.sqrt(2.0)])
    weighted = blocks * scale[:, None] * scale[None, :]
    return np.linalg.eigvalsh(weighted)[:, -1] / elements["mass"]


def _bond_blocks(
    elements: Arrays, bonds: Arrays, params: EngineParams
) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Rows, stiffness (N/m) and damping (N s/m) of x, y and rotation times radius, either side."""
    lo = element_rows(elements["id"], bonds["id_lo"])
    hi = element_rows(elements["id"], bonds["id_hi"])
    length = line_length(bonds)
    normal = params.young_modulus * bonds["thickness"] / bonds["span"]
    shear = params.shear_modulus * bonds["thickness"] / bonds["span"]
    reduced = _reduced_mass(elements, lo, hi)
    viscous = 2.0 * params.bond_damping * np.sqrt(reduced / length)
    out = []
    for side, row in (("lo", lo), ("hi", hi)):
        radius = elements["radius"][row]
        cos, sin = np.cos(elements["theta"][row]), np.sin(elements["theta"][row])
        ends = []
        for end in ("a", "b"):
            ax, ay = bonds[f"{side}_{end}x"], bonds[f"{side}_{end}y"]
            ends.append((cos * ax - sin * ay, sin * ax + cos * ay))
        (ax, ay), (bx, by) = ends
        tx, ty = (bx - ax) / length, (by - ay) / length
        mx, my = 0.5 * (ax + bx), 0.5 * (ay + by)
        zero = np.zeros(len(row))
        along_n = np.stack([ty, -tx, (mx * -tx - my * ty) / radius], axis=1)
        along_t = np.stack([tx, ty, (mx * ty - my * tx) / radius], axis=1)
        bending = np.stack([zero, zero, length / np.sqrt(12.0) / radius], axis=1)
        block, damped = np.zeros((len(row), 3, 3)), np.zeros((len(row), 3, 3))
        for mode, per_length in ((along_n, normal), (bending, normal), (along_t, shear)):
            outer = mode[:, :, None] * mode[:, None, :]
            block += (length * per_length)[:, None, None] * outer
            damped += (length * viscous * np.sqrt(per_length))[:, None, None] * outer
        out.append((row, block, damped))
    return out


def _reduced_mass(elements: Arrays, lo: np.ndarray, hi: np.ndarray) -> np.ndarray:
    inverse = np.where(np.asarray(elements["type"]) == FIXED, 0.0, 1.0 / elements["mass"])
    return 1.0 / (inverse[lo] + inverse[hi])


def _room(elements: Arrays) -> np.ndarray:
    """How many of the smallest elements find room around each one: 6 where all are equal."""
    small = elements["radius"].min()
    return np.pi / np.arcsin(small / (elements["radius"] + small))


def _add_contacts(
    stiffness: np.ndarray,
    damping: np.ndarray,
    count: np.ndarray,
    elements: Arrays,
    params: EngineParams,
) -> None:
    """Contacts that may come to be: `count` of them around each element, with the thickest ice."""
    thickest = elements["thickness"].max()
    h = elements["thickness"]
    with np.errstate(invalid="ignore"):
        k = params.contact_modulus * np.where(h > 0, h * thickest / (h + thickest), 0.0)
    ratio = params.contact_shear_ratio if params.friction else 0.0
    # A partner of the same or larger mass: the reduced mass is at most the element's own.
    c = 2.0 * params.contact_damping * np.sqrt(k * elements["mass"])
    for matrix, value, share in ((stiffness, k, ratio), (damping, c, np.sqrt(ratio))):
        matrix[:, 0, 0] += 0.5 * count * (1.0 + share) * value
        matrix[:, 1, 1] += 0.5 * count * (1.0 + share) * value
        matrix[:, 2, 2] += count * share * value


def _reason(
    row: int, by_bonds: bool, elements: Arrays, bonds: Arrays | None, params: EngineParams
) -> str:
    ident = int(elements["id"][row])
    if not by_bonds or bonds is None:
        return (
            f"contacts of element {ident} (radius {elements['radius'][row]:.4g} m, "
            f"thickness {elements['thickness'][row]:.4g} m)"
        )
    mine = np.flatnonzero((bonds["id_lo"] == ident) | (bonds["id_hi"] == ident))
    stiff = line_length(bonds)[mine] * bonds["thickness"][mine] / bonds["span"][mine]
    k = int(mine[np.argmax(stiff)])
    return (
        f"bond {int(bonds['id_lo'][k])}-{int(bonds['id_hi'][k])} (thickness "
        f"{bonds['thickness'][k]:.4g} m) of element {ident} (mass {elements['mass'][row]:.4g} kg)"
    )
