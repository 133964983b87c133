# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``mesh_files``: the elements' cells at all window boundaries, bonds at the ends of jobs."""

import logging
from itertools import chain
from pathlib import Path

from floeflow.diagnostics.mesh_series import write_bonds, write_meshes
from floeflow.state import read_dataset, read_state
from floeflow.state.snapshots import read_snapshots
from floeflow.workflow.job import Snakemake, run_script


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    states = chain([read_state(snakemake.input.first)], read_snapshots(snakemake.input.elements))
    packing = read_dataset(snakemake.input.packing)
    folder = Path(str(snakemake.output.meshes))
    made = write_meshes(packing, states, folder)
    # Only whole states have bonds: the first, and those at the ends of jobs.
    whole = (read_state(path) for path in [snakemake.input.first, *snakemake.input.states])
    held = write_bonds(whole, folder)
    logging.info("%d meshes of the elements, %d of the bonds", len(made), len(held))


if __name__ == "__main__":
    run_script(main, snakemake)
