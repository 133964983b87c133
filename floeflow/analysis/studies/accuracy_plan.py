# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs of an accuracy study: each knob varied alone, all together, and repeats with a nudge."""

from __future__ import annotations

from floeflow.analysis.studies.ablation_plan import NUDGE, REPEATS
from floeflow.analysis.studies.knobs import Changes, Knob, knobs
from floeflow.analysis.studies.variants import BASE, Variant
from floeflow.scene import Scene

TOGETHER = "together"
# Steps along each knob's levels from the scene's own, of the runs that vary all knobs at once. The
# first is the reference: the finest of all, but for the elements, which are the same ones.
MOVES = {"finest": -9, "fine": -1, "coarse": 1, "coarsest": 9}
KEPT = ("element_size",)


def accuracy_variants(scene: Scene) -> list[Variant]:
    """Runs of the study."""
    drag = scene.dynamics.air_drag
    runs = [Variant(BASE, label="as the scene has it")]
    for k in range(1, REPEATS + 1):
        nudged = {"dynamics.air_drag": drag * (1.0 + k * NUDGE)}
        runs.append(Variant(f"repeat-{k}", nudged, "repeat", f"again, nudged ({k})"))
    for knob in knobs(scene):
        for place, level in enumerate(knob.levels):
            if level != 1.0:
                label = f"{knob.text}: {knob.told(level)}"
                name = f"{knob.name}-{place}"
                runs.append(Variant(name, knob.changes(level), knob.name, label))
    for name, move in MOVES.items():
        label = f"all settings {name}"
        runs.append(Variant(f"all-{name}", _together(scene, move), TOGETHER, label))
    return runs


def _together(scene: Scene, move: int) -> Changes:
    changes: Changes = {}
    for knob in knobs(scene):
        if knob.name not in KEPT or move > 0:
            changes |= knob.changes(moved_level(knob, move))
    return changes


def moved_level(knob: Knob, move: int) -> float:
    """Level so many places from the scene's own, kept within the knob's range.

    Parameters
    ----------
    knob : Knob
        Numerical setting.
    move : int
        Places, negative towards finer levels.

    Returns
    -------
    float
        Relative to the scene's own.
    """
    place = knob.levels.index(1.0) + move
    return knob.levels[min(max(place, 0), len(knob.levels) - 1)]
