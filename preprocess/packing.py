# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``packing``: elements over the ice: their cells and discs."""

from floeflow.packings.packing import make_packing
from floeflow.state import read_dataset, write_dataset
from floeflow.workflow.job import Snakemake, run_script, scene_of


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    scene = scene_of(snakemake)
    mask = read_dataset(snakemake.input.mask)
    made = make_packing(mask, scene.packing, scene.seed, "coast" in scene.effects)
    write_dataset(made, snakemake.output.packing)


if __name__ == "__main__":
    run_script(main, snakemake)
