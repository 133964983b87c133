# SPDX-License-Identifier: GPL-2.0-or-later
"""The studies by name, and the runs that each is made of."""

from __future__ import annotations

from collections.abc import Callable

from floeflow.config import Scene
from floeflow.studies.ablation_plan import ablation_variants
from floeflow.studies.accuracy_plan import accuracy_variants
from floeflow.studies.variants import Variant

STUDIES: dict[str, Callable[[Scene], list[Variant]]] = {
    "ablation": ablation_variants,
    "accuracy": accuracy_variants,
}


def study_variants(study: str, scene: Scene) -> dict[str, Variant]:
    """Runs of a study by name, ``base`` first."""
    return {variant.name: variant for variant in STUDIES[study](scene)}
