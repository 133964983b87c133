# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``ensemble_page``: what settings cost and change, with intervals."""

import json
from dataclasses import asdict
from pathlib import Path

from floeflow.analysis.studies.ensemble_figure import CAPTION, ensemble_figure
from floeflow.analysis.studies.ensemble_page import (
    LEAD,
    SHARES,
    change_table,
    sentences,
    setting_table,
)
from floeflow.analysis.studies.ensemble_table import ensemble_table, wishes
from floeflow.diagnostics.diagnostics import write_json
from floeflow.report.study_page import Study, draw, write_study
from floeflow.workflow.job import Snakemake, run_script, scene_of


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    scene = scene_of(snakemake)
    records = [json.loads(Path(path).read_text()) for path in snakemake.input.records]
    study = ensemble_table(records)
    out = snakemake.output
    drawing = draw(Path(str(out.figures)), "ensemble", CAPTION, ensemble_figure(study))
    rows = [asdict(row) for row in study.rows]
    chosen = [
        {"share": wish.share, "setting": wish.row and wish.row.name, "members": wish.members}
        for wish in wishes(study, SHARES)
    ]
    data = {
        "settings": rows,
        "wishes": chosen,
        "floor": study.floor,
        "seconds": asdict(study.seconds),
        "means": dict(study.means),
        "parting": dict(study.parting),
    }
    write_json(data, Path(str(out.table)))
    page = Study(
        f"What settings cost and change in {scene.report.title or scene.name}",
        LEAD,
        sentences(study),
        [drawing],
        [setting_table(study)],
        [],
        [change_table(study)],
    )
    write_study(page, Path(out.page), Path(out.digest), snakemake.params.study_keys)


if __name__ == "__main__":
    run_script(main, snakemake)
