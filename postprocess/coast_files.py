# SPDX-License-Identifier: GPL-2.0-or-later
"""Rule ``coast_files``: the land as a wall mesh, for LIGGGHTS and ParaView."""

from pathlib import Path

from floeflow.packings.coast_mesh import coast_segments, land_polygons, write_coast_mesh
from floeflow.packings.elements import grid_of
from floeflow.state import read_dataset
from floeflow.state.schema import MOBILE
from floeflow.workflow.job import Snakemake, run_script


def main(snakemake: Snakemake) -> None:
    """Run the rule."""
    mask, packing = read_dataset(snakemake.input.mask), read_dataset(snakemake.input.packing)
    radius = packing["radius"].values[packing["type"].values == MOBILE]
    mean = float(radius.mean()) if len(radius) else grid_of(mask).spacing
    polygons = land_polygons(grid_of(mask), mask["land"].values > 0)
    segments = coast_segments(polygons, mean)
    for path in (snakemake.output.wall, snakemake.output.view):
        write_coast_mesh(segments, 2.0 * mean, Path(str(path)))


if __name__ == "__main__":
    run_script(main, snakemake)
