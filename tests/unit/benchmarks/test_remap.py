# SPDX-License-Identifier: GPL-2.0-or-later
"""The benchmark of the transfers runs, and names what it timed beside which peer."""

import importlib.util
from pathlib import Path


def test_every_case_is_timed(project: Path) -> None:
    spec = importlib.util.spec_from_file_location("bench_remap", project / "benchmarks/remap.py")
    assert spec and spec.loader
    bench = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(bench)
    records = [record for n in (400, 1600) for case in bench.CASES for record in case(n, 2)]
    data = {(record.name, record.n): record.as_dict() for record in records}
    assert data["remap/apply", 400]["peer"] == "numpy.bincount"
    assert data["remap/build_apply", 1600]["peer"] == "scipy griddata(linear)"
    assert data["remap/build_apply", 1600]["repeats"] == 2
    assert 40 < data["remap/apply", 1600]["bytes_per_element"] < 60
    assert 100 < data["remap/apply", 1600]["build_bytes_per_element"] < 200
    assert all(record.ratio_median is None or record.ratio_median > 0 for record in records)
    lines = bench.growth(records)
    assert any(line.startswith("remap/build: 4 x the elements") for line in lines)
