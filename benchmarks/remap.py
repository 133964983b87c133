# SPDX-License-Identifier: GPL-2.0-or-later
"""Speed of the transfers: building weights and applying them, beside bincount and griddata.

Usage: python benchmarks/remap.py [--repeats 7] [--largest 1000000] [--out FILE]
Elements lie at random about a lattice, four to a cell, in random order. The peers run in turn with
it: one `numpy.bincount` over the same contributions, which is what the memory allows a gather, and
`scipy.interpolate.griddata(linear)`. Each case is a function that returns records, listed in CASES.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.interpolate import griddata

from floeflow.core.records import Record, write_records
from floeflow.transfer import (
    ROOM,
    Field,
    Grid,
    Weights,
    build_remapper,
    build_sampler,
    build_weights,
    conservative_transfer,
    nearest_bounded,
    open_room,
)
from floeflow.transfer.stencil import Array

PER_CELL = 4
# Above this many elements the slow peer runs once.
PATIENCE = 100_000
FIELDS = (
    Field("area", "extensive", ROOM),
    Field("ice", "extensive", "area"),
    Field("volume", "extensive", "ice"),
)


def pack(count: int, seed: int = 0) -> tuple[Array, Array, Grid]:
    """Elements in the unit square, about four to a cell, in random order, and the grid."""
    rng = np.random.default_rng(seed)
    cells = max(2, round(np.sqrt(count / PER_CELL)))
    n = 2 * cells
    lattice = (np.arange(n) + 0.5) / n
    x, y = (axis.ravel() for axis in np.meshgrid(lattice, lattice))
    x, y = (axis + rng.uniform(-0.25, 0.25, n * n) / n for axis in (x, y))
    order = rng.permutation(n * n)
    centres = (np.arange(cells) + 0.5) / cells
    return x[order], y[order], Grid(centres, centres)


def timed(work: Callable[[], object]) -> tuple[float, float]:
    """Wall and processor seconds of a call."""
    start = time.perf_counter(), time.thread_time()
    work()
    return time.perf_counter() - start[0], time.thread_time() - start[1]


def beside(
    name: str,
    count: int,
    repeats: int,
    work: Callable[[], object],
    peer: str = "",
    other: Callable[[], object] | None = None,
    **extra: float,
) -> Record:
    """Time a call, in turn with its peer if it has one."""
    own, peers = [], []
    for _ in range(repeats):
        own.append(timed(work))
        if other is not None:
            peers.append(timed(other))
    wall, cpu = zip(*own, strict=True)
    more = {"cpu_seconds": min(cpu), **extra}
    if peers:
        more["peer_cpu_seconds"] = min(cpu for _, cpu in peers)
    return Record(f"remap/{name}", count, 1, list(wall), peer, [w for w, _ in peers], more)


def _memory(weights: Weights, x: Array, y: Array) -> dict[str, float]:
    """Bytes per element of the weights, and of them with the pairs that building needs."""
    matrix, pairs = weights.matrix, weights.target.pairs(x, y)
    parts = [matrix.data, matrix.indices, matrix.indptr, weights.status, weights.condition]
    kept = sum(part.nbytes for part in parts) / len(x)
    columns = (pairs.start, pairs.element, pairs.hat, pairs.xi, pairs.eta)
    whole = kept + sum(column.nbytes for column in columns) / len(x)
    return {"bytes_per_element": kept, "build_bytes_per_element": whole}


def elements_to_grid(count: int, repeats: int) -> list[Record]:
    """Build, apply and both, beside a bincount and griddata."""
    x, y, grid = pack(count)
    area, field = np.ones_like(x), np.sin(3.0 * x) * y
    weights = build_weights(x, y, area, grid)
    matrix, nodes = weights.matrix, weights.status.size
    node = np.repeat(np.arange(nodes), np.diff(matrix.indptr))
    shares = matrix.data * field[matrix.indices]
    extra = {"per_cell": PER_CELL, **_memory(weights, x, y)}
    places = np.stack([x, y], axis=1), np.stack(grid.places(), axis=1)

    def build() -> Weights:
        return build_weights(x, y, area, grid)

    return [
        beside("build", len(x), repeats, build, **extra),
        beside(
            *("apply", len(x), max(repeats, 5), lambda: weights.apply(field)),
            *("numpy.bincount", lambda: np.bincount(node, shares, nodes)),
            **extra,
        ),
        beside(
            *("build_apply", len(x), repeats if count <= PATIENCE else 1),
            *(lambda: build().apply(field), "scipy griddata(linear)"),
            lambda: griddata(places[0], field, places[1], method="linear"),
            **extra,
        ),
    ]


def hierarchy(count: int, repeats: int) -> list[Record]:
    """Three levels of fields, corrected to exact totals within bounds; weights are built."""
    x, y, grid = pack(count)
    rng = np.random.default_rng(1)
    area = np.full(len(x), 1.0 / len(x))
    ice = area * rng.uniform(0.0, 1.0, len(x))
    values = {"area": area, "ice": ice, "volume": ice * (1.0 + x)}
    parents = {name: values[name] for name in ("area", "ice")}
    remapper = build_remapper(x, y, parents, open_room(grid))
    return [
        beside(
            *("carry", len(x), repeats, lambda: conservative_transfer(FIELDS, values, remapper)),
            fields=len(FIELDS),
        )
    ]


def correction(count: int, repeats: int) -> list[Record]:
    """The bounded correction alone, beside a sort of as many numbers."""
    rng = np.random.default_rng(2)
    target = rng.normal(size=count)
    low = target + rng.normal(-0.3, 0.5, count)
    high = low + rng.uniform(0.0, 2.0, count)
    weight = rng.uniform(0.1, 2.0, count)
    total = float(weight @ (0.4 * low + 0.6 * high))
    return [
        beside(
            *("bounded", count, repeats),
            lambda: nearest_bounded(target, low, high, weight, total),
            *("numpy.sort", lambda: np.sort(target)),
        )
    ]


def grid_to_elements(count: int, repeats: int) -> list[Record]:
    """Sampling at the centres and giving back."""
    x, y, grid = pack(count)
    field = np.add.outer(grid.y, np.sin(grid.x))
    sampler, force = build_sampler(x, y, grid), np.cos(x)
    return [
        beside("sampler_build", len(x), repeats, lambda: build_sampler(x, y, grid)),
        beside("sample", len(x), repeats, lambda: sampler.at(field)),
        beside("give_back", len(x), repeats, lambda: sampler.give_back(force)),
    ]


# Cases of the benchmark: each takes a number of elements and of repeats, and returns records.
CASES: list[Callable[[int, int], list[Record]]] = [
    elements_to_grid,
    hierarchy,
    correction,
    grid_to_elements,
]


def growth(records: list[Record]) -> list[str]:
    """How the processor time of each case grows from its smallest to its largest size."""
    lines = []
    for name in dict.fromkeys(record.name for record in records):
        same = sorted((r for r in records if r.name == name), key=lambda r: r.n)
        a, b = same[0], same[-1]
        if b.n > a.n:
            linear = b.n * np.log(b.n) / (a.n * np.log(a.n))
            keys = [k for k in ("cpu_seconds", "peer_cpu_seconds") if k in a.extra]
            own, *peer = (b.extra[key] / a.extra[key] for key in keys)
            besides = f", {b.peer}: {peer[0]:.0f} x" if peer else ""
            lines.append(
                f"{name}: {b.n / a.n:.0f} x the elements, {own:.0f} x the time "
                f"(N log N: {linear:.0f} x{besides})"
            )
    return lines


def main() -> None:
    """Time all cases and write them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--largest", type=int, default=1_000_000, help="elements")
    parser.add_argument("--out", type=Path, default=Path("results/benchmarks/remap.json"))
    options = parser.parse_args()
    for case in CASES:
        case(1000, 1)  # compiled beforehand
    sizes = [n for n in (10_000, 100_000, 1_000_000) if n <= options.largest] or [options.largest]
    records = [r for n in sizes for case in CASES for r in case(n, options.repeats)]
    write_records(records, options.out)
    for record in records:
        ratio = record.ratio_median
        peer = f", {ratio:6.2f} x the speed of {record.peer}" if ratio is not None else ""
        print(f"{record.name:20s} {record.n:8d}: {min(record.seconds):.5f} s{peer}")
    print("\n".join(growth(records)))


if __name__ == "__main__":
    main()
