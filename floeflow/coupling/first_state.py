# SPDX-License-Identifier: GPL-2.0-or-later
"""The first state of a scene in one call, as the workflow's rules make it one by one."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import xarray as xr

from floeflow.coupling.compaction import compactor
from floeflow.coupling.initial import make_state
from floeflow.coupling.sea.reading import with_sea
from floeflow.masks.land import make_land
from floeflow.masks.mask import make_mask
from floeflow.packings.bonds import make_bonds
from floeflow.packings.elements import grid_of
from floeflow.packings.fresh_cells import make_cells
from floeflow.packings.packing import make_packing
from floeflow.scene import Scene
from floeflow.state.cells import Cells, read_cells
from floeflow.state.scene_walls import scene_walls


@dataclass(frozen=True)
class First:
    """A scene's first state, and the fresh cells that it remaps to.

    Parameters
    ----------
    state : xarray.Dataset
        State 0.
    cells : Cells or None
        With the effect ``remap``.
    mask : xarray.Dataset
        Ice and land on the mask grid.
    """

    state: xr.Dataset
    cells: Cells | None
    mask: xr.Dataset


@dataclass(frozen=True)
class Pack:
    """Ice of a scene as elements.

    Parameters
    ----------
    mask, packing : xarray.Dataset
        Outputs of those stages.
    bonds : xarray.Dataset or None
        Output of the stage of that name, with the effect ``bonds``.
    """

    mask: xr.Dataset
    packing: xr.Dataset
    bonds: xr.Dataset | None


def first_pack(scene: Scene, scratch: Path) -> Pack:
    """Make land, mask, packing and bonds of a scene.

    Parameters
    ----------
    scene : Scene
        With concrete effects.
    scratch : Path
        Folder for logs.

    Returns
    -------
    Pack
        Mask, packing and, with the effect ``bonds``, bonds; else None in their place.

    Raises
    ------
    FloeError
        As the stages.
    """
    land = None
    if scene.mask.land == "global_land_mask":
        land = make_land(scene)["land"].values.astype(float)
    mask = make_mask(scene, land)
    if "mixed_layer" in scene.effects:
        mask = with_sea(scene, mask)
    keys, coast, walls = scene.packing, "coast" in scene.effects, scene_walls(scene)
    compact = compactor(grid_of(mask), scratch, walls, scene.period)
    packing = make_packing(mask, keys, scene.seed, coast, compact, walls)
    if "bonds" not in scene.effects:
        return Pack(mask, packing, None)
    bonds = make_bonds(packing, keys.bond_gap, keys.bond_concentration, keys.coast_bonds)
    return Pack(mask, packing, bonds)


def first_state(scene: Scene, scratch: Path) -> First:
    """Make land, mask, packing, bonds and state 0 of a scene; arguments as of `first_pack`.

    Parameters
    ----------
    scene : Scene
        Of which the state is made.
    scratch : Path
        Folder for temporary files.

    Returns
    -------
    First
        State 0, cells where elements are remapped, and mask.

    Raises
    ------
    FloeError
        For input that is refused.
    """
    made = first_pack(scene, scratch)
    mask, packing = made.mask, made.packing
    cells = None
    if "remap" in scene.effects:
        cells = read_cells(make_cells(mask, packing, scene.seed))
    return First(make_state(scene, packing, made.bonds, mask), cells, mask)
