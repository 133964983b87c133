# SPDX-License-Identifier: GPL-2.0-or-later
"""Files of polygons that a scene names, for lists of inputs that read none of them."""

from __future__ import annotations

from floeflow.core.polygon_names import files_of_polygons, is_polygon_file
from floeflow.scene.blocks import Mask


def polygon_inputs(mask: Mask) -> list[str]:
    """Files of the polygons that a scene's mask names: shoreline and region.

    Parameters
    ----------
    mask : Mask
        Block ``mask`` of the scene.

    Returns
    -------
    list of str
        Empty where neither is a file.
    """
    region = mask.region if is_polygon_file(mask.region) else ""
    return [*files_of_polygons(mask.shoreline), *files_of_polygons(region)]
