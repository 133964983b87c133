# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls as straight faces in the plane of the ice: planes, and lines that may join.

A plane has no ends and ice on its left side only, as one looks from a to b. A line has two ends
and two sides; where it meets another line of its wall, each knows the other, so that ice is pushed
once by a corner and slides from line to line. All faces of a wall move at its constant velocity,
from where they are at time 0. Preprocessing, engine and tests share it.
"""

from __future__ import annotations

import numpy as np
import shapely

from floeflow.core.errors import FloeError
from floeflow.state.bonds import Arrays

# Columns of a face, and of a contact with one, in the plugin's order (liggghts_models/capi/capi.h).
FACE_NUMBERS = ("wall", "plane", "before", "after")
FACE_COLUMNS = ("ax", "ay", "bx", "by", "u", "v")

# Share of its radius that keeps an element from walls: a little more than the share that ridges
# against a wall do not take (`core_share` in wall_law.cpp).
LEAST_CLEARANCE = 0.35

Velocity = tuple[float, float]


def plane(x: float, y: float, normal: Velocity, velocity: Velocity = (0.0, 0.0)) -> Arrays:
    """Wall of one plane through a point, with ice on the side to which its normal points.

    Parameters
    ----------
    x : float
        Point of the plane (m).
    y : float
        Point of the plane (m).
    normal : Velocity
        Towards the ice, of any length.
    velocity : Velocity, optional
        m/s.

    Returns
    -------
    dict of ndarray
        Table of one face.

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

    Returns
    -------
    dict of ndarray
        Table of faces, (lines,) each; ``before`` and ``after`` are rows of those that join, -1
        where none does.

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


def rings(start: np.ndarray, corner: np.ndarray) -> Arrays:
    """Wall that stands still, of closed rings: starts (k + 1,) and corners (c, 2) in metres.

    Rings may touch each other: each line knows those of its own ring only.

    Parameters
    ----------
    start : ndarray
        First corner of each ring, (k + 1,).
    corner : ndarray
        m, (c, 2).

    Returns
    -------
    Arrays
        Table of faces.
    """
    count = len(corner)
    first = np.repeat(start[:-1], np.diff(start))
    last = np.repeat(start[1:], np.diff(start)) - 1
    row = np.arange(count)
    after = np.where(row == last, first, row + 1)
    out = _faces(np.stack([corner, corner[after]], axis=1), (0.0, 0.0), False)
    out["after"] = after
    out["before"] = np.where(row == first, last, row - 1)
    return out


