# SPDX-License-Identifier: GPL-2.0-or-later
"""A hundred runs that are killed inside of a window, in five ways: each ends with the same bits.

The window is drawn from a seed; each kill strikes while its steps are counted.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from support.kills import MODES, kill_inside, start_over, wait_for_jobs
from support.runner import Done, bits, make_place

pytestmark = [pytest.mark.workflow, pytest.mark.stability, pytest.mark.slow]

TARGET = "results/smoke/state/0003.nc"
KILLS = 100


@pytest.fixture(scope="module")
def smoke(tmp_path_factory: pytest.TempPathFactory) -> Done:
    """``smoke`` up to its last state, on two ranks."""
    place = make_place(tmp_path_factory.mktemp("smoke") / "place")
    scene = place.scene()
    done = place.run(scene, TARGET)
    assert done.returncode == 0, done.stdout
    return Done(place, scene, done.stdout)


@pytest.mark.parametrize("number", range(KILLS))
def test_a_killed_run_ends_with_the_same_bits(smoke: Done, tmp_path: Path, number: int):
    mode = MODES[number % len(MODES)]
    window = int(np.random.default_rng(number).integers(1, 4))
    place = make_place(tmp_path / "copy", like=smoke.place)
    start_over(place)
    place = kill_inside(place, smoke.scene, TARGET, mode, f"window {window:04d}: step")
    if mode != "snakemake":
        wait_for_jobs(place)
    done = place.run(smoke.scene, TARGET)
    assert done.returncode == 0, done.stdout
    assert bits(place.results()) == bits(smoke.results)
