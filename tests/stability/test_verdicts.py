# SPDX-License-Identifier: GPL-2.0-or-later
"""All hard cases that run the element model: the same verdict on 1, 2 and 4 ranks.

Sums of forces round off in another order on another number of ranks, neighbours lie on other
ranks, some ranks have nothing to do, and a fault that one rank finds must end all of them, with the
same sentence. What must hold: stable on one is stable on all; refused or stopped on one is so on
all, with the same element named; the invariants hold on all; what is not chaotic agrees to a
millionth, and with `dynamics.deterministic` to the bit.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from floeflow.core.mpi import mpi_environment
from support.stability.verdict_cases import CASES

pytestmark = pytest.mark.mpi

TESTS = Path(__file__).resolve().parents[1]
CASES_SCRIPT = "support/stability/verdict_cases.py"
STOPPED = {"2 step beyond the limit", "3 radius of nothing", "5 ice that nothing breaks"}


def judged(ranks: int, folder: Path) -> dict[str, Any]:
    """Verdicts of all cases on so many ranks."""
    folder.mkdir()
    paths = [str(TESTS), os.environ.get("PYTHONPATH", "")]
    done = subprocess.run(
        ["mpirun", "-n", str(ranks), sys.executable, str(TESTS / CASES_SCRIPT), str(folder)],
        env=mpi_environment() | {"PYTHONPATH": os.pathsep.join(filter(None, paths))},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return json.loads((folder / "verdicts.json").read_text())


@pytest.fixture(scope="module")
def verdicts(tmp_path_factory: pytest.TempPathFactory) -> dict[int, dict[str, Any]]:
    """Verdicts by number of ranks."""
    folder = tmp_path_factory.mktemp("ranks")
    return {ranks: judged(ranks, folder / str(ranks)) for ranks in (1, 2, 4)}


@pytest.mark.parametrize("case", CASES)
def test_one_verdict_on_any_number_of_ranks(verdicts: dict[int, dict[str, Any]], case: str, record):
    """The same verdict on 1, 2 and 4 ranks."""
    one = verdicts[1][case]
    apart = 0.0
    for ranks in (2, 4):
        more = verdicts[ranks][case]
        assert more["verdict"] == one["verdict"]
        assert more["exact"] == one["exact"]
        for name, value in one["close"].items():
            assert more["close"][name] == pytest.approx(value, rel=1e-6), name
            apart = max(apart, abs(more["close"][name] / value - 1.0) if value else 0.0)
    record(ranks="1, 2, 4", verdict=one["verdict"]["kind"], largest_difference=apart)
    assert (one["verdict"]["kind"] == "refused") == (case in STOPPED)
    assert (len(one["verdict"]["named"]) > 0) == (case in STOPPED)
    # A verdict is the same when all are wrong, too: what must hold, holds.
    kept = {name: v for name, v in one["exact"].items() if isinstance(v, bool)}
    assert all(kept.values()), kept
