# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs of an ablation study: a scene, and the scene without each of its effects."""

from __future__ import annotations

from typing import Any

from floeflow.analysis.estimate.influence import without
from floeflow.analysis.studies.variants import BASE, Variant
from floeflow.scene import Scene
from floeflow.scene.effects import EFFECTS, check_effects

# A push that no effect can be so small as to equal: what it grows to is the run's own chaos.
NUDGE = 1.0e-9
REPEATS = 2


def ablation_variants(scene: Scene) -> list[Variant]:
    """Runs of the study: base, its repeats with a nudge, leave-one-out, and the lean run.

    An effect that others need takes them along. The lean run has what the estimate calls needed.
    The repeats differ by one part in 1e9 of the air's drag: their spread is what chaos and the
    clock alone change.

    Parameters
    ----------
    scene : Scene
        The scene of the study.
    """
    drag = scene.dynamics.air_drag
    runs = [Variant(BASE, label="all effects of the scene")]
    for k in range(1, REPEATS + 1):
        nudged = {"dynamics.air_drag": drag * (1.0 + k * NUDGE)}
        runs.append(Variant(f"repeat-{k}", nudged, "repeat", f"again, nudged ({k})"))
    for name in scene.effects:
        left = check_effects(sorted(without(scene.effects, name)))
        changes: dict[str, Any] = {"effects": list(left)}
        if name == "turning_angle" and "turning_angle" in scene.dynamics.model_fields_set:
            changes["dynamics.turning_angle"] = type(scene.dynamics)().turning_angle
        runs.append(Variant(f"no_{name}", changes, name, f"without {name}"))
    lean = lean_effects(scene)
    if set(lean) != set(scene.effects):
        runs.append(Variant("lean", {"effects": list(lean)}, "lean", "what is needed"))
    return runs


def lean_effects(scene: Scene) -> tuple[str, ...]:
    """Those of the scene's effects that the estimate calls needed, what they need, and output.

    Parameters
    ----------
    scene : Scene
        Its keys.
    """
    from floeflow.analysis.estimate.choose import recommended, scene_estimates

    rows = [row for row in scene_estimates(scene) if row.name in scene.effects]
    chosen = set(recommended(rows, scene.effects))
    return tuple(name for name in EFFECTS if name in chosen)
