# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``diagnostics``: series, budgets and their residuals, and analyses of the ice."""

from pathlib import Path

from floeflow.diagnostics.analyses import Analyses
from floeflow.diagnostics.diagnostics import RunFiles, analyse, diagnose, write_json
from floeflow.state import write_dataset
from floeflow.workflow.job import Snakemake, run_script, scene_of


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    given = snakemake.input
    files = RunFiles(
        first=Path(given.first),
        elements=[Path(path) for path in given.elements],
        series=[Path(path) for path in given.series],
        cost=[Path(path) for path in given.cost],
        grid=Path(str(given.grid)) if given.grid else None,
        last=Path(given.last),
    )
    scene = scene_of(snakemake)
    analyses = Analyses(scene)
    data, numbers = diagnose(files, scene.effects, scene.domain, analyses)
    write_dataset(data, snakemake.output.dataset)
    write_json(numbers, Path(snakemake.output.headline))
    write_dataset(analyse(files, analyses), snakemake.output.analyses)


if __name__ == "__main__":
    run_script(main, snakemake)
