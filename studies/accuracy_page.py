# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``accuracy_page``: error against cost."""

import json
from dataclasses import asdict
from pathlib import Path

from floeflow.analysis.studies.accuracy_figure import accuracy_figure, is_felt
from floeflow.analysis.studies.accuracy_page import (
    LEAD,
    order_table,
    recommendation_table,
    recommendations,
    run_table,
)
from floeflow.analysis.studies.accuracy_table import analyse, as_dataset
from floeflow.analysis.studies.measures import KEPT, NORMS
from floeflow.diagnostics.diagnostics import write_json
from floeflow.report.study_page import Study, draw, write_study
from floeflow.state import read_dataset, write_dataset
from floeflow.workflow.job import Snakemake, run_script, scene_of


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    scene = scene_of(snakemake)
    records = [json.loads(Path(path).read_text()) for path in snakemake.input.records]
    study = analyse(scene, records, read_dataset(snakemake.input.mask))
    write_dataset(as_dataset(study, scene), snakemake.output.data)
    chosen = [
        {
            "wanted": target,
            "same_elements": same,
            "setting": setting and {**asdict(setting), "levels": dict(setting.levels)},
        }
        for target, same, setting in recommendations(study, scene)
    ]
    orders = [asdict(row) for row in study.orders]
    write_json(
        {"recommended": chosen, "orders": orders, "chaos": dict(study.chaos)},
        Path(str(snakemake.output.table)),
    )
    figures = Path(str(snakemake.output.figures))
    drawings = {
        norm: draw(
            figures,
            f"accuracy_{norm}",
            f"{NORMS[norm].label}: error over work.",
            accuracy_figure(study, norm),
        )
        for norm in NORMS
        if is_felt(study, norm)
    }
    said = [
        f"The default run's element model and column take {study.seconds:.3g} s of CPU time; "
        f"repeats differ by {100 * study.noise:.2g} %.",
        "A nudge of 1e-9 moves positions by "
        f"{100 * study.chaos['drift']:.2g} % of the drift: errors below that are chaos.",
    ]
    found = Study(
        f"Accuracy and cost of {scene.report.title or scene.name}",
        LEAD,
        said,
        [drawing for norm, drawing in drawings.items() if norm in KEPT],
        [recommendation_table(study, scene), order_table(study)],
        [drawing for norm, drawing in drawings.items() if norm not in KEPT],
        [run_table(study)],
    )
    out = snakemake.output
    write_study(found, Path(out.page), Path(out.digest), snakemake.params.study_keys)


if __name__ == "__main__":
    run_script(main, snakemake)
