# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``grid_zarr``: the gridded output as a Zarr store."""

from pathlib import Path

from floeflow.diagnostics.zarr_output import write_zarr
from floeflow.workflow.job import Snakemake, run_script


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    write_zarr(Path(str(snakemake.input.grid)), Path(str(snakemake.output.store)))


if __name__ == "__main__":
    run_script(main, snakemake)
