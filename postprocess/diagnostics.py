# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``diagnostics``: series, budgets and their residuals."""

from __future__ import annotations

from pathlib import Path

from floeflow.diagnostics.diagnostics import diagnose, write_json
from floeflow.state import write_dataset
from floeflow.workflow.job import Snakemake, run_script, scene_of


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    scene = scene_of(snakemake)
    folder = Path(snakemake.input.states[0]).parent.parent
    windows = [int(window) for window in snakemake.params.windows]
    grids = [Path(path) for path in snakemake.input.grids]
    data, numbers = diagnose(folder, windows, grids, scene.effects)
    write_dataset(data, snakemake.output.dataset)
    write_json(numbers, Path(snakemake.output.headline))


if __name__ == "__main__":
    run_script(main, snakemake)
