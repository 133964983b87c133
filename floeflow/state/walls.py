# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls as straight faces in the plane of the ice: planes, and lines that may join.

A plane has no ends and ice on its left side only, as one looks from a to b. A line has two ends
and two sides; where it meets another line of its wall, each knows the other, so that ice is pushed
once by a corner and slides from line to line. All faces of a wall move at its constant velocity,
from where they are at time 0. NumPy only: preprocessing, engine and tests share it.
"""

from __future__ import annotations

import numpy as np

from floeflow.core.errors import FloeError
from floeflow.state.bonds import Arrays

# Columns of a face, and of a contact with one, in the plugin's order (liggghts_models/capi/capi.h).
FACE_NUMBERS = ("wall", "plane", "before", "after")
FACE_COLUMNS = ("ax", "ay", "bx", "by", "u", "v")

Velocity = tuple[float, float]


def plane(x: float, y: float, normal: Velocity, velocity: Velocity = (0.0, 0.0)) -> Arrays:
    """Wall of one plane through a point, with ice on the side to which its normal points.

    Raises
    ------
    FloeError
        If the normal has no length.
    """
    length = float(np.hypot(*normal))
    if not (np.isfinite(length) and length > 0):
        raise FloeError(f"The normal of a plane must be finite and not 0, not {normal}.")
    # The ice lies to the left of a -> b.
    along = (normal[1] / length, -normal[0] / length)
    ends = np.array([[[x, y], [x + along[0], y + along[1]]]])
    return _faces(ends, velocity, True)


def lines(ends: np.ndarray, velocity: Velocity = (0.0, 0.0), name: str = "The wall") -> Arrays:
    """Wall of lines that join where their ends coincide.

    Parameters
    ----------
    ends : ndarray, shape (n, 2, 2)
        Both ends of each line, m.
    velocity : tuple of float
        m/s.
    name : str
        For the sentence of a fault.

    Raises
    ------
    FloeError
        If a line has no length, or more than two of them meet.
    """
    ends = np.asarray(ends, dtype=float)
    if len(ends) == 0 or not np.isfinite(ends).all():
        raise FloeError(f"{name} has no lines, or some that are not finite.")
    if (np.hypot(*(ends[:, 1] - ends[:, 0]).T) <= 0).any():
        raise FloeError(f"{name} has a line without length.")
    out = _faces(ends, velocity, False)
    points, corner = np.unique(ends.reshape(-1, 2), axis=0, return_inverse=True)
    corner = corner.reshape(-1)
    count = np.bincount(corner)
    if (count > 2).any():
        x, y = points[int(np.argmax(count))]
        raise FloeError(f"{name}: more than two lines meet at ({x:.6g}, {y:.6g}) m.")
    order = np.argsort(corner, kind="stable")
    first = order[np.r_[True, np.diff(corner[order]) > 0]]
    second = order[np.r_[np.diff(corner[order]) > 0, True]]
    for here, there in ((first, second), (second, first)):
        joined = here != there
        line, end = here[joined] // 2, here[joined] % 2
        out["before"][line[end == 0]] = there[joined][end == 0] // 2
        out["after"][line[end == 1]] = there[joined][end == 1] // 2
    return out


def join(walls: list[Arrays]) -> Arrays:
    """Faces of all walls, numbered in their order."""
    out: dict[str, list[np.ndarray]] = {name: [] for name in (*FACE_NUMBERS, *FACE_COLUMNS)}
    start = 0
    for number, wall in enumerate(walls):
        for name in FACE_COLUMNS:
            out[name].append(wall[name])
        out["plane"].append(wall["plane"])
        out["wall"].append(np.full(len(wall["ax"]), number))
        for name in ("before", "after"):
            out[name].append(np.where(wall[name] >= 0, wall[name] + start, -1))
        start += len(wall["ax"])
    return {name: np.concatenate(parts) for name, parts in out.items()}


def distances(faces: Arrays, x: np.ndarray, y: np.ndarray, time: float = 0.0) -> np.ndarray:
    """Distance (m) of points from faces at a time (s); below 0 behind a plane.

    Points and faces are broadcast: points of shape (n, 1) give (n, faces).
    """
    tx, ty = faces["bx"] - faces["ax"], faces["by"] - faces["ay"]
    length = np.hypot(tx, ty)
    dx, dy = x - faces["ax"] - faces["u"] * time, y - faces["ay"] - faces["v"] * time
    height = (dy * tx - dx * ty) / length
    share = np.clip((dx * tx + dy * ty) / length**2, 0.0, 1.0)
    away = np.hypot(dx - share * tx, dy - share * ty)
    return np.asarray(np.where(faces["plane"] != 0, height, away))


def overlapping(faces: Arrays, elements: Arrays, time: float = 0.0) -> Arrays:
    """Contacts without force of the elements that overlap a wall: rest overlap is what there is.

    Returns
    -------
    dict of ndarray, shape (n,)
        Table as `Engine.load` takes it: id, face, slip and rest_overlap (m), sorted.
    """
    x, y, radius = (elements[name][:, None] for name in ("x", "y", "radius"))
    depth = radius - distances(faces, x, y, time)
    row, face = np.nonzero(depth > 0)
    depth = depth[row, face]
    return {
        "id": np.asarray(elements["id"], np.int64)[row],
        "face": face.astype(np.int64),
        "slip": np.zeros(len(row)),
        "rest_overlap": depth,
    }


def _faces(ends: np.ndarray, velocity: Velocity, endless: bool) -> Arrays:
    n = len(ends)
    flat = ends.reshape(n, 4)
    out: Arrays = {name: flat[:, k].copy() for k, name in enumerate(FACE_COLUMNS[:4])}
    out |= {"u": np.full(n, float(velocity[0])), "v": np.full(n, float(velocity[1]))}
    out |= {"wall": np.zeros(n, np.int64), "plane": np.full(n, int(endless), np.int64)}
    return out | {name: np.full(n, -1, np.int64) for name in ("before", "after")}
