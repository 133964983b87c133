# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``forcing``: forcing of one window on the scene's grid."""

from __future__ import annotations

from floeflow.forcings.forcing import make_forcing
from floeflow.state import write_dataset
from floeflow.workflow.job import Snakemake, run_script, scene_of


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    scene = scene_of(snakemake)
    window = int(snakemake.wildcards.window)
    write_dataset(make_forcing(scene, snakemake.input.source, window), snakemake.output.forcing)


if __name__ == "__main__":
    run_script(main, snakemake)
