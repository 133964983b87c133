# SPDX-License-Identifier: GPL-2.0-or-later
"""``python -m floeflow.scene.effects SCENE``: effects estimated, what to name."""

from __future__ import annotations

import argparse
import json
import logging
from functools import partial
from pathlib import Path

from floeflow.core.errors import answer


def main() -> int:
    """Print the table for a scene, the numbers behind it and a recommendation."""
    parser = argparse.ArgumentParser(prog="python -m floeflow.scene.effects", description=__doc__)
    parser.add_argument("scene", type=Path, help="a scene file")
    parser.add_argument("--json", action="store_true", help="print JSON instead")
    given = parser.parse_args()
    logging.disable(logging.WARNING)
    return answer(partial(tell, given.scene, given.json))


def tell(path: Path, as_json: bool = False) -> str:
    """The estimates of a scene file as text or JSON."""
    from floeflow.analysis.estimate import choose
    from floeflow.analysis.estimate.conditions import conditions
    from floeflow.scene import load_scene

    scene = load_scene(path)
    c = conditions(scene)
    rows = choose.scene_estimates(scene)
    wanted = choose.choose(scene)
    if as_json:
        return json.dumps(
            {
                "scene": scene.name,
                "effects": list(scene.effects),
                "recommended": list(wanted),
                "conditions": dict(choose.numbers_behind(c)),
                "estimates": [row.as_dict() for row in rows],
            },
            indent=1,
        )
    lines = [f"Scene {scene.name}. Estimated with its effects:", "", choose.as_table(rows), ""]
    lines += ["Influence: change of positions, ice volume or ice area by the effect, relative to"]
    lines += ["what happens in the run. Cost: share of the run time. Numbers:"]
    lines += [f"  {row.name}: {row.meaning}" for row in rows if row.number is not None]
    lines += ["", "From the scene:"]
    lines += [f"  {name} = {value:.4g}" for name, value in choose.numbers_behind(c).items()]
    lines += ["", f"Recommended: effects: [{', '.join(wanted)}]"]
    return "\n".join(lines)
