# SPDX-License-Identifier: GPL-2.0-or-later
"""An effect that is off costs nothing in the pair loop: instructions counted, no clock."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from floeflow.dynamics.pluginlib import plugin_path
from floeflow.mpi import mpi_environment


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
    "stretch": r"evaluate_bonds<\(floe::Damping\)0, false>",
}


def count(folder: Path, loop: str, steps: int) -> tuple[int, int]:
    """Instructions of the pair style's loop and of the one by hand over a number of steps."""
    program, counts = plugin_path().with_name("count_loop"), folder / f"counts.{steps}"
    command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={counts}", str(program)]
    done = subprocess.run(
        [*command, loop, str(steps)],
        env=mpi_environment(), capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    functions = inclusive_counts(counts)
    (own,) = [n for name, n in functions.items() if re.search(LOOPS[loop], name)]
    return own, functions[f"{loop}_by_hand"]


@pytest.mark.parametrize("loop", LOOPS)
def test_what_is_off_costs_nothing_in_the_loop(tmp_path: Path, loop: str) -> None:
    """Contacts with damping alone, with friction alone, and bonds without damping."""
    if shutil.which("valgrind") is None:
        pytest.skip("valgrind, which counts the instructions, is not installed")
    # The difference leaves out what the first contact of a pair costs.
    few, many = count(tmp_path, loop, 2), count(tmp_path, loop, 22)
    own, by_hand = many[0] - few[0], many[1] - few[1]
    print(f"{loop}: {own} instructions, by hand {by_hand}")
    assert by_hand > 0
    assert own == pytest.approx(by_hand, rel=0.01)
