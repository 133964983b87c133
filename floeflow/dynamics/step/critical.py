# SPDX-License-Identifier: GPL-2.0-or-later
"""The largest stable time step, and which bond or contact sets it.

The leapfrog step with damping taken at the old velocity is stable while 4 M - 2 dt C - dt^2 K is
positive: while the largest eigenvalue of 2 dt C + dt^2 K, scaled by the masses, stays below 4.
The bonds' network is in it as it is, so for bonded ice the limit is sharp; contacts, which come
and go, are bounded from above. Drag and Coriolis force set no limit: they are implicit.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import scipy.sparse as sp
from scipy.optimize import brentq
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
    elements: Arrays, bonds: Arrays | None, params: EngineParams, way: float = np.inf
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
    way : float
        By how much two elements may come nearer to each other while the step holds, m.

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
    pack = pack_stiffness(elements, bonds, params, way)
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
        matrix = step**2 * pack.stiffness + 2.0 * step * pack.damping
        try:
            motion = _fastest(matrix + sp.diags_array(2.0 * pack.damped(step)), motion)
        except ArpackNoConvergence:
            return _step_of_rows(pack)[0], fallback
        last, step = step, _step_of(pack, motion)
        if abs(step - last) < CLOSE * step:
            break
    # An eigenvalue too low by a share makes a step too long by half of it.
    return step * (1.0 - CLOSE - 0.5 * TOLERANCE), motion


def _step_of(pack: Stiffness, motion: np.ndarray) -> float:
    """Step (s) at which a motion becomes unstable."""
    k = float(motion @ (pack.stiffness @ motion))
    c = float(motion @ (pack.damping @ motion))
    square = np.square(motion)
    return _solved(k, c, lambda step: float(square @ pack.damped(step)))


def _solved(k: float, c: float, damped: Callable[[float], float]) -> float:
    """Step (s) at which dt^2 k + 2 dt c + 2 damped(dt) = 4; `damped` grows with the step."""
    if max(k, c) <= 0.0:
        # No spring: what damping may take in a step is bounded, and far from what blows up.
        return math.inf
    longest = 4.0 / (c + math.sqrt(c * c + 4.0 * k))
    if damped(longest) <= 0.0:
        return longest

    def excess(step: float) -> float:
        return step * step * k + 2.0 * step * c + 2.0 * damped(step) - 4.0

    return float(brentq(excess, 0.0, longest, rtol=1e-10))


def _step_of_rows(pack: Stiffness) -> tuple[float, np.ndarray]:
    """Step below the limit (s), and the motion of the row that sets it.

    No eigenvalue is above the largest sum of a row (Gershgorin).
    """
    k, c = abs(pack.stiffness).sum(axis=1), abs(pack.damping).sum(axis=1)
    worst = int(np.argmax(k))
    step = _solved(float(k[worst]), float(c.max()), lambda dt: float(pack.damped(dt).max()))
    return step, np.eye(1, len(k), worst)[0]


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
