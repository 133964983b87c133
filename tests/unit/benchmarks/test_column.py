# SPDX-License-Identifier: GPL-2.0-or-later
"""The benchmark of the column runs and names what it timed."""

import importlib.util
from pathlib import Path

import numba
import pytest


def test_every_scheme_is_timed(project: Path) -> None:
    spec = importlib.util.spec_from_file_location("bench_column", project / "benchmarks/column.py")
    assert spec and spec.loader
    bench = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(bench)
    threads = numba.get_num_threads()
    try:
        layered = bench.time_layered("bl99", "summer", 30, 1, 2)
        mushy = bench.time_layered("mushy", "winter", 30, 1, 2)
        ponds = bench.time_layered("mushy_ponds", "summer", 30, 1, 2)
    finally:
        numba.set_num_threads(threads)
    flat = bench.time_zero_layer("winter", 30, 2)
    timed = {"bl99": layered, "mushy": mushy, "mushy_ponds": ponds, "zero_layer": flat}
    for scheme, record in timed.items():
        data = record.as_dict()
        assert data["scheme"] == scheme and data["n"] == 30 and data["repeats"] == 2
        work = 30 * data["steps"]
        assert data["column_steps_per_s"] == pytest.approx(work / min(data["seconds"]))
    assert layered.extra["rescued"] == 0 and 1.0 <= layered.extra["sweeps_mean"] < 6.0
