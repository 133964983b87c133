# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs of an accuracy study: each setting varied alone, all together, and repeats with a nudge."""

from __future__ import annotations

from floeflow.analysis.studies.ablation_plan import NUDGE, REPEATS
from floeflow.analysis.studies.numerical_settings import Changes, Setting, numerical_settings
from floeflow.analysis.studies.variants import BASE, Variant
from floeflow.scene import Scene

TOGETHER = "together"
# Steps along each setting's levels from the scene's own, of the runs that vary all of them at once.
# The first is the reference: the finest of all, but for the elements, which are the same ones.
MOVES = {"finest": -9, "fine": -1, "coarse": 1, "coarsest": 9}
KEPT = ("element_size",)


def accuracy_variants(scene: Scene) -> list[Variant]:
    """Runs of the study.

    Parameters
    ----------
    scene : Scene
        Its keys.
    """
    drag = scene.dynamics.air_drag
    runs = [Variant(BASE, label="as the scene has it")]
    for k in range(1, REPEATS + 1):
        nudged = {"dynamics.air_drag": drag * (1.0 + k * NUDGE)}
        runs.append(Variant(f"repeat-{k}", nudged, "repeat", f"again, nudged ({k})"))
    for setting in numerical_settings(scene):
        for place, level in enumerate(setting.levels):
            if level != 1.0:
                label = f"{setting.text}: {setting.told(level)}"
                name = f"{setting.name}-{place}"
                runs.append(Variant(name, setting.changes(level), setting.name, label))
    for name, move in MOVES.items():
        label = f"all settings {name}"
        runs.append(Variant(f"all-{name}", _together(scene, move), TOGETHER, label))
    return runs


def _together(scene: Scene, move: int) -> Changes:
    changes: Changes = {}
    for setting in numerical_settings(scene):
        if setting.name not in KEPT or move > 0:
            changes |= setting.changes(moved_level(setting, move))
    return changes


def moved_level(setting: Setting, move: int) -> float:
    """Level so many places from the scene's own, kept within the setting's range.

    Parameters
    ----------
    setting : Setting
        Numerical setting.
    move : int
        Places, negative towards finer levels.

    Returns
    -------
    float
        Relative to the scene's own.
    """
    place = setting.levels.index(1.0) + move
    return setting.levels[min(max(place, 0), len(setting.levels) - 1)]
