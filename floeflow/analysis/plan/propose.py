# SPDX-License-Identifier: GPL-2.0-or-later
"""Settings for an error or a budget: all combinations of their levels, by the two models."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

from floeflow.analysis.estimate.conditions import Conditions
from floeflow.analysis.estimate.cost import Coefficients, run_seconds
from floeflow.analysis.plan.precision import ErrorModel, setting_errors, total_error
from floeflow.analysis.studies.numerical_settings import Setting, numerical_settings
from floeflow.core.errors import FloeError
from floeflow.scene import Scene

# Combinations looked at; coarse and fine ends of the settings go first where there are more.
MOST = 4_000


@dataclass(frozen=True)
class Proposal:
    """Settings of a run, with predicted time and error.

    Parameters
    ----------
    changes : dict
        Keys to set, by dotted path; empty: the scene as it stands.
    seconds : float
        Predicted wall time.
    error : float
        Predicted error relative to what happens in the run, largest of the kept norms.
    parts : dict
        Predicted error by setting, in its worst norm.
    """

    changes: dict[str, Any]
    seconds: float
    error: float
    parts: dict[str, float]


def parse_budget(text: str) -> float:
    """Seconds of a time such as ``2h``, ``90m``, ``45s`` or ``1.5d``.

    Parameters
    ----------
    text : str
        Number and unit: s, m, h or d.

    Raises
    ------
    FloeError
        Where it is none.
    """
    found = re.fullmatch(r"([0-9]*\.?[0-9]+)\s*([smhd])", text.strip())
    if not found or float(found[1]) <= 0:
        raise FloeError(f"--budget {text}: give a time such as 2h, 90m, 45s or 1.5d")
    return float(found[1]) * {"s": 1.0, "m": 60.0, "h": 3600.0, "d": 86400.0}[found[2]]


def adjusted(c: Conditions, scene: Scene) -> Conditions:
    """Conditions of the scene for another number of elements.

    Parameters
    ----------
    c : Conditions
        Conditions of the scene.
    scene : Scene
        Its keys.

    Returns
    -------
    Conditions
        Of the scene's number of elements.
    """
    if not c.elements:
        return c
    size = c.element_size * math.sqrt(c.elements / scene.packing.elements)
    return replace(c, elements=scene.packing.elements, element_size=size)


def judge(
    scene: Scene, c: Conditions, ranks: int, fit: Coefficients, model: ErrorModel
) -> tuple[float, dict[str, dict[str, float]]]:
    """Predicted wall time of a scene, and errors by setting and norm.

    Parameters
    ----------
    scene : Scene
        Its keys.
    c : Conditions
        Conditions of the scene.
    ranks : int
        Number of MPI ranks.
    fit : Coefficients
        Coefficients of the cost model.
    model : ErrorModel
        Measured laws of the errors.

    Returns
    -------
    tuple of float and dict of dict of float
        s; relative errors.
    """
    own = adjusted(c, scene)
    return run_seconds(own, scene, scene.effects, ranks, fit), setting_errors(scene, own, model)


def proposals(
    scene: Scene, c: Conditions, ranks: int, fit: Coefficients, model: ErrorModel
) -> list[Proposal]:
    """All combinations of the settings' levels, the scene itself first.

    Each setting's share of work and error is taken from the models with this setting alone changed:
    errors add as squares, the time is asked of the cost model for each combination.

    Parameters
    ----------
    scene : Scene
        Its keys.
    c : Conditions
        Conditions of the scene.
    ranks : int
        Number of MPI ranks.
    fit : Coefficients
        Coefficients of the cost model.
    model : ErrorModel
        Measured laws of the errors.

    Returns
    -------
    list of Proposal
        With predicted time (s) and error (1).
    """
    varied = [setting for setting in numerical_settings(scene) if model.knows(setting.name)]
    choices = [_levels(setting) for setting in varied]
    while math.prod(len(levels) for levels in choices) > MOST:
        longest = max(choices, key=len)
        longest.pop()
    found = []
    for levels in product(*choices):
        changes: dict[str, Any] = {}
        for setting, level in zip(varied, levels, strict=True):
            if level != 1.0:
                changes |= setting.changes(level)
        trial = _fast(scene, changes)
        seconds, errors = judge(trial, c, ranks, fit, model)
        parts = {setting: max(e.values(), default=0.0) for setting, e in errors.items()}
        found.append(Proposal(changes, seconds, total_error(errors), parts))
    return sorted(found, key=lambda p: bool(p.changes))


def _levels(setting: Setting) -> list[float]:
    """Levels, the scene's own first, then those nearest to it."""
    return sorted(setting.levels, key=lambda level: abs(math.log(level)))


def _fast(scene: Scene, changes: Mapping[str, Any]) -> Scene:
    """The scene with keys set anew, not validated: their values are valid by themselves."""
    for path, value in changes.items():
        block, _, key = path.partition(".")
        part = getattr(scene, block).model_copy(update={key: value})
        scene = scene.model_copy(update={block: part})
    return scene


def for_error(found: Sequence[Proposal], error: float) -> Proposal | None:
    """Fastest proposal of at most this error.

    Parameters
    ----------
    found : sequence of Proposal
        Proposals.
    error : float
        Relative error, 0.05 for 5 %.

    Returns
    -------
    Proposal or None
        None where there is none.
    """
    good = [p for p in found if p.error <= error]
    return min(good, key=lambda p: (p.seconds, p.error)) if good else None


def for_budget(found: Sequence[Proposal], seconds: float) -> Proposal | None:
    """Most accurate proposal of at most this time.

    Parameters
    ----------
    found : sequence of Proposal
        Proposals.
    seconds : float
        Wall time (s).

    Returns
    -------
    Proposal or None
        None where there is none.
    """
    good = [p for p in found if p.seconds <= seconds]
    return min(good, key=lambda p: (p.error, p.seconds)) if good else None
