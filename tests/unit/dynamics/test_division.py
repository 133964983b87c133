# SPDX-License-Identifier: GPL-2.0-or-later
"""How the box is cut among ranks: as much work for each, no part too narrow."""

from __future__ import annotations

import numpy as np
import pytest

from floeflow.dynamics.engine.division import Division, choose_division
from floeflow.state.bonds import Arrays

BOX = ((0.0, 100.0), (0.0, 60.0))


def pack(count: int, width: float, height: float) -> Arrays:
    """Mobile elements at random places in the lower left of the box."""
    random = np.random.default_rng(5)
    x, y = random.uniform(0, width, count), random.uniform(0, height, count)
    return {"x": x, "y": y, "type": np.ones(count, np.int8)}


def shares(elements: Arrays, division: Division) -> np.ndarray:
    """Elements of each rank over their mean."""
    cuts = [
        np.array(each) * high for each, (_, high) in zip((division.x, division.y), BOX, strict=True)
    ]
    counts, _, _ = np.histogram2d(elements["x"], elements["y"], cuts)
    return counts / counts.mean()


@pytest.mark.parametrize("ranks", [2, 4, 6])
def test_a_pack_that_fills_half_the_box_is_shared_evenly(ranks: int) -> None:
    elements = pack(4000, 50.0, 60.0)
    division = choose_division(elements, ranks, BOX, 0.5)
    assert division is not None
    assert shares(elements, division).size == ranks
    assert shares(elements, division).max() < 1.05
    assert division.command == f"processors {len(division.x) - 1} {len(division.y) - 1} 1"
    for cuts in (division.x, division.y):
        assert (cuts[0], cuts[-1]) == (0.0, 1.0) and (np.diff(cuts) > 0).all()


def test_rims_count_so_that_parts_are_compact() -> None:
    division = choose_division(pack(4000, 100.0, 60.0), 4, BOX, 8.0)
    assert division is not None and (len(division.x), len(division.y)) == (3, 3)


def test_fixed_elements_are_less_work() -> None:
    elements = pack(4000, 100.0, 10.0)
    elements["type"][elements["x"] < 50.0] = 2
    division = choose_division(elements, 2, BOX, 6.0)
    # Half of the work is 0.3: 0.1 of the fixed half, and 0.4 of the mobile one.
    assert division is not None and division.x[1] == pytest.approx(0.7, abs=0.02)


def test_liggghts_divides_where_parts_would_be_narrower_than_a_rim() -> None:
    assert choose_division(pack(4000, 100.0, 60.0), 1, BOX, 0.5) is None
    assert choose_division(pack(4000, 100.0, 60.0), 4, BOX, 55.0) is None
    assert choose_division(pack(3, 100.0, 60.0), 64, BOX, 20.0) is None
