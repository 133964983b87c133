# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``diagnostics``: series, budgets and their residuals."""

from pathlib import Path

from floeflow.diagnostics.diagnostics import RunFiles, diagnose, write_json
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
    )
    scene = scene_of(snakemake)
    data, numbers = diagnose(files, scene.effects, scene.domain)
    write_dataset(data, snakemake.output.dataset)
    write_json(numbers, Path(snakemake.output.headline))


if __name__ == "__main__":
    run_script(main, snakemake)
