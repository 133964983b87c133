# SPDX-License-Identifier: GPL-2.0-or-later
"""What ``floeflow effects`` prints: effects estimated, what to name."""

from __future__ import annotations

import json
from pathlib import Path

from floeflow.analysis.estimate import choose
from floeflow.analysis.estimate.conditions import conditions
from floeflow.analysis.resolve import checked_scene


def tell(path: Path, as_json: bool = False) -> str:
    """The estimates of a scene file as text or JSON.

    Parameters
    ----------
    path : Path
        Scene file.
    as_json : bool, optional
        JSON instead of a table.

    Returns
    -------
    str
        Text to be printed.

    Raises
    ------
    FloeError
        For a scene or input that is refused.
    """
    scene = checked_scene(path)
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
