# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``stability_page``: what the hard cases showed."""

import json
import logging
from pathlib import Path

from floeflow.analysis.studies.stability_figure import residual_figure, stability_map
from floeflow.analysis.studies.stability_page import LEAD, case_table, residuals, sentences, summary
from floeflow.core.atomic_write import write_text
from floeflow.report.study_page import Study, as_markdown, draw, write_study
from floeflow.workflow.job import Snakemake, run_script


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    shown = json.loads(Path(str(snakemake.input.records)).read_text())
    folder = Path(str(snakemake.output.figures))
    caption = "Energy that no term of the budget accounts for; dashed: what may be missed."
    drawings = [draw(folder, "residuals", caption, residual_figure(residuals(shown)))]
    for entry in shown:
        if found := entry["figures"].get("map"):
            figure = stability_map(found["panels"], found["dampings"], found["default"])
            caption = (
                "Largest time step at which no energy grows, over the critical one, of packs that "
                "bonds hold together and of packs of contacts pressed into a frame."
            )
            drawings.append(draw(folder, "stability_map", caption, figure))
    table = case_table(shown)
    out = snakemake.output
    study = Study("Hard cases", LEAD, sentences(shown), drawings, [summary(shown)], (), [table])
    write_study(study, Path(out.page), Path(out.digest), keys="")
    write_text(as_markdown(table) + "\n", Path(out.table))
    for entry in shown:
        if entry["outcome"] == "failed":
            logging.error("%s: %s failed", entry["module"], entry["test"])


if __name__ == "__main__":
    run_script(main, snakemake)
