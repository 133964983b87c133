# SPDX-License-Identifier: GPL-2.0-or-later
"""``python -m floeflow.analysis.studies.document``: pages of the example scenes' studies.

Reads what ``make studies`` left under ``results/``, writes docs/studies.md and docs/ensembles.md,
each where a study of its kind is there, and copies the figures to docs/images/studies.
"""

from __future__ import annotations

import json
import math
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

from floeflow.analysis.estimate.choose import scene_estimates
from floeflow.analysis.resolve import resolve_scene
from floeflow.analysis.studies import ablation_page, accuracy_page, ensemble_page
from floeflow.analysis.studies.ablation_figure import ablation_figure
from floeflow.analysis.studies.ablation_table import Ablation, ablation_table
from floeflow.analysis.studies.accuracy_figure import is_felt
from floeflow.analysis.studies.accuracy_table import Accuracy, analyse
from floeflow.analysis.studies.ensemble_figure import CAPTION, ensemble_figure
from floeflow.analysis.studies.ensemble_table import Ensemble, ensemble_table
from floeflow.analysis.studies.measures import KEPT
from floeflow.analysis.studies.variants import run_name
from floeflow.core.errors import FloeError, answer
from floeflow.core.records import machine
from floeflow.report.figures.style import write_png
from floeflow.report.study_page import DPI, Table, as_markdown, measured
from floeflow.scene import Scene
from floeflow.scene.docs import PROJECT
from floeflow.state import read_dataset

EXAMPLES = ("free_drift_day", "winter_pack", "summer_melt_month", "marginal_ice_zone")
# Scenes in which ice breaks, whose settings are compared by ensembles.
ENSEMBLES = ("arctic_week",)
PAGE, IMAGES = PROJECT / "docs/studies.md", PROJECT / "docs/images/studies"
ENSEMBLE_PAGE = PROJECT / "docs/ensembles.md"

HEAD = """# Studies of the example scenes

What each effect changes and costs, and what accuracy costs, in four small scenes. Made by
`make studies` on {machine}; how it is measured: [accuracy](accuracy.md).
"""

ENSEMBLE_HEAD = """# What settings cost where ice breaks

Where ice breaks, two runs that differ in the last bit end with other cracks: not positions but
statistics can be compared, of ensembles, with intervals. Made by `make studies` on {machine}; how
it is measured: [accuracy](accuracy.md#where-ice-breaks).
"""


def study_records(scene: Scene, study: str, results: Path) -> list[dict]:
    """Records of a study; empty where its page was never made.

    Parameters
    ----------
    scene : Scene
        Its keys.
    study : str
        Name of the study.
    results : Path
        Folder of results.

    Returns
    -------
    list of dict
        Of each run, by name.
    """
    if not (results / scene.name / f"{study}.html").is_file():
        return []
    runs = results.glob(f"{run_name(scene.name, study, '*')}/record.json")
    return [json.loads(path.read_text()) for path in sorted(runs)]


def effects_section(scene: Scene, study: Ablation) -> str:
    """Markdown of an ablation.

    Parameters
    ----------
    scene : Scene
        Its keys.
    study : Ablation
        What was measured.

    Returns
    -------
    str
        With a table and a figure.
    """
    lines = ["### Effects", ""]
    lines += [f"- {text}" for text in ablation_page.sentences(study, scene)]
    lines += ["", as_markdown(ablation_page.effect_table(study)), ""]
    lines += [f"![Influence and saving](images/studies/{scene.name}_ablation.png)", ""]
    return "\n".join(lines)


def accuracy_section(scene: Scene, study: Accuracy) -> str:
    """Markdown of an accuracy study.

    Parameters
    ----------
    scene : Scene
        Its keys.
    study : Accuracy
        What was measured.

    Returns
    -------
    str
        With tables and figures.
    """
    lines = ["### Accuracy against cost", ""]
    for table in (
        accuracy_page.recommendation_table(study, scene),
        accuracy_page.order_table(study),
    ):
        lines += [f"{table.title}:", "", as_markdown(table), "", table.note, ""]
    names = [f"accuracy_{norm}" for norm in KEPT if is_felt(study, norm)]
    lines += [f"![{name}](images/studies/{scene.name}_{name}.png)" for name in names]
    return "\n".join([*lines, ""])


