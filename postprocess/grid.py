# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``grid``: one state on the scene's grid."""

from __future__ import annotations

import logging
from pathlib import Path

from floeflow.diagnostics.cf_output import write_grid
from floeflow.diagnostics.gridded import make_grid
from floeflow.state import read_dataset, read_state
from floeflow.workflow.job import Snakemake, run_script, scene_of

log = logging.getLogger(__name__)


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    scene = scene_of(snakemake)
    state = read_state(snakemake.input.state)
    data = make_grid(scene, state, read_dataset(snakemake.input.mask))
    write_grid(data, Path(str(snakemake.output.grid)))
    for name, unit, size in (("siarea", "km2", 1e6), ("sivolume", "km3", 1e9)):
        left, gone = (float(data[f"{name}_{what}"][0]) / size for what in ("residual", "outside"))
        log.info(
            "%s: grid minus elements %.3g %s, off the grid %.4g %s", name, left, unit, gone, unit
        )


if __name__ == "__main__":
    run_script(main, snakemake)
