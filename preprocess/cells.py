# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``cells``: fresh cells over ice and water, for remapping."""

from floeflow.packings.fresh_cells import make_cells
from floeflow.state import read_dataset, write_dataset
from floeflow.workflow.job import Snakemake, run_script, scene_of


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    scene = scene_of(snakemake)
    mask, packing = read_dataset(snakemake.input.mask), read_dataset(snakemake.input.packing)
    write_dataset(make_cells(mask, packing, scene.seed), snakemake.output.cells)


if __name__ == "__main__":
    run_script(main, snakemake)
