# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``bonds``: bonds between neighbours."""

from floeflow.packings.bonds import make_bonds
from floeflow.state import read_dataset, write_dataset
from floeflow.workflow.job import Snakemake, run_script, scene_of


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    scene = scene_of(snakemake)
    keys = scene.packing
    packing = read_dataset(snakemake.input.packing)
    bonds = make_bonds(packing, keys.bond_gap, keys.bond_concentration, keys.coast_bonds)
    write_dataset(bonds, snakemake.output.bonds)


if __name__ == "__main__":
    run_script(main, snakemake)
