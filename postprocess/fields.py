# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``fields``: the elements of a chunk on the scene's grid, at all window boundaries."""

from pathlib import Path

from floeflow.diagnostics.cf_output import join_times, write_grid
from floeflow.diagnostics.gridded import make_grid
from floeflow.state import read_dataset, read_state
from floeflow.state.snapshots import read_snapshots
from floeflow.workflow.job import Snakemake, run_script, scene_of


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    scene = scene_of(snakemake)
    mask = read_dataset(snakemake.input.mask)
    # The first chunk brings the start with it.
    start = [read_state(path) for path in snakemake.input.start]
    states = [*start, *read_snapshots([snakemake.input.elements])]
    data = join_times([make_grid(scene, state, mask) for state in states])
    write_grid(data, Path(str(snakemake.output.fields)))


if __name__ == "__main__":
    run_script(main, snakemake)
