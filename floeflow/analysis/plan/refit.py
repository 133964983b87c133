# SPDX-License-Identifier: GPL-2.0-or-later
"""Fit the cost and the error model anew to studies that lie under ``results/``."""

from __future__ import annotations

import json
from pathlib import Path

from floeflow.analysis.plan.fit_costs import (
    base_scene,
    fit_costs,
    fit_whole_runs,
    read_runs,
    read_whole_runs,
)
from floeflow.analysis.plan.fit_errors import fit_choices, fit_laws, read_studies
from floeflow.core.errors import FloeError
from floeflow.core.records import machine
from floeflow.scene.docs import PROJECT


def held_out() -> set[str]:
    """Scenes that only test the models."""
    return {path.stem for path in (PROJECT / "benchmarks/held_out").glob("*.yaml")}


def refit(results: Path, costs: Path, precision: Path) -> list[str]:
    """Fit both models to all studies under a results folder and write them.

    Parameters
    ----------
    results : Path
        Folder of results.
    costs : Path
        JSON file of the cost model, replaced.
    precision : Path
        JSON file of the error model, replaced.

    Returns
    -------
    list of str
        The studies, as ``<scene>/<study>``.

    Raises
    ------
    FloeError
        Where there is no study.
    """
    pages = [page.parent for page in sorted(results.glob("*/*/digest.json"))]
    studies = [folder for folder in pages if base_scene(folder).is_file()]
    folders = [folder for folder in studies if folder.parent.name not in held_out()]
    if not folders:
        raise FloeError(f"{results}: there is no study to fit to; run 'ablation' and 'accuracy'")
    names = [folder.relative_to(results).as_posix() for folder in folders]
    old = json.loads(costs.read_text())["seconds"]
    whole = [page.parent for page in results.glob("*/report.html")]
    whole = [folder for folder in sorted(whole) if folder.name not in held_out()]
    fitted = fit_costs([*read_runs(folders), *read_whole_runs(whole)], old)
    fitted |= fit_whole_runs(whole, fitted["job"])
    made = read_studies(folders)
    errors = {"errors": fit_laws(made), "choices": fit_choices(made)}
    head = {"machine": machine(), "fitted_from": names}
    costs.write_text(json.dumps({**head, "seconds": fitted}, indent=1) + "\n")
    precision.write_text(json.dumps({**head, **errors}, indent=1) + "\n")
    return names
