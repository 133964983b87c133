# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``analytic``: cyclone, gyre and weather of one window."""

from __future__ import annotations

from pathlib import Path

from floeflow.forcings.analytic import make_analytic, write_cf
from floeflow.workflow.job import Snakemake, run_script, scene_of


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    scene = scene_of(snakemake)
    write_cf(make_analytic(scene, int(snakemake.wildcards.window)), Path(snakemake.output.forcing))


if __name__ == "__main__":
    run_script(main, snakemake)