def summary(studies: Sequence[tuple[Scene, Ablation]]) -> Table:
    """One line for each scene: ranks of the estimates, savings, chaos, work.

    Parameters
    ----------
    studies : sequence of tuple of Scene and Ablation
        Scenes with what was measured.
    """
    head: tuple[str, ...] = ("scene", "rank correlation", "lean run saves (%)")
    head += ("cost model said (%)", "lean run moves results by (%)", "chaos (%)")
    head += ("work of the scene (s)",)
    rows = [
        (
            scene.name,
            f"{found.rank:.2f}",
            measured(100 * found.lean_saving, 100 * found.noise),
            100 * found.lean_profile,
            100 * found.lean_share if math.isfinite(found.lean_share) else "failed",
            100 * found.floor,
            found.work_seconds,
        )
        for scene, found in studies
    ]
    return Table("All scenes", head, rows)


def ensemble_section(scene: Scene, study: Ensemble) -> str:
    """Markdown of an ensemble study.

    Parameters
    ----------
    scene : Scene
        Its keys.
    study : Ensemble
        What was measured.

    Returns
    -------
    str
        With tables and a figure.
    """
    lines = [f"## {scene.report.title or scene.name}", "", f"`config/scenes/{scene.name}.yaml`", ""]
    lines += [f"- {text}" for text in ensemble_page.sentences(study)]
    lines += ["", f"![{CAPTION}](images/studies/{scene.name}_ensemble.png)", "", CAPTION, ""]
    for table in (ensemble_page.setting_table(study), ensemble_page.change_table(study)):
        lines += [f"{table.title}:", "", as_markdown(table), "", table.note, ""]
    return "\n".join(lines)


def write_ensembles(results: Path) -> Path | None:
    """Write docs/ensembles.md and its figures; None where no scene has a finished ensemble.

    Parameters
    ----------
    results : Path
        Folder of results of all scenes.
    """
    sections = []
    for name in ENSEMBLES:
        scene = resolve_scene(PROJECT / f"config/scenes/{name}.yaml")
        if records := study_records(scene, "ensemble", results):
            study = ensemble_table(records)
            write_png(ensemble_figure(study), IMAGES / f"{name}_ensemble.png", DPI)
            sections.append(ensemble_section(scene, study))
            if records := study_records(scene, "ablation", results):
                effects = ablation_table(scene, records, scene_estimates(scene))
                write_png(ablation_figure(effects), IMAGES / f"{name}_ablation.png", DPI)
                sections.append(effects_section(scene, effects))
    if not sections:
        return None
    head = ENSEMBLE_HEAD.format(machine=machine())
    ENSEMBLE_PAGE.write_text("\n".join([head, *sections]))
    return ENSEMBLE_PAGE


def write_documents(results: Path = Path("results")) -> list[Path]:
    """Write the pages of the studies that are there, and their figures.

    Parameters
    ----------
    results : Path, optional
        Folder of results of all scenes.

    Raises
    ------
    FloeError
        Where no example scene has a finished study.
    """
    IMAGES.mkdir(parents=True, exist_ok=True)
    found = [page for page in (write_document(results), write_ensembles(results)) if page]
    if not found:
        raise FloeError(f"{results}: no example scene was studied; 'make studies' does it")
    return found


def write_document(results: Path) -> Path | None:
    """Write docs/studies.md and copy its figures; None where no scene has a finished study.

    Parameters
    ----------
    results : Path
        Folder of results of all scenes.
    """
    found: list[tuple[Scene, Ablation]] = []
    sections = []
    for name in EXAMPLES:
        scene = resolve_scene(PROJECT / f"config/scenes/{name}.yaml")
        parts = []
        if records := study_records(scene, "ablation", results):
            ablation = ablation_table(scene, records, scene_estimates(scene))
            found.append((scene, ablation))
            parts.append(effects_section(scene, ablation))
            # Drawn anew: the estimates may be those of a later fit.
            write_png(ablation_figure(ablation), IMAGES / f"{name}_ablation.png", DPI)
        if records := study_records(scene, "accuracy", results):
            accuracy = analyse(
                scene, records, read_dataset(results / scene.name / "preprocess/mask.nc")
            )
            parts.append(accuracy_section(scene, accuracy))
            for norm in (norm for norm in KEPT if is_felt(accuracy, norm)):
                source = results / name / f"accuracy/figures/accuracy_{norm}.png"
                shutil.copyfile(source, IMAGES / f"{name}_accuracy_{norm}.png")
        if parts:
            title = f"## {scene.report.title or scene.name}\n\n`config/scenes/{name}.yaml`\n"
            sections += [title, *parts]
    if not sections:
        return None
    head = HEAD.format(machine=machine())
    PAGE.write_text("\n".join([head, as_markdown(summary(found)), "", *sections]))
    return PAGE


if __name__ == "__main__":
    sys.exit(answer(write_documents))
