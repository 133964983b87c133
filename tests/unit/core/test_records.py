# SPDX-License-Identifier: GPL-2.0-or-later
"""The benchmark record."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from floeflow.core.records import Record, write_records


def test_a_ratio_above_one_is_faster_than_the_peer(tmp_path: Path):
    record = Record("own", 10, 1, [1.0, 2.0, 1.0], "peer", [3.0, 4.0, 2.0], {"steps": 7})
    write_records([record], tmp_path / "deep" / "b.json")
    (stored,) = json.loads((tmp_path / "deep" / "b.json").read_text())
    assert stored["ratio_median"] == 2.0
    assert (stored["repeats"], stored["steps"], stored["n"]) == (3, 7, 10)
    assert stored["machine"]


def test_without_a_peer_there_is_no_ratio():
    assert Record("own", 10, 1, [1.0]).ratio_median is None


def test_repeats_are_compared_in_pairs():
    with pytest.raises(ValueError):
        _ = Record("own", 1, 1, [1.0], "peer", [1.0, 2.0]).ratio_median
