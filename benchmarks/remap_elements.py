# SPDX-License-Identifier: GPL-2.0-or-later
"""Speed of the transfer from elements to fresh elements, beside shapely's own intersection.

Usage: python benchmarks/remap_elements.py [--repeats 3] [--sizes 10000 100000] [--out FILE]
A whole remap of a state (five categories with snow and temperatures, bonds) is timed in turn with
`shapely.intersection` and `shapely.area` over the same pairs of polygons.
"""

from __future__ import annotations

import argparse
import resource
import time
from pathlib import Path

import numpy as np
import shapely
import xarray as xr

from floeflow.core.grids import Grid
from floeflow.core.records import Record, write_records
from floeflow.dynamics.remesh.overlap import carried_polygons
from floeflow.dynamics.remesh.remap import lay, outlines, remap
from floeflow.packings.tessellation import power_diagram
from floeflow.state.bonds import new_bonds
from floeflow.state.cells import Cells, rings_of
from floeflow.state.schema import MOBILE, SCHEMA_VERSION

CATEGORIES, SPACING = 5, 1.0e4  # m
# Displacement of the elements over their spacing.
SHIFT, JITTER = 0.3, 0.1
PEER = "shapely.intersection"


def lattice_cells(count: int, seed: int = 0) -> Cells:
    """Cells of about so many discs, displaced at random from a lattice of triangles."""
    random = np.random.default_rng(seed)
    side = round(np.sqrt(count))
    i, j = (axis.ravel() for axis in np.meshgrid(np.arange(side), np.arange(side)))
    place = np.stack([i + 0.5 * (j % 2), np.sqrt(0.75) * j], axis=1) * SPACING
    place += random.uniform(-0.05, 0.05, place.shape) * SPACING
    radius = np.full(len(place), 0.44 * SPACING)
    wide = (side + 2) * SPACING
    middle = place.mean(axis=0)
    low = middle - 0.5 * wide
    grid = Grid(middle[:1], middle[1:], wide, float(low[0]), float(low[1]))
    diagram = power_diagram(place, radius, grid)
    # Cells at the rim reach far out: they are left out.
    inner = np.flatnonzero(shapely.area(diagram.polygons) < 2.0 * SPACING**2)
    number = np.full(len(place), -1)
    number[inner] = np.arange(len(inner))
    lo, hi = number[diagram.lo], number[diagram.hi]
    both = (lo >= 0) & (hi >= 0)
    polygons = diagram.polygons[inner]
    return Cells(
        *(np.arange(1, len(inner) + 1), place[inner, 0], place[inner, 1], radius[inner]),
        *(shapely.area(polygons), polygons, lo[both], hi[both], diagram.ends[both]),
    )


def sheet_state(cells: Cells, seed: int = 0) -> xr.Dataset:
    """State of ice in all cells but those at the rim, whose elements have moved."""
    random = np.random.default_rng(seed)
    n = len(cells.id)
    wide = (n, CATEGORIES)
    start, ring = rings_of(cells.polygons)
    corners = np.diff(start)
    data = {
        "id": cells.id,
        "type": np.full(n, MOBILE, np.int8),
        **{"x": cells.x, "y": cells.y, "radius": cells.radius, "area": cells.area},
        **{name: random.normal(size=n) for name in ("u", "v", "omega")},
        **{name: np.zeros(n) for name in ("theta", "drift_x", "drift_y")},
        "cell_corners": corners,
    }
    wave = 1.0 + 0.3 * np.sin(2e-5 * cells.x)[:, None] * np.cos(1e-5 * cells.y)[:, None]
    column = {
        "ice_fraction": np.broadcast_to(0.14 * wave, wide),
        "ice_volume": 0.2 * wave * np.arange(1, CATEGORIES + 1),
        "snow_volume": np.broadcast_to(0.02 * wave, wide),
        "surface_temperature": 250.0 * wave**0.1 + np.zeros(wide),
    }
    bonds = new_bonds(
        {"id": cells.id, "x": cells.x, "y": cells.y, "theta": np.zeros(n)},
        *(cells.id[cells.lo], cells.id[cells.hi]),
        *cells.ends.reshape(len(cells.lo), 4).T,
        np.ones(len(cells.lo)),
    )
    body = ring - np.repeat(np.stack([cells.x, cells.y], axis=1), corners, axis=0)
    state = xr.Dataset(
        {name: ("element", values) for name, values in data.items()}
        | {name: (("element", "category"), values) for name, values in column.items()}
        | {f"corner_{axis}": ("corner", body[:, k]) for k, axis in enumerate("xy")}
        | {f"bond_{name}": ("bond", values) for name, values in bonds.items()}
        | {f"contact_{name}": ("contact", np.zeros(0)) for name in ("slip", "rest_overlap")}
        | {f"contact_id_{end}": ("contact", np.zeros(0, np.int64)) for end in ("lo", "hi")},
        attrs={"schema_version": SCHEMA_VERSION, "unclaimed_water": 0.0},
    )
    for axis in ("x", "y"):
        away = SHIFT + JITTER * random.uniform(-1.0, 1.0, n)
        state[axis] = ("element", state[axis].values + away * SPACING)
    return state


def peer_pairs(state: xr.Dataset, cells: Cells) -> tuple[np.ndarray, np.ndarray]:
    """Polygons of all pairs of old and fresh cells that meet."""
    start, corner = outlines(state, np.arange(state.sizes["element"]))
    place = np.stack([state["x"].values, state["y"].values], axis=1)
    old = carried_polygons(start, corner, place, state["theta"].values, state["area"].values)
    source, target = shapely.STRtree(cells.polygons).query(old, predicate="intersects")
    return old[source], cells.polygons[target]


def element_records(sizes: list[int], repeats: int) -> list[Record]:
    """Records of whole remaps and of laying alone, timed in turn with shapely."""
    records = []
    # Compiling and importing are not timed.
    warm = lattice_cells(400)
    remap(sheet_state(warm), warm, lay(sheet_state(warm), warm), 0.2)
    for size in sizes:
        cells = lattice_cells(size)
        state = sheet_state(cells)
        one, two = peer_pairs(state, cells)
        laying, whole, peer = [], [], []
        for _ in range(repeats):
            began = time.perf_counter()
            laid = lay(state, cells)
            laying.append(time.perf_counter() - began)
            remap(state, cells, laid, 0.2)
            whole.append(time.perf_counter() - began)
            began = time.perf_counter()
            shapely.area(shapely.intersection(one, two))
            peer.append(time.perf_counter() - began)
        figures = {
            "pairs": len(one),
            "times_the_peer": float(np.median(np.divide(whole, peer))),
            # Of the whole process, so of the largest case so far.
            "bytes_per_element": 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / size,
        }
        n = len(cells.id)
        records.append(Record("elements_overlap", n, 1, laying, PEER, peer, {"pairs": len(one)}))
        records.append(Record("elements_remap", n, 1, whole, PEER, peer, figures))
    return records


def main() -> None:
    """Run, write and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--sizes", type=int, nargs="+", default=[10_000, 100_000])
    parser.add_argument("--out", type=Path, default=Path("results/benchmarks/remap_elements.json"))
    options = parser.parse_args()
    records = element_records(options.sizes, options.repeats)
    write_records(records, options.out)
    for record in records:
        speed = np.median(record.seconds)
        print(
            f"{record.name:18} n {record.n:7} {speed:8.3f} s, "
            f"{np.median(np.divide(record.seconds, record.peer_seconds)):6.2f} times {record.peer}"
        )


if __name__ == "__main__":
    main()
