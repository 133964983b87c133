# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``trajectory_files``: the elements through all window boundaries, and their drift."""

import logging
from itertools import chain
from pathlib import Path

from floeflow.diagnostics.trajectory import drift_statistics, make_frames, write_dump, write_xtc
from floeflow.state import read_state, write_dataset
from floeflow.state.snapshots import read_snapshots
from floeflow.workflow.job import Snakemake, run_script, scene_of


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    first = read_state(snakemake.input.first)
    frames = make_frames(chain([first], read_snapshots(snakemake.input.elements)))
    write_dump(frames, scene_of(snakemake).domain, Path(str(snakemake.output.trajectory)))
    write_xtc(frames, scene_of(snakemake).domain, Path(str(snakemake.output.places)))
    statistics = drift_statistics(frames)
    write_dataset(statistics, snakemake.output.drift)
    gone = statistics["drift_distance"].values[-1]
    logging.info(
        "%d elements in %d frames; the mobile ones went %.4g km on average, %.4g km at most",
        *(frames.sizes["element"], frames.sizes["time"], gone.mean() / 1e3, gone.max() / 1e3),
    )


if __name__ == "__main__":
    run_script(main, snakemake)
