# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``movie_files``: movies of thickness, drift, damage and deformation."""

import shutil
from pathlib import Path

from floeflow.diagnostics.collect import read_grid
from floeflow.report.figures.frame import Frame
from floeflow.report.movies import write_movies
from floeflow.state import read_dataset
from floeflow.workflow.job import Snakemake, run_script, scene_of


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    scene = scene_of(snakemake)
    frame = Frame(scene.domain, read_dataset(snakemake.input.mask)["land"])
    folder = Path(str(snakemake.output.movies))
    shutil.rmtree(folder, ignore_errors=True)
    grid = read_grid(Path(str(snakemake.input.grid)))
    title = scene.report.title or scene.name
    write_movies(grid, frame, title, scene.time.start, scene.time.window, folder)


if __name__ == "__main__":
    run_script(main, snakemake)
