# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``land``: share of land in each cell of the mask grid, from the 1 km land mask."""

from floeflow.masks.land import make_land
from floeflow.state import write_dataset
from floeflow.workflow.job import Snakemake, run_script, scene_of


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    scene = scene_of(snakemake)
    write_dataset(make_land(scene), snakemake.output.land)


if __name__ == "__main__":
    run_script(main, snakemake)
