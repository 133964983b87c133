# SPDX-License-Identifier: GPL-2.0-or-later
"""Speed of the column schemes: column-steps per second and core, over threads and columns.

Usage: python benchmarks/column.py [--repeats 7] [--largest 1000000] [--out FILE]
Columns of five categories start from many thicknesses, live 20 days in a winter or a summer, and
are timed from there in hourly steps, compiled beforehand. No peer runs beside it: the speed of
Icepack (Fortran, -O3) is quoted from a machine of the same kind.
"""

from __future__ import annotations

import argparse
import resource
import time
from pathlib import Path

import numba
import numpy as np

from floeflow.column.layered import LayeredState, pack_forcing, step, take
from floeflow.column.params import ColumnParams
from floeflow.column.physics import KELVIN, Physics
from floeflow.column.records import Array
from floeflow.column.state import ColumnForcing, ColumnState
from floeflow.column.thermodynamics import zero_layer
from floeflow.column.thermodynamics.enthalpy import ice_enthalpy, salinity_profile
from floeflow.column.thickness.categories import category_bounds
from floeflow.core.records import Record, write_records

DT = 3600.0  # s
CATEGORIES = 5
STEPS = 24
SCHEMES = {
    "bl99": Physics(),
    "mushy": Physics(mushy=True),
    "mushy_ponds": Physics(mushy=True, delta_eddington=True, ponds=True),
}  # the last with delta-Eddington light
ICEPACK = {
    "bl99": [33000, 43000],
    "mushy": [23000, 32000],
    "mushy_ponds": [15000, 29000],
}  # column-steps/s per core, five categories
SEASONS = {
    "winter": {"air": 243.0, "longwave": 170.0, "sun": 0.0, "snow": 1e-6, "humidity": 2.5e-4},
    "summer": {"air": 273.0, "longwave": 295.0, "sun": 260.0, "snow": 0.0, "humidity": 3.4e-3},
}


def weather(season: str, steps: int, count: int, seed: int) -> dict[str, Array]:
    """Weather of a season around its mean, another one for each column and step."""
    rng = np.random.default_rng(seed)
    mean = SEASONS[season]
    shape = (steps, count)
    sun = mean["sun"] * rng.uniform(0.5, 1.5, shape)
    return {
        "potential_temperature": mean["air"] + rng.uniform(-2.0, 2.0, shape),
        "humidity": mean["humidity"] * rng.uniform(0.8, 1.2, shape),
        "density": np.full(shape, 1.3),
        "wind": rng.uniform(2.0, 8.0, shape),
        "longwave": mean["longwave"] + rng.uniform(-10.0, 10.0, shape),
        "visible": 0.52 * sun,
        "infrared": 0.48 * sun,
        "snowfall": np.full(shape, mean["snow"]),
        "sea_salinity": np.full(shape, 34.0),
        "deep_heat": np.full(shape, 2.0),
        "mixed_depth": np.full(shape, 20.0),
        "ocean_friction": np.full(shape, 2e-3),
        "sun_height": np.full(shape, 0.38 if mean["sun"] > 0.0 else -0.4),
    }


def columns(season: str, count: int, seed: int, p: Physics) -> LayeredState:
    """Columns with ice in every category after 20 days of a season."""
    rng = np.random.default_rng(seed)
    bounds = category_bounds(CATEGORIES)
    shape = (count, CATEGORIES)
    thickness = bounds[:-1] + (np.minimum(bounds[1:], 6.0) - bounds[:-1]) * rng.uniform(
        0.2, 0.8, shape
    )
    area = 0.95 * rng.dirichlet(np.full(CATEGORIES, 3.0), count)
    salinity = salinity_profile(7, p)
    layer = [
        ice_enthalpy.py_func(-8.0 + k, -p.melting_slope * s, p) for k, s in enumerate(salinity)
    ]
    state = LayeredState(
        ice_fraction=area,
        ice_volume=area * thickness,
        snow_volume=area * rng.uniform(0.0, 0.3, shape),
        surface_temperature=np.full(shape, -10.0),
        ice_enthalpy=np.broadcast_to(layer, (*shape, 7)).copy(),
        snow_enthalpy=np.full((*shape, 1), -p.snow_density * (p.fusion + 10.0 * p.heat_ice)),
        ice_salinity=np.broadcast_to(salinity, (*shape, 7)).copy(),
        sea_temperature=np.full(count, -1.8),
        pending_freeze=np.zeros(count),
    )
    for day in range(20):
        forcing = pack_forcing(weather(season, 24, count, seed + 1 + day), 24, count)
        state, _ = step(state, forcing, DT, bounds, p)
    return state