def enclosed(faces: Arrays, wall: int, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Whether points (n,) lie inside of the closed rings of a wall, as of the coast around land.

    Parameters
    ----------
    faces : Arrays
        Table of faces.
    wall : int
        Number of the wall.
    x : ndarray
        Points (m), (n,).
    y : ndarray
        Points (m), (n,).

    Returns
    -------
    ndarray
        (n,), bool.
    """
    rows = np.flatnonzero(faces["wall"] == wall)
    corners = np.column_stack([faces["ax"], faces["ay"]])[rows]
    if not len(rows):
        return np.zeros(len(x), dtype=bool)
    # A ring ends where a face is followed by an earlier one.
    last = faces["after"][rows] < rows
    ring = np.concatenate([[0], np.cumsum(last)[:-1]])
    inside = np.zeros(len(x), dtype=bool)
    points = shapely.points(x, y)
    # Water inside of land is a ring within a ring.
    rings_of_it = np.asarray(shapely.linearrings(corners, indices=ring), dtype=object)
    for polygon in (shapely.Polygon(each) for each in rings_of_it.ravel()):
        shapely.prepare(polygon)
        inside ^= shapely.contains(polygon, points)
    return inside


def join(walls: list[Arrays]) -> Arrays:
    """Faces of all walls, numbered in their order.

    Parameters
    ----------
    walls : list of Arrays
        Tables of faces.

    Returns
    -------
    dict of ndarray
        One table; ``wall`` counts from 0.
    """
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

    Parameters
    ----------
    faces : Arrays
        Table of faces.
    x : ndarray
        Points (m).
    y : ndarray
        Points (m).
    time : float, optional
        s since the start.

    Returns
    -------
    ndarray
        m.
    """
    tx, ty = faces["bx"] - faces["ax"], faces["by"] - faces["ay"]
    length = np.hypot(tx, ty)
    dx, dy = x - faces["ax"] - faces["u"] * time, y - faces["ay"] - faces["v"] * time
    height = (dy * tx - dx * ty) / length
    share = np.clip((dx * tx + dy * ty) / length**2, 0.0, 1.0)
    away = np.hypot(dx - share * tx, dy - share * ty)
    return np.asarray(np.where(faces["plane"] != 0, height, away))


def nearest_points(faces: Arrays, place: np.ndarray, time: float = 0.0) -> np.ndarray:
    """Points (m) of faces, one for each place (n, 2), that are nearest to it at a time (s).

    Parameters
    ----------
    faces : Arrays
        Table of faces, (n,).
    place : ndarray
        m, (n, 2).
    time : float, optional
        s since the start.

    Returns
    -------
    ndarray
        m, (n, 2).
    """
    start = np.column_stack([faces["ax"] + faces["u"] * time, faces["ay"] + faces["v"] * time])
    along = np.column_stack([faces["bx"] - faces["ax"], faces["by"] - faces["ay"]])
    share = ((place - start) * along).sum(axis=1) / (along**2).sum(axis=1)
    share = np.where(faces["plane"] != 0, share, np.clip(share, 0.0, 1.0))
    return np.asarray(start + share[:, None] * along)


def clearance(
    faces: Arrays,
    x: np.ndarray,
    y: np.ndarray,
    time: float = 0.0,
    farthest: float | None = None,
) -> np.ndarray:
    """Distance (m) of each point (n,) from the nearest face; infinite where there is none.

    Parameters
    ----------
    faces : Arrays
        Table of faces.
    x : ndarray
        Points (m), (n,).
    y : ndarray
        Points (m), (n,).
    time : float, optional
        s since the start.
    farthest : float, optional
        Lines further off than this (m) may be left out, which is faster.

    Returns
    -------
    ndarray
        m, (n,).
    """
    planes, lined = (np.flatnonzero(faces["plane"] == kind) for kind in (1, 0))
    out = np.full(len(x), np.inf)
    if len(planes):
        some = {name: values[planes] for name, values in faces.items()}
        out = distances(some, x[:, None], y[:, None], time).min(axis=1, initial=np.inf)
    if len(lined) and len(x):
        tree = shapely.STRtree(_segments(faces, lined, time))
        found, far = tree.query_nearest(
            shapely.points(x, y), farthest, return_distance=True, all_matches=False
        )
        np.minimum.at(out, found[0], far)
    return out


def _segments(faces: Arrays, rows: np.ndarray, time: float) -> np.ndarray:
    """Lines of some faces at a time (s)."""
    ends = [
        np.column_stack(
            [faces[f"{end}x"] + faces["u"] * time, faces[f"{end}y"] + faces["v"] * time]
        )
        for end in "ab"
    ]
    return np.asarray(shapely.linestrings(np.stack(ends, axis=1)[rows]))


def crossed(faces: Arrays, start: np.ndarray, end: np.ndarray, time: float = 0.0) -> np.ndarray:
    """Whether the way between two points, (n, 2) each, crosses a line, (n,).

    Parameters
    ----------
    faces : Arrays
        Table of faces.
    start : ndarray
        m, (n, 2).
    end : ndarray
        m, (n, 2).
    time : float, optional
        At which walls are where they are, s.

    Returns
    -------
    ndarray
        bool.
    """
    out = np.zeros(len(start), dtype=bool)
    moved = np.flatnonzero((start != end).any(axis=1))
    if len(faces["ax"]) == 0 or not len(moved):
        return out
    # Only what is nearer to a face than it moves can cross one.
    size = np.hypot(*(end - start)[moved].T)
    x, y = start[moved].T
    away = clearance(faces, x, y, time, float(size.max()))
    moved = moved[away <= size]
    a = np.column_stack([faces["ax"], faces["ay"]])
    along = np.column_stack([faces["bx"], faces["by"]]) - a
    a = a + time * np.column_stack([faces["u"], faces["v"]])
    for row in moved:
        way = end[row] - start[row]
        to_start, to_end = start[row] - a, end[row] - a
        side = _cross(along, to_start) * _cross(along, to_end) <= 0.0
        ends = _cross(way, a - start[row]) * _cross(way, a + along - start[row]) <= 0.0
        out[row] = bool((side & ends).any())
    return out


def too_near(
    faces: Arrays, start: np.ndarray, end: np.ndarray, radius: np.ndarray, time: float = 0.0
) -> np.ndarray:
    """Whether elements that are moved, (n, 2), leave too little room for ridges at a face, (n,).

    Too near is nearer than before and than the share of the radius that no ridge takes.

    Parameters
    ----------
    faces : Arrays
        Table of faces.
    start, end : ndarray
        Centres before and after (m), (n, 2).
    radius : ndarray
        m, (n,).
    time : float, optional
        At which walls are where they are, s.

    Returns
    -------
    ndarray
        bool.
    """
    least = LEAST_CLEARANCE * radius
    most = float(least.max(initial=0.0))
    out = np.zeros(len(radius), dtype=bool)
    if most == 0.0:
        return out
    new = clearance(faces, end[:, 0], end[:, 1], time, most)
    near = np.flatnonzero(new < least)
    x, y = start[near].T
    out[near] = new[near] < clearance(faces, x, y, time)
    return out


def unsafe(
    faces: Arrays, start: np.ndarray, end: np.ndarray, radius: np.ndarray, time: float = 0.0
) -> np.ndarray:
    """Whether elements that are moved, (n, 2), would lie behind a face or `too_near` to it, (n,).

    Parameters
    ----------
    faces : Arrays
        Table of faces.
    start : ndarray
        Centres before and after (m), (n, 2).
    end : ndarray
        Centres before and after (m), (n, 2).
    radius : ndarray
        m, (n,).
    time : float, optional
        At which walls are where they are, s.

    Returns
    -------
    ndarray
        bool.
    """
    near = too_near(faces, start, end, radius, time)
    return np.asarray(near | crossed(faces, start, end, time))


def _cross(one: np.ndarray, two: np.ndarray) -> np.ndarray:
    return np.asarray(one[..., 0] * two[..., 1] - one[..., 1] * two[..., 0])


def overlapping(faces: Arrays, elements: Arrays, time: float = 0.0) -> Arrays:
    """Contacts without force of the elements that overlap a wall: rest overlap is what there is.

    Parameters
    ----------
    faces : Arrays
        Table of faces.
    elements : Arrays
        Table of n elements.
    time : float, optional
        s since the start.

    Returns
    -------
    dict of ndarray, shape (n,)
        Table as `Engine.load` takes it: id, face, slip and rest_overlap (m), sorted.
    """
    x, y, radius = (np.asarray(elements[name]) for name in ("x", "y", "radius"))
    planes, lined = (np.flatnonzero(faces["plane"] == kind) for kind in (1, 0))
    row = np.repeat(np.arange(len(x)), len(planes))
    face = np.tile(planes, len(x))
    if len(lined) and len(x):
        tree = shapely.STRtree(_segments(faces, lined, time))
        near = tree.query(shapely.points(x, y), predicate="dwithin", distance=radius)
        row, face = np.append(row, near[0]), np.append(face, lined[near[1]])
    some = {name: values[face] for name, values in faces.items()}
    depth = radius[row] - distances(some, x[row], y[row], time)
    order = np.lexsort((face, row))
    order = order[depth[order] > 0]
    row, face, depth = row[order], face[order], depth[order]
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
