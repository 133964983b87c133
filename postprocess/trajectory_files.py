# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``trajectory_files``: the elements through all states, and their drift."""

from __future__ import annotations

import logging
from pathlib import Path

from floeflow.diagnostics.collect import window_file
from floeflow.diagnostics.trajectory import drift_statistics, make_frames, write_dump
from floeflow.state import read_state, write_dataset
from floeflow.workflow.job import Snakemake, run_script, scene_of

log = logging.getLogger(__name__)


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    domain = scene_of(snakemake).domain
    folder = Path(snakemake.input.states[0]).parent
    windows = (0, *(int(window) for window in snakemake.params.windows))
    frames = make_frames(read_state(window_file(folder, window, ".nc")) for window in windows)
    write_dump(frames, domain, Path(str(snakemake.output.trajectory)))
    statistics = drift_statistics(frames)
    write_dataset(statistics, snakemake.output.drift)
    gone = statistics["drift_distance"].values[-1]
    log.info(
        "%d elements in %d frames; the mobile ones went %.4g km on average, %.4g km at most",
        *(frames.sizes["element"], len(windows), gone.mean() / 1e3, gone.max() / 1e3),
    )


if __name__ == "__main__":
    run_script(main, snakemake)
