# SPDX-License-Identifier: GPL-2.0-or-later
"""Stiffness and damping of a pack about where it is: bonds as they are, contacts that may come.

Three numbers an element: places x and y, and rotation times radius. Everything is scaled by the
roots of the inertias (m, m and m / 2), so that eigenvalues are squares of frequencies.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from floeflow.dynamics.engine.params import FIXED, EngineParams
from floeflow.dynamics.step.contact_room import Room, contact_room
from floeflow.state.bonds import Arrays, element_rows, line_length

# A disc's inertia for rotation times radius, over its mass.
SPIN_INERTIA = 0.5
# Crowds of very unlike discs act along one direction by up to 3 % more than half of what is capped.
SLACK = 1.05


@dataclass(frozen=True)
class Stiffness:
    """Scaled stiffness (1/s2) and damping (1/s); 3 n x 3 n, without cross terms of fixed ones.

    Parameters
    ----------
    stiffness, damping : scipy.sparse.csr_array
        Symmetric, not negative; damping that of the bonds.
    contact_damping, damped_per_step : ndarray, shape (3 n,)
        Damping of contacts (1/s), and a bound of it times the step (1), whatever the step.
    """

    stiffness: sp.csr_array
    damping: sp.csr_array
    contact_damping: np.ndarray
    damped_per_step: np.ndarray

    def damped(self, step: float) -> np.ndarray:
        """Contacts' damping times a step (s), shape (3 n,).

        Parameters
        ----------
        step : float
            s.

        Returns
        -------
        ndarray
            s, one for each degree of freedom (u, v, spin of each element), (3 n,).
        """
        return np.asarray(np.minimum(step * self.contact_damping, self.damped_per_step))


def pack_stiffness(
    elements: Arrays, bonds: Arrays | None, params: EngineParams, way: float = np.inf
) -> Stiffness:
    """Stiffness and damping of a pack.

    Bonds are there as a network, whole where they are cracked. Contacts are not known beforehand:
    the most that finds room around an element beside its bonds stands on the diagonal
    (`contact_room.py`).

    Parameters
    ----------
    elements : dict of ndarray, shape (n,)
        As `Engine.load` takes them.
    bonds : dict of ndarray, shape (m,), or None
        Bond table.
    params : EngineParams
        Law parameters.
    way : float
        As for `contact_room`, m.

    Returns
    -------
    Stiffness
        By mass and moment of inertia: of springs 1/s2, of dashpots 1/s.
    """
    n = len(elements["id"])
    stiffness, damping = sp.csr_array((3 * n, 3 * n)), sp.csr_array((3 * n, 3 * n))
    neighbours = np.zeros(n)
    if params.bonds and bonds is not None and len(bonds["id_lo"]):
        rows = [element_rows(elements["id"], bonds[name]) for name in ("id_lo", "id_hi")]
        for row in rows:
            np.add.at(neighbours, row, 1.0)
        modes, spring, viscous = _bond_modes(elements, bonds, params, *rows)
        stiffness = (modes.T @ sp.diags_array(spring) @ modes).tocsr()
        damping = (modes.T @ sp.diags_array(viscous) @ modes).tocsr()
    free = np.maximum(1.0 - neighbours / _room(elements), 0.0)
    spring, viscous, per_step = _contact_diagonals(
        contact_room(elements, params, way), params, free
    )
    return Stiffness((stiffness + sp.diags_array(spring)).tocsr(), damping, viscous, per_step)


def _roots(elements: Arrays) -> np.ndarray:
    """One over the roots of the inertias, shape (n, 3); 0 where an element never moves."""
    mobile = np.asarray(elements["type"]) != FIXED
    root = np.where(mobile, 1.0 / np.sqrt(elements["mass"]), 0.0)
    return np.stack([root, root, root / np.sqrt(SPIN_INERTIA)], axis=1)


def _bond_modes(
    elements: Arrays, bonds: Arrays, params: EngineParams, lo: np.ndarray, hi: np.ndarray
) -> tuple[sp.csr_array, np.ndarray, np.ndarray]:
    """Opening, sliding and bending of each bond by the scaled motions of its elements.

    Returns the modes (3 m x 3 n), and stiffness (N/m) and damping (N s/m) of each.
    """
    m, n = len(lo), len(elements["id"])
    length = line_length(bonds)
    normal = params.young_modulus * bonds["thickness"] / bonds["span"]
    shear = params.shear_modulus * bonds["thickness"] / bonds["span"]
    inverse = np.where(np.asarray(elements["type"]) == FIXED, 0.0, 1.0 / elements["mass"])
    per_root = 2.0 * params.bond_damping * np.sqrt(1.0 / (inverse[lo] + inverse[hi]) / length)
    root = _roots(elements)
    values, columns = [], []
    for side, row, sign in (("lo", lo, -1.0), ("hi", hi, 1.0)):
        block = sign * _modes_of_side(elements, bonds, side, row) * root[row][:, None, :]
        values.append(block)
        columns.append(np.broadcast_to(3 * row[:, None, None] + np.arange(3), block.shape))
    rows = np.broadcast_to(3 * np.arange(m)[:, None, None] + np.arange(3)[:, None], (m, 3, 3))
    entries = np.concatenate([v.ravel() for v in values])
    places = np.concatenate([rows.ravel()] * 2), np.concatenate([c.ravel() for c in columns])
    modes = sp.coo_array((entries, places), shape=(3 * m, 3 * n)).tocsr()
    per_length = np.stack([normal, shear, normal], axis=1)
    spring = length[:, None] * per_length
    viscous = length[:, None] * per_root[:, None] * np.sqrt(per_length)
    return modes, spring.ravel(), viscous.ravel()


def _modes_of_side(elements: Arrays, bonds: Arrays, side: str, row: np.ndarray) -> np.ndarray:
    """How a side's x, y and rotation times radius open, slide and bend its bonds, (m, 3, 3)."""
    radius = elements["radius"][row]
    cos, sin = np.cos(elements["theta"][row]), np.sin(elements["theta"][row])
    ends = []
    for end in ("a", "b"):
        ax, ay = bonds[f"{side}_{end}x"], bonds[f"{side}_{end}y"]
        ends.append((cos * ax - sin * ay, sin * ax + cos * ay))
    (ax, ay), (bx, by) = ends
    length = np.hypot(bx - ax, by - ay)
    tx, ty = (bx - ax) / length, (by - ay) / length
    mx, my = 0.5 * (ax + bx), 0.5 * (ay + by)
    zero = np.zeros(len(row))
    opening = np.stack([ty, -tx, (mx * -tx - my * ty) / radius], axis=1)
    sliding = np.stack([tx, ty, (mx * ty - my * tx) / radius], axis=1)
    bending = np.stack([zero, zero, length / np.sqrt(12.0) / radius], axis=1)
    return np.stack([opening, sliding, bending], axis=1)


def _room(elements: Arrays) -> np.ndarray:
    """How many of the smallest elements find room around each one: 6 where all are equal."""
    small = elements["radius"].min()
    return np.pi / np.arcsin(small / (elements["radius"] + small))


def _contact_diagonals(room: Room, params: EngineParams, free: np.ndarray) -> list[np.ndarray]:
    """Scaled stiffness, damping and damping in a step of contacts in the free share of the room.

    All around an element half of the normal and half of the tangential springs act along any
    direction; of two opposite ones all of the normal springs may. Each of shape (3 n,).
    """
    ratio = params.contact_shear_ratio if params.friction else 0.0
    out = []
    for total, one, share in (
        (room.stiffness, room.stiffest, ratio),
        (room.damping, room.most_damped, np.sqrt(ratio)),
        (
            *(SLACK * room.damped_per_step, SLACK * room.most_damped_per_step),
            np.sqrt(ratio),
        ),
    ):
        along = np.maximum(free * 0.5 * (1.0 + share) * total, np.where(free > 0.0, 2.0 * one, 0.0))
        turning = free * share * total / SPIN_INERTIA
        out.append(np.stack([along, along, turning], axis=1).ravel())
    return out
