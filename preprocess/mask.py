# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``mask``: ice concentration and thickness on the mask grid, from the ice mask."""

from floeflow.coupling.sea.reading import with_sea
from floeflow.masks.mask import make_mask
from floeflow.state import read_dataset, write_dataset
from floeflow.workflow.job import Snakemake, run_script, scene_of


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    scene = scene_of(snakemake)
    land = None
    if scene.mask.land == "global_land_mask":
        # All or nothing: straits are open, inland seas are land.
        land = read_dataset(snakemake.input.land)["land"].values.astype(float)
    mask = make_mask(scene, land)
    if "mixed_layer" in scene.effects:
        mask = with_sea(scene, mask)
    write_dataset(mask, snakemake.output.mask)


if __name__ == "__main__":
    run_script(main, snakemake)
