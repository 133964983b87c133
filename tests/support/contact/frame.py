# SPDX-License-Identifier: GPL-2.0-or-later
"""Bonded elements as a structure: energy, stiffness and equilibrium without the plugin.

The energy of each bond is evaluated by Gauss quadrature of the squared displacement of its points
(docs/theory/contact.md); gradients come from complex steps, exact to round-off, and second
derivatives from differences of those. The small-load stiffness is assembled on its own, from
strain-displacement rows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from floeflow.state.bonds import Arrays, element_rows

# Two points integrate the square of what is linear along the line exactly.
GAUSS = 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3.0)


@dataclass(frozen=True)
class Frame:
    """Rows of both elements, ends of the line in body frames, stiffness per bond."""

    lo: np.ndarray  # (m,)
    hi: np.ndarray
    ends: np.ndarray  # (m, 8): lo a, lo b, hi a, hi b, m
    normal: np.ndarray  # (m,) stiffness of the whole line, N/m
    shear: np.ndarray
    rest: np.ndarray  # (n, 3): x, y, angle
    free: np.ndarray  # (3 n,) bool


def frame_of(elements: Arrays, bonds: Arrays, young: float, poisson: float) -> Frame:
    names = [f"{side}_{end}" for side in ("lo", "hi") for end in ("ax", "ay", "bx", "by")]
    length = np.hypot(bonds["lo_bx"] - bonds["lo_ax"], bonds["lo_by"] - bonds["lo_ay"])
    normal = young * bonds["thickness"] / bonds["span"] * length
    rest = np.column_stack([elements["x"], elements["y"], elements["theta"]])
    return Frame(
        element_rows(elements["id"], bonds["id_lo"]),
        element_rows(elements["id"], bonds["id_hi"]),
        np.column_stack([bonds[name] for name in names]),
        normal,
        normal / (2 * (1 + poisson)),
        rest,
        np.repeat(np.asarray(elements["type"]) == 1, 3),
    )


def bond_energies(frame: Frame, pose: np.ndarray) -> np.ndarray:
    """Energy (J) of each bond from poses (m, 6) of lo and hi; analytic, so complex steps work."""

    def ends(angle: np.ndarray, columns: np.ndarray) -> list[np.ndarray]:
        c, s = np.cos(angle), np.sin(angle)
        return [
            c * columns[:, 0] - s * columns[:, 1], s * columns[:, 0] + c * columns[:, 1],
            c * columns[:, 2] - s * columns[:, 3], s * columns[:, 2] + c * columns[:, 3],
        ]  # fmt: skip

    lax, lay, lbx, lby = ends(pose[:, 2], frame.ends[:, :4])
    hax, hay, hbx, hby = ends(pose[:, 5], frame.ends[:, 4:])
    tx, ty = (lbx - lax) + (hbx - hax), (lby - lay) + (hby - hay)
    norm = np.sqrt(tx * tx + ty * ty)
    tx, ty = tx / norm, ty / norm
    out = 0.0
    for xi in GAUSS:
        dx = pose[:, 3] + hax + xi * (hbx - hax) - pose[:, 0] - lax - xi * (lbx - lax)
        dy = pose[:, 4] + hay + xi * (hby - hay) - pose[:, 1] - lay - xi * (lby - lay)
        dn, dt = dx * ty - dy * tx, dx * tx + dy * ty
        out = out + 0.25 * (frame.normal * dn * dn + frame.shear * dt * dt)
    return out


def _poses(frame: Frame, state: np.ndarray) -> np.ndarray:
    return np.concatenate([state[frame.lo], state[frame.hi]], axis=1)


def _bond_gradients(frame: Frame, pose: np.ndarray) -> np.ndarray:
    out = np.empty_like(pose)
    for k in range(6):
        step = pose.astype(complex)
        step[:, k] += 1e-30j
        out[:, k] = bond_energies(frame, step).imag / 1e-30
    return out


def _columns(frame: Frame) -> np.ndarray:
    first = 3 * np.stack([frame.lo, frame.hi], axis=1)
    return (first[:, :, None] + np.arange(3)).reshape(-1, 6)


def gradient(frame: Frame, state: np.ndarray) -> np.ndarray:
    """Gradient of the energy, shape (3 n,): N, N, N m."""
    out = np.zeros(frame.rest.size)
    np.add.at(out, _columns(frame), _bond_gradients(frame, _poses(frame, state)))
    return out


def hessian(frame: Frame, state: np.ndarray) -> sp.csc_matrix:
    """Second derivatives of the energy by central differences of the gradient."""
    pose = _poses(frame, state)
    blocks = np.empty((*pose.shape, 6))
    for k, step in enumerate((1.0, 1.0, 1e-4, 1.0, 1.0, 1e-4)):
        up, down = pose.copy(), pose.copy()
        up[:, k] += step
        down[:, k] -= step
        difference = _bond_gradients(frame, up) - _bond_gradients(frame, down)
        blocks[:, :, k] = difference / (2 * step)
    return _assembled(frame, blocks)


def _assembled(frame: Frame, blocks: np.ndarray) -> sp.csc_matrix:
    columns = _columns(frame)
    i = np.repeat(columns, 6, axis=1).ravel()
    j = np.tile(columns, (1, 6)).ravel()
    size = frame.rest.size
    return sp.csc_matrix((blocks.ravel(), (i, j)), shape=(size, size))


def stiffness(frame: Frame) -> sp.csc_matrix:
    """Small-displacement stiffness from rows B with displacement = B q at the Gauss points."""
    angle = frame.rest[:, 2]
    c, s = np.cos(angle[frame.lo]), np.sin(angle[frame.lo])
    ax = frame.rest[frame.lo, 0] + c * frame.ends[:, 0] - s * frame.ends[:, 1]
    ay = frame.rest[frame.lo, 1] + s * frame.ends[:, 0] + c * frame.ends[:, 1]
    bx = frame.rest[frame.lo, 0] + c * frame.ends[:, 2] - s * frame.ends[:, 3]
    by = frame.rest[frame.lo, 1] + s * frame.ends[:, 2] + c * frame.ends[:, 3]
    length = np.hypot(bx - ax, by - ay)
    tx, ty = (bx - ax) / length, (by - ay) / length
    blocks = np.zeros((len(ax), 6, 6))
    for xi in GAUSS:
        px, py = ax + xi * (bx - ax), ay + xi * (by - ay)
        for stiff, ex, ey in ((frame.normal, ty, -tx), (frame.shear, tx, ty)):
            row = np.zeros((len(ax), 6))
            for start, which, sign in ((0, frame.lo, -1.0), (3, frame.hi, 1.0)):
                rx, ry = px - frame.rest[which, 0], py - frame.rest[which, 1]
                row[:, start : start + 3] = sign * np.column_stack([ex, ey, ey * rx - ex * ry])
            blocks += 0.5 * stiff[:, None, None] * row[:, :, None] * row[:, None, :]
    return _assembled(frame, blocks)


def equilibrium(frame: Frame, load: np.ndarray, parts: int = 20) -> np.ndarray:
    """State (n, 3) where the energy less the work of a dead load (3 n,) is least: Newton, in parts.

    Each step is cut until the residual falls; raises ArithmeticError where that does not help.
    """
    state, free = frame.rest.copy(), frame.free
    arm = np.hypot(frame.ends[:, 0], frame.ends[:, 1]).max()
    # Torques count as forces at the length of an arm.
    weight = np.tile([1.0, 1.0, 1.0 / arm], len(state))[free] / np.abs(load).max()
    for part in range(1, parts + 1):
        target = load * part / parts
        for _ in range(60):
            residual = (target - gradient(frame, state))[free]
            if np.abs(residual * weight).max() < 1e-8:
                break
            matrix = hessian(frame, state)[free][:, free]
            full = np.zeros(free.size)
            full[free] = splu(sp.csc_matrix(matrix)).solve(residual)
            move = full.reshape(-1, 3)
            move *= min(1.0, 0.1 / max(np.abs(move[:, 2]).max(), 1e-300))
            state = state + move
        else:
            raise ArithmeticError("Newton's iteration does not converge.")
    return state
