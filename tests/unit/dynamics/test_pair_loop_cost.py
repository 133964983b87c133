# SPDX-License-Identifier: GPL-2.0-or-later
"""An effect that is off costs nothing in the pair loop: instructions counted, no clock."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from floeflow.core.mpi import mpi_environment
from floeflow.core.plugin import plugin_path


def inclusive_counts(counts: Path) -> dict[str, int]:
    """Instructions of each function with what it calls."""
    command = ["callgrind_annotate", "--inclusive=yes", "--threshold=100", str(counts)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    found = re.findall(r"^\s*([\d,]+) \(.*?\)\s+\S*?:(.*?)(?: \[.*\])?$", done.stdout, re.MULTILINE)
    return {name: int(number.replace(",", "")) for number, name in found}


# What is run, the pair style's function and what is on in it, and that by hand.
LOOPS = {
    "push": r"PairFloe::loop_contacts<floe::ContactTerms<false, false, \(floe::Damping\)1, false",
    "rub": r"PairFloe::loop_contacts<floe::ContactTerms<true, false, \(floe::Damping\)0, false",
    "stretch": r"evaluate_bonds<floe::GlueBond, \(floe::Damping\)0, false>",
}


def count(folder: Path, steps: int) -> dict[str, tuple[int, int]]:
    """Instructions of the pair style's loops and of those by hand over a number of steps."""
    program, counts = plugin_path().with_name("count_loop"), folder / f"counts.{steps}"
    command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={counts}", str(program)]
    done = subprocess.run(
        [*command, str(steps)], env=mpi_environment(), capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    functions = inclusive_counts(counts)
    out = {}
    for loop, pattern in LOOPS.items():
        (own,) = [n for name, n in functions.items() if re.search(pattern, name)]
        out[loop] = own, functions[f"{loop}_by_hand"]
    return out


@pytest.fixture(scope="module")
def counts(tmp_path_factory: pytest.TempPathFactory) -> list[dict[str, tuple[int, int]]]:
    if shutil.which("valgrind") is None:
        pytest.skip("valgrind, which counts the instructions, is not installed")
    folder = tmp_path_factory.mktemp("counts")
    return [count(folder, steps) for steps in (2, 22)]


@pytest.mark.parametrize("loop", LOOPS)
def test_what_is_off_costs_nothing_in_the_loop(
    counts: list[dict[str, tuple[int, int]]], loop: str
) -> None:
    """Contacts with damping alone, with friction alone, and bonds without damping."""
    # The difference leaves out what the first contact of a pair costs.
    (own, by_hand), (few, few_by_hand) = counts[1][loop], counts[0][loop]
    own, by_hand = own - few, by_hand - few_by_hand
    assert by_hand > 0
    assert own == pytest.approx(by_hand, rel=0.01)
