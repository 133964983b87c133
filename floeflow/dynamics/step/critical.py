# SPDX-License-Identifier: GPL-2.0-or-later
"""The largest stable time step, and which bond or contact sets it.

The leapfrog step with damping taken at the old velocity is stable while 4 M - 2 dt C - dt^2 K is
positive: while the largest eigenvalue of 2 dt C + dt^2 K, scaled by the masses, stays below 4.
The bonds' network is in it as it is, so for bonded ice the limit is sharp; contacts, which come
and go, are bounded from above. Drag and Coriolis force set no limit: they are implicit.
"""

from __future__ import annotations

import math

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import ArpackNoConvergence, eigsh

from floeflow.core.errors import FloeError
from floeflow.dynamics.engine.params import FIXED, EngineParams
from floeflow.dynamics.step.stiffness import Stiffness, pack_stiffness
from floeflow.state.bonds import Arrays, line_length

# Rounds in which the step and the fastest motion at that step are brought into line, and how
# close they have to come.
ROUNDS, CLOSE = 20, 5e-3
# Lanczos' iteration comes from below to within this share.
TOLERANCE = 2e-2
# Matrices up to this size are not worth an iteration.
DENSE = 200


def critical_step(
    elements: Arrays, bonds: Arrays | None, params: EngineParams
) -> tuple[float, str]:
    """Critical time step, from below.

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
    pack = pack_stiffness(elements, bonds, params)
    step, motion = _limit(pack)
    row = int(np.argmax(np.square(motion).reshape(-1, 3).sum(axis=1)))
    return step, _reason(row, elements, bonds, params)


def _limit(pack: Stiffness) -> tuple[float, np.ndarray]:
    """Step (s) at which the fastest motion becomes unstable, and that motion, shape (3 n,)."""
    motion = np.random.default_rng(0).normal(size=pack.stiffness.shape[0])
    step, fallback = _step_of_rows(pack)
    if not np.isfinite(step):
        return step, motion
    for _ in range(ROUNDS):
        try:
            motion = _fastest(step**2 * pack.stiffness + 2.0 * step * pack.damping, motion)
        except ArpackNoConvergence:
            return _step_of_rows(pack)[0], fallback
        last, step = (
            step,
            _step_of(
                float(motion @ (pack.stiffness @ motion)), float(motion @ (pack.damping @ motion))
            ),
        )
        if abs(step - last) < CLOSE * step:
            break
    # An eigenvalue too low by a share makes a step too long by half of it.
    return step * (1.0 - CLOSE - 0.5 * TOLERANCE), motion


def _step_of(k: float, c: float) -> float:
    """Step (s) at which dt^2 k + 2 dt c = 4."""
    return 4.0 / (c + math.sqrt(c * c + 4.0 * k)) if max(k, c) > 0.0 else math.inf


def _step_of_rows(pack: Stiffness) -> tuple[float, np.ndarray]:
    """Step below the limit (s), and the motion of the row that sets it.

    No eigenvalue is above the largest sum of a row (Gershgorin).
    """
    k, c = abs(pack.stiffness).sum(axis=1), abs(pack.damping).sum(axis=1)
    worst = int(np.argmax(k))
    return _step_of(float(k[worst]), float(c.max())), np.eye(1, len(k), worst)[0]


def _fastest(matrix: sp.csr_array, guess: np.ndarray) -> np.ndarray:
    """Eigenvector of the largest eigenvalue, of length 1."""
    if matrix.shape[0] <= DENSE:
        return np.asarray(np.linalg.eigh(matrix.toarray())[1][:, -1])
    return np.asarray(eigsh(matrix, k=1, which="LA", v0=guess, tol=TOLERANCE)[1][:, 0])


def _reason(row: int, elements: Arrays, bonds: Arrays | None, params: EngineParams) -> str:
    ident = int(elements["id"][row])
    contacts = (
        f"contacts of element {ident} (radius {elements['radius'][row]:.4g} m, "
        f"thickness {elements['thickness'][row]:.4g} m)"
    )
    if not params.bonds or bonds is None:
        return contacts
    mine = np.flatnonzero((bonds["id_lo"] == ident) | (bonds["id_hi"] == ident))
    if len(mine) == 0:
        return contacts
    stiff = line_length(bonds)[mine] * bonds["thickness"][mine] / bonds["span"][mine]
    k = int(mine[np.argmax(stiff)])
    return (
        f"bond {int(bonds['id_lo'][k])}-{int(bonds['id_hi'][k])} (thickness "
        f"{bonds['thickness'][k]:.4g} m) of element {ident} (mass {elements['mass'][row]:.4g} kg)"
    )
