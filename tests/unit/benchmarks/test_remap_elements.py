# SPDX-License-Identifier: GPL-2.0-or-later
"""The benchmark of whole remaps: that what it times is a remap, and its records."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from support.remesh_cases import remapped, scales, totals


@pytest.fixture(scope="module")
def bench(project: Path) -> ModuleType:
    place = project / "benchmarks" / "remap_elements.py"
    spec = importlib.util.spec_from_file_location("bench_remap_elements", place)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_what_is_timed_is_a_remap(bench: ModuleType) -> None:
    cells = bench.lattice_cells(150)
    state = bench.sheet_state(cells)
    assert state.sizes["bond"] > 2 * len(cells.id)
    after = remapped(state, cells)
    before, scale = totals(state), scales(state)
    for name, value in totals(after).items():
        assert value == pytest.approx(before[name], abs=1e-12 * scale[name]), name
    assert after.sizes["bond"] > len(cells.id)
    one, two = bench.peer_pairs(state, cells)
    assert len(one) == len(two) > 3 * len(cells.id)


def test_records_say_times_the_peer(bench: ModuleType) -> None:
    records = bench.element_records([150], 2)
    assert [record.name for record in records] == ["elements_overlap", "elements_remap"]
    for record in records:
        assert len(record.seconds) == len(record.peer_seconds) == 2 and record.peer
    whole = records[1]
    ratio = np.median(np.divide(whole.seconds, whole.peer_seconds))
    assert whole.extra["times_the_peer"] == pytest.approx(ratio)
