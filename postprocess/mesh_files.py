# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``mesh_files``: the elements' cells at all window boundaries."""

import logging
from itertools import chain
from pathlib import Path

from floeflow.diagnostics.mesh_series import write_meshes
from floeflow.state import read_dataset, read_state
from floeflow.state.snapshots import read_snapshots
from floeflow.workflow.job import Snakemake, run_script


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    states = chain([read_state(snakemake.input.first)], read_snapshots(snakemake.input.elements))
    packing = read_dataset(snakemake.input.packing)
    made = write_meshes(packing, states, Path(str(snakemake.output.meshes)))
    logging.info("%d meshes", len(made))


if __name__ == "__main__":
    run_script(main, snakemake)
