# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs of an ensemble study: each setting finer and coarser, with members that chaos drives apart.

Where ice breaks, two runs that differ in the last bit end with other cracks. Settings are then
compared by the statistics of members, which differ in the stress of the wind.
"""

from __future__ import annotations

from floeflow.analysis.studies.accuracy_plan import KEPT, TOGETHER, moved_level
from floeflow.analysis.studies.numerical_settings import Changes, Setting, numerical_settings
from floeflow.analysis.studies.variants import BASE, Variant
from floeflow.scene import Scene

STUDY = "ensemble"
# Members of the scene itself and of what it is compared with; in comparisons of many with one,
# that one is best repeated more often (Dunnett 1955).
BASE_MEMBERS, MEMBERS = 8, 3
# Relative change of the wind's stress from one member to the next. It must be large enough for the
# members to break differently within the run, and small beside what winds are known to; smaller
# ones are compared with it in the base run.
NUDGE = 1.0e-3
# The same of two runs whose distance shows how fast they part.
PARTING = (1.0e-12, 1.0e-6, 1.0e-3)
AGAIN = "again"
# Steps along each setting's levels of the runs that change all of them.
MOVES = {"fine": -1, "coarse": 1}
# Settings that the statistics do not see: how results are brought to a grid afterwards.
UNSEEN = ("grid_transfer",)


def seen_settings(scene: Scene) -> list[Setting]:
    """Settings that act on the statistics in a scene.

    Parameters
    ----------
    scene : Scene
        Its keys.
    """
    return [setting for setting in numerical_settings(scene) if setting.name not in UNSEEN]


def tried_levels(setting: Setting) -> list[float]:
    """Levels that are run: the next finer, the next coarser and the coarsest.

    Parameters
    ----------
    setting : Setting
        A numerical setting.
    """
    levels = [moved_level(setting, -1), moved_level(setting, 1), setting.levels[-1]]
    return [level for level in dict.fromkeys(levels) if level != 1.0]


def ensemble_variants(scene: Scene) -> list[Variant]:
    """Runs of the study: the scene, the scene again with other members, and its settings.

    Parameters
    ----------
    scene : Scene
        Its keys.
    """
    runs = [
        Variant(BASE, label="as the scene has it"),
        Variant(AGAIN, {}, AGAIN, "as the scene has it, other members"),
    ]
    for setting in seen_settings(scene):
        for level in tried_levels(setting):
            name = f"{setting.name}-{setting.levels.index(level)}"
            label = f"{setting.text}: {setting.told(level)}"
            runs.append(Variant(name, setting.changes(level), setting.name, label))
    for name, move in MOVES.items():
        changes: Changes = {}
        for setting in seen_settings(scene):
            # Finer elements are left out: they would cost more than all the others.
            if setting.name not in KEPT or move > 0:
                changes |= setting.changes(moved_level(setting, move))
        runs.append(Variant(f"all-{name}", changes, TOGETHER, f"all settings one level {name}r"))
    return runs


def nudges(variant: str) -> list[float]:
    """Factors on the wind's stress of a variant's members.

    They lie on both sides of 1 in the same places for every setting, so that what the nudge itself
    changes is the same on both sides of a comparison; `AGAIN` has places between.

    Parameters
    ----------
    variant : str
        Name of the run.

    Returns
    -------
    list of float
        1, one a member.
    """
    count = BASE_MEMBERS if variant in (BASE, AGAIN) else MEMBERS
    places = [(k + 1) // 2 * (-1) ** k for k in range(count)]  # 0, -1, 1, -2, ...
    between = 0.5 if variant == AGAIN else 0.0
    return [1.0 + NUDGE * (place + between) for place in places]
