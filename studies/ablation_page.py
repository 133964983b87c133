# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``ablation_page``: what each effect changes and saves."""

import json
from pathlib import Path

from floeflow.analysis.estimate.choose import scene_estimates
from floeflow.analysis.studies.ablation_figure import ablation_figure
from floeflow.analysis.studies.ablation_page import LEAD, effect_table, sentences
from floeflow.analysis.studies.ablation_table import ablation_table
from floeflow.diagnostics.diagnostics import write_json
from floeflow.report.study_page import Study, draw, write_study
from floeflow.workflow.job import Snakemake, run_script, scene_of


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    scene = scene_of(snakemake)
    records = [json.loads(Path(path).read_text()) for path in snakemake.input.records]
    study = ablation_table(scene, records, scene_estimates(scene))
    write_json(study.as_dict(), Path(str(snakemake.output.table)))
    caption = (
        "Influence of each effect (shaded: chaos alone; dashed: needed above) and CPU time saved "
        "without it."
    )
    figures = Path(str(snakemake.output.figures))
    drawings = [draw(figures, "ablation", caption, ablation_figure(study))]
    title = f"Ablation of {scene.report.title or scene.name}"
    said = Study(title, LEAD, sentences(study, scene), drawings, [effect_table(study)])
    out = snakemake.output
    write_study(said, Path(out.page), Path(out.digest), snakemake.params.study_keys)


if __name__ == "__main__":
    run_script(main, snakemake)
