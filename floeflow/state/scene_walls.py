# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls of a scene: sides of its rectangle, further planes, and where a mesh cuts the ice.

What comes out are straight faces (``floeflow.state.walls``), where they stand at time 0. The mask
ends at the planes, the packing keeps clear of all, and state 0 takes them up.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from floeflow.core.errors import FloeError
from floeflow.core.meshes import read_triangles
from floeflow.scene.blocks import Scene
from floeflow.state.bonds import Arrays
from floeflow.state.walls import join, lines, plane


def make_planes(scene: Scene) -> list[Arrays]:
    """Planes that a scene names: sides of its rectangle, then further ones.

    Parameters
    ----------
    scene : Scene
        Its keys.

    Returns
    -------
    list of dict of ndarray
        Table of faces of each plane; empty without the effect ``walls``.

    Raises
    ------
    FloeError
        If one is impossible; names the key.
    """
    if "walls" not in scene.effects:
        return []
    keys, domain = scene.walls, scene.domain
    places = {
        "left": (domain.x_min, domain.y_min, (1.0, 0.0)),
        "right": (domain.x_max, domain.y_max, (-1.0, 0.0)),
        "bottom": (domain.x_min, domain.y_min, (0.0, 1.0)),
        "top": (domain.x_max, domain.y_max, (0.0, -1.0)),
    }
    planes = [plane(*places[side], getattr(keys, f"{side}_velocity")) for side in keys.rim]
    for number, (x, y, nx, ny, u, v) in enumerate(keys.planes, start=1):
        try:
            planes.append(plane(x, y, (nx, ny), (u, v)))
        except FloeError as error:
            raise FloeError(f"walls.planes, number {number}: {error}") from None
    return planes


def make_walls(scene: Scene) -> list[Arrays]:
    """Walls that a scene names, in the order of `wall_names`.

    Parameters
    ----------
    scene : Scene
        Its keys.

    Returns
    -------
    list of dict of ndarray
        Table of faces of each wall.

    Raises
    ------
    FloeError
        If one is impossible; names the key.
    """
    walls = make_planes(scene)
    if "walls" in scene.effects and scene.walls.mesh:
        keys = scene.walls
        ends = cut(*read_triangles(Path(keys.mesh)), keys.mesh)
        walls.append(lines(ends, keys.mesh_velocity, f"{keys.mesh}: the mesh"))
    return walls


def scene_walls(scene: Scene) -> Arrays | None:
    """Faces of all walls that a scene names, or None.

    Parameters
    ----------
    scene : Scene
        Its keys.

    Returns
    -------
    dict of ndarray or None
        One table of faces, numbered by wall.
    """
    walls = make_walls(scene)
    return join(walls) if walls else None


def cut(points: NDArray[np.float64], triangles: NDArray[np.int64], name: str) -> np.ndarray:
    """Lines in which triangles cut the plane of the ice, z = 0.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Corners, m.
    triangles : ndarray, shape (m, 3)
        Rows of `points`.
    name : str
        For the sentence of a fault.

    Returns
    -------
    ndarray, shape (k, 2, 2)
        Ends of each line, m. Triangles that share an edge give the same end, to the bit.

    Raises
    ------
    FloeError
        If no triangle cuts the plane.
    """
    above = points[:, 2] >= 0.0
    ends = []
    for corners in triangles[np.ptp(above[triangles].astype(int), axis=1) > 0]:
        found = []
        for pair in ((0, 1), (1, 2), (0, 2)):
            # Always from the lower row, so that neighbours round alike.
            p, q = sorted(int(corners[k]) for k in pair)
            if above[p] != above[q]:
                share = points[p, 2] / (points[p, 2] - points[q, 2])
                found.append(points[p, :2] + share * (points[q, :2] - points[p, :2]))
        if (found[0] != found[1]).any():
            ends.append(np.array(found))
    if not ends:
        raise FloeError(
            f"{name}: no triangle cuts the plane of the ice (z = 0): give the mesh a height "
            "across it."
        )
    return np.array(ends)
