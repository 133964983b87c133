# SPDX-License-Identifier: GPL-2.0-or-later
"""Speed of packings beside one `scipy.spatial.Delaunay` of the same points, in the same run.

Usage: python benchmarks/packing.py [--repeats 3] [--largest 1000000] [--out FILE]
A tessellation with 20 relaxations of a basin with coasts, islands and an ice edge; a dense pack of
two sizes in a periodic box. Times are processor seconds of one core: what else runs on the machine
counts little then. Peak memory is that of the process so far.
"""

from __future__ import annotations

import argparse
import resource
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import xarray as xr
from scipy.spatial import Delaunay

from floeflow.core.records import Record, write_records
from floeflow.coupling.compaction import Box, compact
from floeflow.packings.packing import make_packing
from floeflow.scene.blocks import Packing

CELLS, SPACING = 320, 25.0e3
DENSE = (10_000, 100_000)
FILL, TOLERANCE = 0.82, 5.0e-3


def basin() -> xr.Dataset:
    """Ice between a coast, islands and open water."""
    row, column = np.mgrid[:CELLS, :CELLS]
    land = column < 12 + 6 * np.sin(row / 9.0)
    for y, x, radius in ((200, 100, 20), (90, 180, 9), (60, 60, 14), (250, 220, 6)):
        land |= (row - y) ** 2 + (column - x) ** 2 < radius**2
    ice = np.where(land | (column > 290 + 8 * np.sin(row / 13.0)), 0.0, 0.9)
    axis = SPACING * (np.arange(CELLS) + 0.5)
    dims = ("y", "x")
    return xr.Dataset(
        {
            "siconc": (dims, ice),
            "sithick": (dims, 2.0 * ice),
            "land": (dims, land.astype(np.int8)),
            "cell_area": (dims, np.full(ice.shape, SPACING**2)),
        },
        coords={"x": axis, "y": axis.copy()},
        attrs={"crs": "EPSG:6931"},
    )


def seconds(work: Callable[[], object]) -> float:
    """Processor seconds of a call."""
    start = time.process_time()
    work()
    return time.process_time() - start


def peak() -> float:
    """Largest memory of the process so far, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def tessellation(elements: int, repeats: int) -> Record:
    """Time the tessellation in turn with its peer."""
    mask, keys = basin(), Packing(elements=elements, relaxations=20)
    made: list[xr.Dataset] = []
    own, peer = [], []
    for seed in range(repeats):
        own.append(seconds(lambda seed=seed: made.append(make_packing(mask, keys, seed))))
        packed = made.pop()
        mobile = packed["type"].values == 1
        points = np.stack([packed["x"].values, packed["y"].values], axis=1)[mobile]
        peer.append(seconds(lambda points=points: Delaunay(points)))
    extra = {"peak_memory_mb": peak(), "times_the_peer": float(np.median(np.divide(own, peer)))}
    return Record("tessellation", elements, 1, own, "scipy.spatial.Delaunay", peer, extra)


def dense(discs: int) -> Record:
    """Time the compaction of a periodic pack."""
    radius = np.where(np.arange(discs) % 2, 1.0, 1.4) * 1000.0
    side = float(np.sqrt(np.pi * (radius**2).sum() / FILL))
    places = np.random.default_rng(1).uniform(0, side, (discs, 2))
    box = Box(np.empty((0, 2)), np.empty(0), None, (0.0, 0.0, side, side))
    made = []
    with tempfile.TemporaryDirectory() as folder:
        own = seconds(lambda: made.append(compact(places, radius, box, TOLERANCE, Path(folder))))
    extra = {"peak_memory_mb": peak(), "overlap": made[0].overlap, "fill": FILL}
    return Record("dense pack", discs, 1, [own], extra=extra)


def main() -> None:
    """Run the cases and write their records."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--largest", type=int, default=1_000_000)
    parser.add_argument("--out", type=Path, default=Path("results/benchmarks/packing.json"))
    arguments = parser.parse_args()
    make_packing(basin(), Packing(elements=200), 1)  # compiles, or loads what is compiled
    records = []
    for elements in (10_000, 100_000, 1_000_000):
        if elements <= arguments.largest:
            records.append(tessellation(elements, arguments.repeats if elements < 1e6 else 1))
            _say(records[-1])
    for discs in DENSE:
        if discs <= arguments.largest:
            records.append(dense(discs))
            _say(records[-1])
    write_records(records, arguments.out)


def _say(record: Record) -> None:
    numbers = ", ".join(f"{name} {value:.3g}" for name, value in record.extra.items())
    print(f"{record.name}, {record.n}: {np.median(record.seconds):.3g} s, {numbers}", flush=True)


if __name__ == "__main__":
    main()
