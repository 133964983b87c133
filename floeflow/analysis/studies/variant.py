# SPDX-License-Identifier: GPL-2.0-or-later
"""One run of a study: the scene with some keys changed, run, and compared with the base run."""

import logging
import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

from floeflow.analysis.resolve import resolve_scene
from floeflow.analysis.studies.compare import differences, mean_drift, read_ends, scales, totals
from floeflow.analysis.studies.nested import Outcome, read_outcome, run_scene
from floeflow.analysis.studies.share import link_shared
from floeflow.analysis.studies.variants import BASE, Variant, variant_keys, write_variant
from floeflow.core.errors import FloeError
from floeflow.scene import Scene

# Ice does not drift faster: such a run is unstable though it ended.
FASTEST = 5.0  # m/s


def results_of(base: Scene, variant: Scene, outcome: Outcome) -> dict[str, Any]:
    """Headline results of a run, and how far they lie from the base run's; empty where it failed.

    A run whose results are not finite, or whose ice is faster than any, failed too.
    """
    if outcome.fault:
        return {}
    ends = read_ends(Path("results") / variant.name)
    reference = read_ends(Path("results") / base.name)
    found: dict[str, Any] = {
        "scales": dict(scales(reference)),
        "differences": differences(reference, ends),
        "drift": mean_drift(ends),
        **totals(ends.last),
    }
    speed = float(abs(ends.last["u"].values).max(initial=0.0))
    if speed > FASTEST or not all(math.isfinite(v) for v in found["differences"].values()):
        outcome.fault = f"unstable: the ice moves at {speed:.3g} m/s"
        return {}
    return found


def run_variant(path: Path, scene: Scene, study: str, variant: Variant) -> dict[str, Any]:
    """Run a variant of a scene file and return its record, in JSON types.

    The base run of the study must be there, unless this is it.
    """
    folder = Path("results") / scene.name / study
    file = folder / "scenes" / f"{variant.name}.yaml"
    own = write_variant(variant_keys(path, scene, study, variant), file)
    base = own if variant.name == BASE else resolve_scene(folder / "scenes" / f"{BASE}.yaml")
    if variant.name != BASE:
        logging.info("%d files are the base run's", link_shared(base, own))
    fault = run_scene(file, own, folder / "log" / f"{variant.name}.workflow.log")
    if fault and variant.name == BASE:
        raise FloeError(f"the scene itself does not run: {fault}")
    outcome = read_outcome(own, fault)
    found = results_of(base, own, outcome)
    return {
        "variant": variant.name,
        "group": variant.group,
        "label": variant.label,
        "changes": variant.changes,
        "effects": list(own.effects),
        **asdict(outcome),
        "cpu_seconds": outcome.cpu_seconds,
        "results": found,
    }
