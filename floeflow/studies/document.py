# SPDX-License-Identifier: GPL-2.0-or-later
"""``python -m floeflow.studies.document``: docs/studies.md from the studies of the example scenes.

Reads what ``make studies`` left under ``results/`` and copies the figures to docs/images/studies.
"""

from __future__ import annotations

import json
import math
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

from floeflow.bench import machine
from floeflow.config import Scene, load_scene
from floeflow.config.docs import PROJECT
from floeflow.errors import FloeError
from floeflow.estimate.choose import scene_estimates
from floeflow.studies import ablation_page, accuracy_page
from floeflow.studies.ablation_table import Ablation, ablation_table
from floeflow.studies.accuracy_table import Accuracy, analyse
from floeflow.studies.measures import KEPT
from floeflow.studies.page import Table, as_markdown

EXAMPLES = ("free_drift_day", "winter_pack", "summer_melt_month", "marginal_ice_zone")
PAGE, IMAGES = PROJECT / "docs/studies.md", PROJECT / "docs/images/studies"

HEAD = """# Studies of the example scenes

What each effect changes and costs, and what accuracy costs, in four small scenes. Made by
`make studies` on {machine}; how it is measured: [accuracy](accuracy.md).
"""


def study_records(scene: Scene, study: str, results: Path) -> list[dict]:
    """Records of a finished study.

    Raises
    ------
    FloeError
        Where there is none.
    """
    folder = results / scene.name / study
    found = [json.loads(path.read_text()) for path in sorted(folder.glob("*.json"))]
    found = [record for record in found if "variant" in record]
    if not found:
        raise FloeError(f"{folder}: there is no study here; 'make studies' runs it")
    return found


def scene_section(
    scene: Scene, ablation: Ablation, accuracy: Accuracy, images: Sequence[str]
) -> str:
    """Markdown of one scene."""
    lines = [f"## {scene.report.title or scene.name}", ""]
    lines += [f"`config/scenes/{scene.name}.yaml`.", "", "### Effects", ""]
    lines += [f"- {text}" for text in ablation_page.sentences(ablation, scene)]
    lines += ["", as_markdown(ablation_page.effect_table(ablation)), ""]
    lines += [f"![{name}](images/studies/{scene.name}_{name}.png)" for name in images[:1]]
    lines += ["", "### Accuracy against cost", ""]
    for table in (
        accuracy_page.recommendation_table(accuracy, scene),
        accuracy_page.order_table(accuracy),
    ):
        lines += [f"{table.title}:", "", as_markdown(table), "", table.note, ""]
    lines += [f"![{name}](images/studies/{scene.name}_{name}.png)" for name in images[1:]]
    return "\n".join(lines) + "\n"


def summary(studies: Sequence[tuple[Scene, Ablation, Accuracy]]) -> Table:
    """One line for each scene: ranks of the estimates, savings, chaos, work."""
    head: tuple[str, ...] = ("scene", "rank correlation", "lean run saves (%)")
    head += ("cost model said (%)", "lean run moves results by (%)", "chaos in positions (%)")
    head += ("work of default run (s)",)
    rows = [
        (
            scene.name,
            f"{ablation.rank:.2f}",
            100 * ablation.lean_saving,
            100 * ablation.lean_profile,
            100 * ablation.lean_share if math.isfinite(ablation.lean_share) else "failed",
            100 * accuracy.chaos["drift"],
            accuracy.seconds,
        )
        for scene, ablation, accuracy in studies
    ]
    return Table("All scenes", head, rows)


def write_document(results: Path = Path("results")) -> None:
    """Write docs/studies.md and copy its figures."""
    IMAGES.mkdir(parents=True, exist_ok=True)
    found, sections = [], []
    for name in EXAMPLES:
        scene = load_scene(PROJECT / f"config/scenes/{name}.yaml")
        ablation = ablation_table(
            scene, study_records(scene, "ablation", results), scene_estimates(scene)
        )
        accuracy = analyse(scene, study_records(scene, "accuracy", results), results)
        images = ["ablation", *(f"accuracy_{norm}" for norm in KEPT)]
        for image in images:
            study = image.partition("_")[0]
            source = results / name / study / "figures" / f"{image}.png"
            if not source.is_file():
                raise FloeError(f"{source}: the figure of a study is missing")
            shutil.copyfile(source, IMAGES / f"{name}_{image}.png")
        found.append((scene, ablation, accuracy))
        sections.append(scene_section(scene, ablation, accuracy, images))
    head = HEAD.format(machine=machine())
    PAGE.write_text("\n".join([head, as_markdown(summary(found)), "", *sections]))


def main() -> int:
    """Entry point."""
    try:
        write_document()
    except FloeError as error:
        print(f"floeflow: {error}", file=sys.stderr)
        return 1
    print(PAGE)
    return 0


if __name__ == "__main__":
    sys.exit(main())
