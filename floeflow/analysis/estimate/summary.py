# SPDX-License-Identifier: GPL-2.0-or-later
"""What each effect was expected to change and cost, written beside the results.

With ``effects: auto`` these are the reasons of the choice.
"""

from typing import Any

from floeflow.analysis.estimate.choose import numbers_behind, scene_estimates
from floeflow.analysis.estimate.conditions import conditions
from floeflow.scene import Scene


def estimates(scene: Scene, chosen_by: str) -> dict[str, Any]:
    """Choice, conditions and estimates of a scene, in JSON types.

    Parameters
    ----------
    scene : Scene
        With concrete effects.
    chosen_by : str
        ``auto`` or ``scene``: who chose them.
    """
    return {
        "chosen_by": chosen_by,
        "effects": list(scene.effects),
        "conditions": dict(numbers_behind(conditions(scene))),
        "estimates": [row.as_dict() for row in scene_estimates(scene)],
    }