def time_layered(scheme: str, season: str, count: int, threads: int, repeats: int) -> Record:
    """Time a layered scheme by its name in ``SCHEMES``."""
    p, bounds = SCHEMES[scheme], category_bounds(CATEGORIES)
    some = columns(season, min(count, 1000), 1, p)
    state = take(some, np.arange(count) % len(some.sea_temperature))
    one = pack_forcing(weather(season, STEPS, min(count, 1000), 99), STEPS, min(count, 1000))
    # Many columns get fewer steps, so that forcing does not fill the memory.
    steps = STEPS if count <= 10000 else 1
    forcing = one[:steps, np.arange(count) % one.shape[1]]
    numba.set_num_threads(threads)
    seconds, cpu = [], []
    for _ in range(repeats):
        start = time.perf_counter(), time.process_time()
        _, sums = step(state, forcing, DT, bounds, p)
        seconds.append(time.perf_counter() - start[0])
        cpu.append(time.process_time() - start[1])
    speed = count * steps / min(cpu)
    extra = {
        "scheme": scheme,
        "season": season,
        "categories": CATEGORIES,
        "steps": steps,
        "column_steps_per_s": count * steps / min(seconds),
        "column_steps_per_cpu_s": speed,
        "sweeps_mean": float(sums["sweeps"].sum() / sums["solves"].sum()),
        "rescued": int(sums["rescued"].sum()),
        "peak_memory_MB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
        "icepack_quoted_per_core": ICEPACK[scheme],
        "ratio_to_quoted": [speed / quoted for quoted in ICEPACK[scheme]],
    }
    return Record(f"column/{scheme}/{season}", count, threads, seconds, extra=extra)


def time_zero_layer(season: str, count: int, repeats: int) -> Record:
    """Time the zero-layer scheme, plain NumPy on one core, one category."""
    values = {name: value[0] for name, value in weather(season, 1, count, 5).items()}
    forcing = ColumnForcing(
        air_temperature=values["potential_temperature"],
        specific_humidity=values["humidity"],
        wind_speed=values["wind"],
        shortwave_down=values["visible"] + values["infrared"],
        longwave_down=values["longwave"],
        snowfall=values["snowfall"],
        air_pressure=np.full(count, 1e5),
        ocean_heat_flux=values["deep_heat"],
        friction_velocity=values["ocean_friction"],
    )
    thick = np.random.default_rng(2).uniform(0.1, 4.0, (count, 1))
    area = np.full((count, 1), 0.95)
    state = ColumnState(area, area * thick, 0.1 * area, np.full((count, 1), KELVIN - 10.0))
    seconds = []
    for _ in range(repeats):
        start, after = time.perf_counter(), state
        for _ in range(STEPS):
            after, _ = zero_layer.step(after, forcing, DT, ColumnParams())
        seconds.append(time.perf_counter() - start)
    extra = {
        "scheme": "zero_layer",
        "season": season,
        "categories": 1,
        "steps": STEPS,
        "column_steps_per_s": count * STEPS / min(seconds),
    }
    return Record(f"column/zero_layer/{season}", count, 1, seconds, extra=extra)


def main() -> None:
    """Time all cases and write them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--largest", type=int, default=1000000, help="columns, a power of ten")
    parser.add_argument("--out", type=Path, default=Path("results/benchmarks/column.json"))
    options = parser.parse_args()
    most = numba.config.NUMBA_NUM_THREADS
    records = [time_zero_layer(season, 1000, options.repeats) for season in SEASONS]
    for scheme in SCHEMES:
        for season in SEASONS:
            for threads in range(1, most + 1):
                records.append(time_layered(scheme, season, 1000, threads, options.repeats))
    count = 100
    while count <= options.largest:
        records.append(time_layered("bl99", "winter", count, 1, options.repeats))
        count *= 10
    write_records(records, options.out)
    for record in records:
        print(f"{record.name:26s} {record.n:8d} columns, {record.ranks} threads: ", end="")
        print(f"{record.extra['column_steps_per_s']:10.0f} column-steps/s")


if __name__ == "__main__":
    main()
