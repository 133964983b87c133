# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``initial``: state 0: elements, bonds and columns at the start."""

from floeflow.coupling.initial import make_state
from floeflow.state import read_dataset, write_state
from floeflow.workflow.job import Snakemake, run_script, scene_of


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    scene = scene_of(snakemake)
    packing = read_dataset(snakemake.input.packing)
    bonds = read_dataset(snakemake.input.bonds) if "bonds" in scene.effects else None
    mask = read_dataset(snakemake.input.mask) if "mixed_layer" in scene.effects else None
    state = make_state(scene, packing, bonds, mask)
    write_state(state, snakemake.output.state, scene.state.precision)


if __name__ == "__main__":
    run_script(main, snakemake)
