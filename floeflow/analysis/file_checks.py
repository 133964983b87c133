# SPDX-License-Identifier: GPL-2.0-or-later
"""All files that a scene's stages read, looked at before the first of them runs."""

from __future__ import annotations

from floeflow.coupling.sea.reading import check_sea_file
from floeflow.forcings.inputs import check_forcing_file
from floeflow.masks.mask_file import check_mask_file
from floeflow.masks.regions import check_regions
from floeflow.packings.sizes import sized_polygons
from floeflow.scene import Scene


def check_files(scene: Scene) -> None:
    """Refuse a scene with a file that one of its stages could not use.

    Parameters
    ----------
    scene : Scene
        With concrete effects.

    Raises
    ------
    FloeError
        One sentence that names the file, or the key that names none.
    """
    check_mask_file(scene)
    check_regions(scene)
    if scene.packing.size.polygons:
        sized_polygons(scene.packing.size.polygons, scene.domain.crs)
    check_forcing_file(scene)
    if "mixed_layer" in scene.effects:
        check_sea_file(scene)
