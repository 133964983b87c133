# SPDX-License-Identifier: GPL-2.0-or-later
"""What each effect was expected to change and cost, written beside the results.

With ``effects: auto`` these are the reasons of the choice.
"""

import json
from pathlib import Path
from typing import Any

from floeflow.analysis.estimate.choose import numbers_behind, scene_estimates
from floeflow.analysis.estimate.conditions import conditions
from floeflow.scene import Scene
from floeflow.workflow import job as stage


def estimates(scene: Scene) -> dict[str, Any]:
    """Choice, conditions and estimates of a scene, in JSON types."""
    return {
        "chosen_by": "auto" if scene.auto else "scene",
        "effects": list(scene.effects),
        "conditions": dict(numbers_behind(conditions(scene))),
        "estimates": [row.as_dict() for row in scene_estimates(scene)],
    }


def main(snakemake: stage.Snakemake) -> None:
    """Rule ``estimate``."""
    text = json.dumps(estimates(stage.scene(snakemake)), indent=1, allow_nan=False)
    Path(str(snakemake.output.estimates)).write_text(text + "\n")


if "snakemake" in globals():
    stage.run(main, globals()["snakemake"])
