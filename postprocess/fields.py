# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``fields``: the elements of a chunk on the scene's grid, at all window boundaries."""

import logging
from pathlib import Path

from floeflow.diagnostics.cf_output import join_times, write_grid
from floeflow.diagnostics.gridded import make_grid
from floeflow.diagnostics.surface_forces import forcing_at
from floeflow.state import read_dataset, read_state
from floeflow.state.snapshots import read_snapshots
from floeflow.transfer.bins import Room
from floeflow.workflow.job import Snakemake, run_script, scene_of

log = logging.getLogger(__name__)


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    scene = scene_of(snakemake)
    mask = read_dataset(snakemake.input.mask)
    # The first chunk brings the start with it.
    start = [read_state(path) for path in snakemake.input.start]
    states = [*start, *read_snapshots([snakemake.input.elements])]
    rooms: dict[int, Room] = {}
    made = (
        make_grid(scene, state, mask, forcing_at(scene, float(state.attrs["time"])), rooms)
        for state in states
    )
    data = join_times(list(made))
    write_grid(data, Path(str(snakemake.output.fields)))
    for name, unit, size in (("siarea", "km2", 1e6), ("sivolume", "km3", 1e9)):
        left = float(abs(data[f"{name}_residual"]).max()) / size
        gone = float(data[f"{name}_outside"].max()) / size
        log.info(
            "%s: grid minus elements %.3g %s at most, off the grid %.4g %s at most",
            *(name, left, unit, gone, unit),
        )


if __name__ == "__main__":
    run_script(main, snakemake)
