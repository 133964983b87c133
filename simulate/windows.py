# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``windows``: a chunk of coupling windows, dynamics and column in one MPI launch."""

import os
from pathlib import Path

from floeflow.coupling.chunk import Chunk, run_chunk
from floeflow.coupling.launch import warn_of_step
from floeflow.workflow.job import Snakemake, launcher_of, run_script, scene_folder, scene_of
from floeflow.workflow.library import check_made_with


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    scene = scene_of(snakemake)
    check_made_with(Path(snakemake.input.plugin), snakemake.params.made_with)
    warn_of_step(scene)
    # The ranks inherit it.
    os.environ["FLOEFLOW_PLUGIN"] = str(Path(snakemake.input.plugin).resolve())
    launcher, ranks = launcher_of(snakemake)
    chunk = Chunk(
        scene=scene,
        folder=scene_folder(snakemake),
        windows=tuple(snakemake.params.windows),
        state=Path(snakemake.input.state),
        plugin=Path(snakemake.input.plugin),
        ranks=ranks,
        launcher=launcher,
        cells=Path(str(snakemake.input.cells)) if snakemake.input.cells else None,
        library=snakemake.params.library,
        mask=Path(str(snakemake.input.mask)) if snakemake.input.mask else None,
    )
    run_chunk(chunk)


if __name__ == "__main__":
    run_script(main, snakemake)
