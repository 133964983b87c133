# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls of state 0: faces, and what touches them; every later state has them from there."""

from __future__ import annotations

import numpy as np
import xarray as xr

from floeflow.core.errors import FloeError
from floeflow.scene.blocks import Scene
from floeflow.state.bonds import Arrays
from floeflow.state.scene_walls import make_walls
from floeflow.state.schema import MOBILE
from floeflow.state.walls import distances, join, overlapping, rings

# Ice may overlap a wall at the start. But no centre may lie behind a plane, nor nearer than this
# share of its radius to a line, which would push it to one side or the other.
NEAREST = 0.25


def wall_variables(scene: Scene, packing: xr.Dataset) -> Arrays:
    """Variables of state 0: faces, and contacts of the elements that overlap one at the start.

    The last wall is the coast, where there is one.

    Parameters
    ----------
    scene : Scene
        The scene.
    packing : xarray.Dataset
        Output of the packing stage.

    Returns
    -------
    dict of ndarray
        By the names of the state's schema, ``wall_face_`` and ``wall_contact_``; empty where the
        scene has neither walls nor coast.

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
