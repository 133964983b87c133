# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``mesh_files``: cells, discs and grid at all boundaries, bonds at the ends of jobs."""

import logging
from itertools import chain
from pathlib import Path

from floeflow.diagnostics.collect import read_grid
from floeflow.diagnostics.mesh_series import write_bonds, write_discs, write_grids, write_meshes
from floeflow.state import read_dataset, read_state
from floeflow.state.snapshots import read_snapshots
from floeflow.workflow.job import Snakemake, run_script


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    given = snakemake.input
    first = read_state(given.first)
    packing = read_dataset(given.packing)
    folder = Path(str(snakemake.output.meshes))
    made = write_meshes(packing, chain([first], read_snapshots(given.elements)), folder)
    write_discs(chain([first], read_snapshots(given.elements)), folder)
    # Only whole states have bonds: the first, and those at the ends of jobs.
    held = write_bonds((read_state(path) for path in [given.first, *given.states]), folder)
    grids = write_grids(read_grid(Path(str(given.grid))), folder) if given.grid else []
    logging.info(
        "%d meshes of the elements and their discs, %d of the bonds, %d of the grid",
        len(made),
        len(held),
        len(grids),
    )


if __name__ == "__main__":
    run_script(main, snakemake)
