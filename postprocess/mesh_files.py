# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``mesh_files``: the elements' cells at all window boundaries."""

from __future__ import annotations

import logging
from pathlib import Path

from floeflow.diagnostics.collect import window_file
from floeflow.diagnostics.mesh_series import write_meshes
from floeflow.state import read_dataset, read_state
from floeflow.workflow.job import Snakemake, run_script

log = logging.getLogger(__name__)


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    folder = Path(snakemake.input.states[0]).parent
    windows = (0, *(int(window) for window in snakemake.params.windows))
    paths = [Path(path) for path in snakemake.output.meshes]
    states = (read_state(window_file(folder, window, ".nc")) for window in windows)
    packing = read_dataset(snakemake.input.packing)
    write_meshes(packing, states, paths, Path(str(snakemake.output.series)))
    log.info("%d meshes of %d elements", len(paths), packing.sizes["element"])


if __name__ == "__main__":
    run_script(main, snakemake)
