# SPDX-License-Identifier: GPL-2.0-or-later
"""Page of the ablation study: what each effect changes and costs, measured beside estimated."""

import json
from pathlib import Path

from floeflow.analysis.estimate.choose import OUTPUT, scene_estimates
from floeflow.analysis.studies.ablation_figure import ablation_figure
from floeflow.analysis.studies.ablation_table import Ablation, ablation_table
from floeflow.diagnostics.diagnostics import write_json
from floeflow.report.study_page import Study, Table, draw, write_study
from floeflow.scene import Scene
from floeflow.workflow import job as stage

LEAD = (
    "Each effect of the scene was left out once, and the results compared with the run that has "
    "them all. Influence is the largest change of positions, ice volume and ice area, relative to "
    "what happens in the run; the estimate was made before any run."
)
HEAD = (
    *("effect", "positions (km)", "volume (m)", "area (%)"),
    *("influence (%)", "estimated (%)", "work saved (%)", "estimated (%)", "run saved (%)"),
    *("element-steps", "advice"),
)


def effect_table(study: Ablation) -> Table:
    """The effects, the most influential first."""
    rows = sorted(study.rows, key=lambda row: -row.share)
    cells = [
        (
            row.name,
            row.drift / 1e3,
            row.volume,
            100 * row.area,
            "failed" if row.fault else 100 * row.share,
            100 * row.estimated_share,
            100 * row.saving,
            100 * row.estimated_saving,
            100 * row.run_saving,
            row.element_steps,
            row.fault or row.advice,
        )
        for row in rows
    ]
    note = (
        "Work: CPU time of element model and column; run: all CPU time, programs' start included. "
        "Element-steps: without the effect, relative to the base run."
    )
    return Table("Effects, measured and estimated", HEAD, cells, note)


def sentences(study: Ablation, scene: Scene) -> list[str]:
    """What the study says, in words."""
    said = [
        f"Rank correlation of estimated and measured influence: {study.rank:.2f} "
        f"({sum(row.name not in OUTPUT for row in study.rows)} effects).",
        f"Chaos alone (a nudge of 1e-9) has an influence of {100 * study.floor:.2g} %; "
        f"the work of the same run differs by {100 * study.noise:.2g} %.",
        f"The base run took {study.cpu_seconds:.3g} s of CPU time, "
        f"{study.work_seconds:.3g} s of it work (element model and column).",
    ]
    if study.lean:
        gone = [name for name in scene.effects if name not in study.lean]
        said.append(
            f"Without what the estimate calls not needed ({', '.join(gone)}) the run saves "
            f"{100 * study.lean_saving:.3g} % of its work (the cost model says "
            f"{100 * study.lean_profile:.3g} %) and moves the results by "
            f"{100 * study.lean_share:.3g} %."
        )
    return said


def main(snakemake: stage.Snakemake) -> None:
    """Rule ``ablation_page``."""
    scene = stage.scene(snakemake)
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


if "snakemake" in globals():
    stage.run(main, globals()["snakemake"])
