# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``packing``: elements over the ice: their discs and cells, or floes."""

from pathlib import Path

from floeflow.coupling.compaction import compactor
from floeflow.packings.elements import grid_of
from floeflow.packings.packing import make_packing
from floeflow.state import read_dataset, write_dataset
from floeflow.state.scene_walls import scene_walls
from floeflow.workflow.job import Snakemake, run_script, scene_of


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    scene = scene_of(snakemake)
    mask = read_dataset(snakemake.input.mask)
    walls = scene_walls(scene)
    scratch = Path(str(snakemake.log[0])).parent
    compact = compactor(grid_of(mask), scratch, walls, scene.period)
    made = make_packing(mask, scene.packing, scene.seed, "coast" in scene.effects, compact, walls)
    write_dataset(made, snakemake.output.packing)


if __name__ == "__main__":
    run_script(main, snakemake)
