# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``report``: the report."""

import json
from pathlib import Path

from floeflow.core.atomic_write import write_text
from floeflow.diagnostics.collect import read_grid, read_tendencies
from floeflow.diagnostics.study_summaries import read_summary
from floeflow.forcings.inputs import described
from floeflow.report.report import Material, build_report, read_numbers
from floeflow.scene import Scene
from floeflow.state import read_dataset, read_state
from floeflow.workflow.job import Snakemake, run_script, scene_of


def _inputs(scene: Scene, mask: str) -> list[str]:
    """What was read of mask and forcing, one a line."""
    notes = str(read_dataset(mask).attrs.get("notes", "")).splitlines()
    return [*notes, *described(scene)]


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    scene = scene_of(snakemake)
    given = snakemake.input
    grid = read_grid(Path(str(given.grid))) if given.grid else None
    material = Material(
        diagnostics=read_dataset(given.diagnostics),
        numbers=read_numbers(Path(given.headline)),
        analyses=read_dataset(given.analyses),
        first_state=read_state(given.first_state),
        last_state=read_state(given.last_state),
        grid=grid,
        mask=read_dataset(given.mask),
        packing=read_dataset(given.packing),
        benchmarks=[Path(path) for path in given.benchmarks],
        estimates=json.loads(Path(given.estimates).read_text(encoding="utf-8")),
        inputs=_inputs(scene, given.mask),
        studies=[read_summary(Path(path)) for path in snakemake.params.studies],
        tendencies=read_tendencies(given.tendencies) if given.tendencies else None,
    )
    page = build_report(scene, material, Path(snakemake.output.figures))
    write_text(page, Path(snakemake.output.report))


if __name__ == "__main__":
    run_script(main, snakemake)
