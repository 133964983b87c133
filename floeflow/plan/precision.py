# SPDX-License-Identifier: GPL-2.0-or-later
"""How far a scene's settings are from the limit: the error model of plans.

Each knob of the accuracy study has a dimensionless resolution x, which scenes have in common, and
an error C x^p in each norm, fitted to the studies of the example scenes. Errors of different knobs
add up as squares.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from floeflow.studies.measures import KEPT

if TYPE_CHECKING:
    from floeflow.config import Scene
    from floeflow.estimate.conditions import Conditions

PRECISION = Path(__file__).with_name("precision.json")
# knob -> norm -> (factor, order)
Model = Mapping[str, Mapping[str, tuple[float, float]]]


def error_model() -> Model:
    """The fitted error model."""
    data: Model = json.loads(PRECISION.read_text())["errors"]
    return data


def resolutions(scene: Scene, c: Conditions) -> dict[str, float]:
    """Dimensionless resolution of each knob that acts in a scene; small is fine.

    step_share: of the critical step. softness: strain of the pack, pushed by the wind over its
    width. element_size: over the width of the ice. window: over the run. forcing_grid: change of
    the wind over a cell, relative to it. column_step: over the run.
    """
    thickness = max(c.thickness, 1e-3)
    found = {
        "step_share": scene.dynamics.step_share,
        "softness": c.wind_stress * c.fetch / (scene.dynamics.contact_modulus * thickness),
        "element_size": c.element_size / c.fetch if c.fetch else 0.0,
        "window": scene.time.window / c.seconds,
        "forcing_grid": scene.domain.spacing * c.wind_gradient / max(c.wind, 1e-6),
    }
    if "thermodynamics" in scene.effects:
        found["column_step"] = min(scene.column.step, scene.time.window) / c.seconds
    return found


def knob_errors(scene: Scene, c: Conditions, model: Model) -> dict[str, dict[str, float]]:
    """Predicted relative error of each knob in each norm."""
    found = {}
    for knob, x in resolutions(scene, c).items():
        laws = model.get(knob, {})
        found[knob] = {norm: factor * x**order for norm, (factor, order) in laws.items()}
    return found


def total_error(
    errors: Mapping[str, Mapping[str, float]], norms: Iterable[str] = KEPT, but: Iterable[str] = ()
) -> float:
    """Largest over the norms of the root of the sum of squares over the knobs.

    `but` names knobs that are left out.
    """
    kept = [found for knob, found in errors.items() if knob not in tuple(but)]
    return max(
        (math.sqrt(sum(found.get(norm, 0.0) ** 2 for found in kept)) for norm in norms), default=0.0
    )
