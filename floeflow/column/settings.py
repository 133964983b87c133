# SPDX-License-Identifier: GPL-2.0-or-later
"""From a scene's keys and effects to the settings of its columns."""

from __future__ import annotations

from floeflow.column.first_thickness import FirstIce
from floeflow.column.params import Settings
from floeflow.scene.blocks import Scene
from floeflow.scene.effects import column_processes


def column_settings(scene: Scene) -> Settings:
    """What the scene asks of its columns.

    Parameters
    ----------
    scene : Scene
        Its keys.

    Returns
    -------
    Settings
        Scheme, processes, categories, steps (s) and constants.
    """
    column = scene.column
    return Settings(
        scheme=column.scheme,
        processes=column_processes(scene.effects),
        categories=column.categories,
        layers=column.layers,
        step=column.step,
        new_ice_thickness=column.new_ice_thickness,
        ocean_salinity=column.ocean_salinity,
        mixed_layer_depth=column.mixed_layer_depth,
        light=column.light,
        variant=column.variant,
        physics=scene.physics,
    )


def first_ice(scene: Scene) -> FirstIce:
    """What the scene says of the ice at its start, and of ice that comes in over its rim.

    Parameters
    ----------
    scene : Scene
        Its keys.

    Returns
    -------
    FirstIce
        Name of the distribution over categories, level share and thickness (m) of ice in leads.
    """
    mask = scene.mask
    return FirstIce(mask.thickness_distribution, mask.level_share, mask.lead_ice)
