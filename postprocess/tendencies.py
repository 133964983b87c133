# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``tendencies``: by which process the ice on the grid grew, melted and moved."""

from pathlib import Path

from floeflow.diagnostics.cf_output import write_grid
from floeflow.diagnostics.gridded_tendencies import make_tendencies
from floeflow.state import read_dataset
from floeflow.state.snapshots import read_snapshots
from floeflow.workflow.job import Snakemake, run_script, scene_of


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    scene = scene_of(snakemake)
    mask = read_dataset(snakemake.input.mask)
    snapshots = read_snapshots(snakemake.input.elements)
    data = make_tendencies(scene, Path(str(snakemake.input.grid)), mask, snapshots)
    write_grid(data, Path(str(snakemake.output.tendencies)))


if __name__ == "__main__":
    run_script(main, snakemake)
