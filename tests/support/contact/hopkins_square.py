# SPDX-License-Identifier: GPL-2.0-or-later
"""The uniform-stress case of Hopkins, Frankenstein & Thorndike (2004): a bonded square torn apart.

Surface stress of 1.44e-6 Pa for each metre from the centre, outward, on 400 km of elements with
radii of 3 to 5 km. As a script under mpirun it runs the case in two parts for the tests of ranks.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import shapely
from mpi4py import MPI
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from floeflow.core.grids import Grid
from floeflow.dynamics.engine.engine import Engine, EngineParams, Forcing
from floeflow.dynamics.step.critical import critical_step
from floeflow.packings.tessellation import power_diagram
from floeflow.state.bonds import Arrays, new_bonds
from support.full_ice import full_params

SIDE, SMALLEST, LARGEST, FILLED = 400e3, 3e3, 5e3, 0.78
GRADIENT = 1.44e-6  # Pa/m
THICKNESS = 0.3  # m; not part of the published numbers at hand
CUT, LAST = 300, 1000  # steps: in the middle of fracture, and the end of a run
LAWS = {"bonds": True, "wind": True, "ocean_drag": True, "strength": "kovacs_sodhi"}


def square(seed: int, side: float = SIDE) -> tuple[Arrays, Arrays]:
    """Elements and bonds: discs at random, pushed apart, bonded along the edges of their cells."""
    random = np.random.default_rng(seed)
    mean_square = (LARGEST**2 + LARGEST * SMALLEST + SMALLEST**2) / 3
    n = round(FILLED * side**2 / (np.pi * mean_square))
    radius = random.uniform(SMALLEST, LARGEST, n)
    places = random.uniform(-side / 2, side / 2, (n, 2))
    bound = side / 2 - radius[:, None]
    for _ in range(800):
        pairs = cKDTree(places).query_pairs(2 * LARGEST, output_type="ndarray")
        i, j = pairs[np.lexsort(pairs.T)].T
        apart = places[j] - places[i]
        distance = np.hypot(*apart.T)
        push = np.maximum(radius[i] + radius[j] - distance, 0) / distance / 2
        for axis in (0, 1):
            places[:, axis] += np.bincount(j, push * apart[:, axis], n)
            places[:, axis] -= np.bincount(i, push * apart[:, axis], n)
        places = np.clip(places, -bound, bound)
    centres = np.arange(-side / 2 + 5e3, side / 2, 10e3)
    grid = Grid(centres, centres, 10e3, -side / 2, -side / 2)
    diagram = power_diagram(places, radius, grid)
    box = shapely.box(*(-side / 2,) * 2, *(side / 2,) * 2)
    area = shapely.area(shapely.intersection(diagram.polygons, box))
    elements: Arrays = {"id": np.arange(1, n + 1), "type": np.ones(n, np.int8)}
    elements |= {name: np.zeros(n) for name in ("theta", "u", "v", "omega")}
    elements |= {"x": places[:, 0].copy(), "y": places[:, 1].copy(), "radius": radius}
    elements |= {"mass": 917.0 * THICKNESS * area, "thickness": np.full(n, THICKNESS)}
    elements["ice_area"] = area
    lines = shapely.intersection(shapely.linestrings(diagram.ends), box)
    keep = shapely.length(lines) > 0.01 * SMALLEST
    ends = shapely.get_coordinates(lines[keep]).reshape(-1, 4)
    lo, hi = diagram.lo[keep] + 1, diagram.hi[keep] + 1
    return elements, new_bonds(elements, lo, hi, *ends.T, np.full(len(lo), THICKNESS))


def outward_wind(params: EngineParams, side: float = SIDE) -> Forcing:
    """Wind whose stress grows with the distance from the centre, by `GRADIENT` where side is SIDE.

    Stress in the ice goes with gradient times side squared: a smaller square gets a steeper wind.
    """
    gradient = GRADIENT * (SIDE / side) ** 2
    axis = np.linspace(-side, side, 161)
    x, y = np.meshgrid(axis, axis)
    r = np.hypot(x, y)
    share = np.sqrt(gradient / (params.wind_stress_factor * np.maximum(r, 1.0)))
    zero = np.zeros((1, *r.shape))
    fields = {"wind_u": (share * x)[None], "wind_v": (share * y)[None]}
    return Forcing(np.array([0.0]), axis, axis, fields | {"ocean_u": zero, "ocean_v": zero})


def stable(elements: Arrays, bonds: Arrays) -> EngineParams:
    """Parameters with 0.4 of the critical step."""
    step = 0.4 * critical_step(elements, bonds, full_params(time_step=1.0, **LAWS))[0]
    return full_params(time_step=step, **LAWS)


def aggregates(count: int, bonds: Arrays) -> np.ndarray:
    """Number of the aggregate (elements joined by intact bonds) of each element."""
    edge = np.ones(len(bonds["id_lo"]))
    graph = coo_matrix((edge, (bonds["id_lo"] - 1, bonds["id_hi"] - 1)), shape=(count, count))
    return connected_components(graph, directed=False)[1]


def exponent(sizes: np.ndarray, smallest: int) -> tuple[float, float, int]:
    """Maximum-likelihood exponent of a power law of sizes from `smallest`, its error, their number.

    For whole numbers, with the approximation of Clauset, Shalizi & Newman (2009), eq. 3.7.
    """
    tail = sizes[sizes >= smallest]
    alpha = 1 + len(tail) / np.log(tail / (smallest - 0.5)).sum()
    return float(alpha), float((alpha - 1) / np.sqrt(len(tail))), len(tail)


def main(out: Path, side: float, start: Path | None, deterministic: bool) -> None:
    """Write the state after 300 and after 1000 steps, or after 1000 from `start`."""
    elements, bonds = square(1, side)
    params = replace(stable(elements, bonds), deterministic=deterministic)
    state: list[Arrays | None] = [elements, bonds, None]
    kinds = ("element", "bond", "contact")
    if start is not None:
        with np.load(start) as data:
            state = [
                {
                    n.removeprefix(f"{kind}."): data[n]
                    for n in data.files
                    if n.startswith(f"{kind}.")
                }
                for kind in kinds
            ]
    comm = MPI.COMM_WORLD
    with Engine(comm, params, out / f"log.{comm.size}") as engine:
        engine.load(*state, time=0.0 if start is None else CUT * params.time_step)
        engine.set_forcing(outward_wind(params, side))
        done = 0 if start is None else CUT
        for step in (CUT, LAST) if start is None else (LAST,):
            engine.run(step - done)
            done = step
            now = (engine.elements(), engine.bonds(), engine.contacts())
            if comm.rank == 0:
                named = {
                    f"{kind}.{name}": values
                    for kind, table in zip(kinds, now, strict=True)
                    for name, values in table.items()
                }
                np.savez(out / f"{step}.npz", **named)


if __name__ == "__main__":
    folder, width, *more = sys.argv[1:]
    exact = "deterministic" in more
    begin = [Path(word) for word in more if word != "deterministic"]
    main(Path(folder), float(width), begin[0] if begin else None, exact)
