# SPDX-License-Identifier: GPL-2.0-or-later
"""The studies by name, and the runs that each is made of."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

from floeflow.analysis.studies.ablation_plan import ablation_variants
from floeflow.analysis.studies.accuracy_plan import accuracy_variants
from floeflow.analysis.studies.ensemble_plan import STUDY as ENSEMBLE
from floeflow.analysis.studies.ensemble_plan import ensemble_variants
from floeflow.analysis.studies.variants import Variant
from floeflow.scene import Scene

STUDIES: dict[str, Callable[[Scene], list[Variant]]] = {
    "ablation": ablation_variants,
    "accuracy": accuracy_variants,
    ENSEMBLE: ensemble_variants,
}


def study_variants(study: str, scene: Scene) -> dict[str, Variant]:
    """Runs of a study by name, ``base`` first.

    Parameters
    ----------
    study : str
        Name of the study.
    scene : Scene
        Its keys.

    Returns
    -------
    dict of Variant
        In the order of the runs.
    """
    return {variant.name: variant for variant in _variants(study, scene.model_dump_json())}


@lru_cache(maxsize=8)
def _variants(study: str, scene: str) -> tuple[Variant, ...]:
    """The runs, once for a scene: rules ask for them again and again."""
    return tuple(STUDIES[study](Scene.model_validate_json(scene)))
