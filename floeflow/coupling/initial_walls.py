# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls of a scene: sides of its rectangle, further planes, and where a mesh cuts the ice.

What comes out are straight faces (``floeflow.state.walls``); state 0 takes them up, and every
later state has them from there.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from floeflow.core.errors import FloeError
from floeflow.core.meshes import read_triangles
from floeflow.scene.blocks import Scene
from floeflow.state.bonds import Arrays
from floeflow.state.schema import MOBILE
from floeflow.state.walls import distances, join, lines, overlapping, plane, rings

# Ice may overlap a wall at the start. But no centre may lie behind a plane, nor nearer than this
# share of its radius to a line, which would push it to one side or the other.
NEAREST = 0.25


def make_walls(scene: Scene) -> list[Arrays]:
    """Walls that a scene names, in the order of `wall_names`.

    Raises
    ------
    FloeError
        If there is none, or one is impossible; names the key.
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
    walls = [plane(*places[side], getattr(keys, f"{side}_velocity")) for side in keys.rim]
    for number, (x, y, nx, ny, u, v) in enumerate(keys.planes, start=1):
        try:
            walls.append(plane(x, y, (nx, ny), (u, v)))
        except FloeError as error:
            raise FloeError(f"walls.planes, number {number}: {error}") from None
    if keys.mesh:
        ends = cut(*read_triangles(Path(keys.mesh)), keys.mesh)
        walls.append(lines(ends, keys.mesh_velocity, f"{keys.mesh}: the mesh"))
    return walls


def scene_walls(scene: Scene) -> Arrays | None:
    """Faces of all walls that a scene names, or None."""
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


def wall_variables(scene: Scene, packing: xr.Dataset) -> Arrays:
    """Variables of state 0: faces, and contacts of the elements that overlap one at the start.

    The last wall is the coast, where there is one.

    Parameters
    ----------
    scene : Scene
        The scene.
    packing : xarray.Dataset
        Output of the packing stage.

    Raises
    ------
    FloeError
        If a wall stands in the ice; names it, and the element.
    """
    walls = make_walls(scene)
    mobile = packing["type"].values == MOBILE
    ice = {name: packing[name].values[mobile] for name in ("id", "x", "y", "radius")}
    if walls:
        _check_clear(join(walls), ice, scene.walls.names)
    if "coast" in scene.effects:
        corner = np.column_stack([packing["coast_x"].values, packing["coast_y"].values])
        walls.append(rings(packing["coast_start"].values, corner))
    faces = join(walls)
    contacts = overlapping(faces, ice)
    out = {f"wall_face_{name}": values for name, values in faces.items()}
    return out | {f"wall_contact_{name}": values for name, values in contacts.items()}


def _check_clear(faces: Arrays, ice: Arrays, names: tuple[str, ...]) -> None:
    x, y, radius = (ice[name][:, None] for name in ("x", "y", "radius"))
    share = distances(faces, x, y) / radius - np.where(faces["plane"] != 0, 0.0, NEAREST)
    if share.size == 0 or share.min() >= 0.0:
        return
    row, face = np.unravel_index(int(np.argmin(share)), share.shape)
    where = (
        "behind it"
        if faces["plane"][face]
        else f"{share[row, face] + NEAREST:.2g} radii from it ({NEAREST:g} are asked for)"
    )
    raise FloeError(
        f"walls: '{names[faces['wall'][face]]}' stands in the ice: the centre of element "
        f"{ice['id'][row]} at ({ice['x'][row]:.6g}, {ice['y'][row]:.6g}) m lies {where}."
    )
