# SPDX-License-Identifier: GPL-2.0-or-later
"""How far a scene's settings are from the limit: the error model of plans.

Each setting of the accuracy study has a dimensionless resolution x, which scenes have in common,
and an error C x^p in each norm, fitted to the studies of the example scenes. A choice, such as the
column's scheme, has an error of its own for each of its values. Errors of different settings add up
as squares.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from floeflow.analysis.studies.measures import KEPT
from floeflow.analysis.studies.numerical_settings import numerical_settings

if TYPE_CHECKING:
    from floeflow.analysis.estimate.conditions import Conditions
    from floeflow.scene import Scene

PRECISION = Path(__file__).with_name("precision.json")


@dataclass(frozen=True)
class ErrorModel:
    """Fitted errors.

    Parameters
    ----------
    laws : mapping
        Setting, norm: factor and order of the error.
    choices : mapping
        Setting, value, norm: error; values that are not there are the best and have none.
    """

    laws: Mapping[str, Mapping[str, tuple[float, float]]]
    choices: Mapping[str, Mapping[str, Mapping[str, float]]] = field(default_factory=dict)

    def knows(self, setting: str) -> bool:
        """Whether it says anything of a setting.

        Parameters
        ----------
        setting : str
            Name of a numerical setting.
        """
        return setting in self.laws or setting in self.choices


def error_model() -> ErrorModel:
    """The fitted error model."""
    data = json.loads(PRECISION.read_text())
    return ErrorModel(data["errors"], data["choices"])


def resolutions(scene: Scene, c: Conditions) -> dict[str, float]:
    """Dimensionless resolution of each setting that acts in a scene; small is fine.

    step_share: of the critical step. softness: strain of the pack, pushed by the wind over its
    width. element_size: over the width of the ice. window: over the run. forcing_grid: change of
    the wind over a cell, relative to it. column_step: over the run. category_width: over the range
    of thicknesses. layer_thickness: over the ice.

    Parameters
    ----------
    scene : Scene
        Its keys.
    c : Conditions
        Conditions of the scene.

    Returns
    -------
    dict of float
        1, by setting.
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
        found["category_width"] = 1.0 / scene.column.categories
        if scene.column.scheme != "zero_layer":
            found["layer_thickness"] = 1.0 / scene.column.layers
    return found


def choices(scene: Scene) -> dict[str, str]:
    """Values of the settings that are choices between ways.

    Parameters
    ----------
    scene : Scene
        Its keys.
    """
    return {
        setting.name: setting.told(1.0) for setting in numerical_settings(scene) if setting.ways
    }


def setting_errors(scene: Scene, c: Conditions, model: ErrorModel) -> dict[str, dict[str, float]]:
    """Predicted relative error of each setting in each norm.

    Parameters
    ----------
    scene : Scene
        Its keys.
    c : Conditions
        Conditions of the scene.
    model : ErrorModel
        Measured laws of the errors.

    Returns
    -------
    dict of dict of float
        1, by setting and norm.
    """
    found = {}
    for setting, x in resolutions(scene, c).items():
        laws = model.laws.get(setting, {})
        found[setting] = {norm: factor * x**order for norm, (factor, order) in laws.items()}
    for setting, value in choices(scene).items():
        found[setting] = dict(model.choices.get(setting, {}).get(value, {}))
    return found


def total_error(
    errors: Mapping[str, Mapping[str, float]], norms: Iterable[str] = KEPT, but: Iterable[str] = ()
) -> float:
    """Largest over the norms of the root of the sum of squares over the settings.

    `but` names settings that are left out.

    Parameters
    ----------
    errors : mapping of mapping of float
        Relative error by setting and norm.
    norms : iterable of str, optional
        Those that count.
    but : iterable of str, optional
        Settings that are left out.

    Returns
    -------
    float
        1; 0 without errors.
    """
    kept = [found for setting, found in errors.items() if setting not in tuple(but)]
    return max(
        (math.sqrt(sum(found.get(norm, 0.0) ** 2 for found in kept)) for norm in norms), default=0.0
    )
