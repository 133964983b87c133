# SPDX-License-Identifier: GPL-2.0-or-later
"""Files and tests that documents, docstrings and comments name are there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from support.listing import listed

FILE = re.compile(
    r"(?<![\w/.<*{$+-])((?:[\w.+-]+/)*[\w+-]{3,}"
    r"\.(?:py|h|cpp|md|yaml|smk|sh|j2|js|css|cff|stl))\b(?![\w(*])"
)
TEST = re.compile(r"\b(test_\w+)\b(?!\.\w|\*)")
# What readers write, what runs make, and files of other programs.
ELSEWHERE = set(
    "config/scenes/mine.yaml config/scenes/first.yaml config/scenes/storm.yaml "
    "config/scenes/own_data.yaml scene.yaml my_effects.py my_figures.py my_numbers.py "
    "my_readers.py liggghts_models/laws/swell.h wall.stl triangles.py longer.py after.py look.py "
    "make_era5.py make_mask.py "
    "table.md benchmarks/summary.md contact_models.h src/DEMSI/pair_gran_hopkins.cpp "
    "pair_gran_hopkins.cpp".split()
)


def lost_files(text: str, page: str, there: set[str]) -> set[str]:
    """Files that a text names and that lie neither beside it nor at the end of a path."""
    found = set()
    for line in text.splitlines():
        if line.lstrip().startswith("#include"):
            continue
        for name in FILE.findall(line):
            beside = (Path("/") / page).parent.joinpath(name).resolve().as_posix()[1:]
            plain = name.removeprefix("../")
            ends = any(path == plain or path.endswith(f"/{plain}") for path in there)
            if not (ends or beside in there or name in ELSEWHERE or name.startswith("results/")):
                found.add(name)
    return found


def test_files_that_are_named_are_there(project: Path):
    there = set(listed(project))
    pages = listed(project, "*.md", "floeflow/*.py", "liggghts_models/*", "config/*.yaml", "*.smk")
    found = {}
    for page in pages:
        if page.endswith((".md", ".py", ".h", ".cpp", ".yaml", ".smk")) and page != "CHANGELOG.md":
            if lost := lost_files((project / page).read_text(), page, there):
                found[page] = lost
    assert found == {}


def test_tests_that_are_named_are_there(project: Path):
    tests = [name for name in listed(project, "*.py", "*.cpp") if "tests/" in name]
    known = {Path(name).stem for name in tests}
    for name in tests:
        known |= set(re.findall(r"def (test_\w+)", (project / name).read_text()))
    # Targets of CMake.
    known |= set(TEST.findall((project / "liggghts_models/CMakeLists.txt").read_text()))
    pages = listed(project, "*.md", "floeflow/*.py", "liggghts_models/*.h", "config/*.yaml")
    found = {}
    for page in pages:
        if page != "CHANGELOG.md":
            named = set(TEST.findall((project / page).read_text()))
            if lost := {name for name in named if name not in known and f"{name}s" not in known}:
                found[page] = lost
    assert found == {}


@pytest.mark.parametrize(
    ("text", "lost"),
    [
        ("see `floeflow/cli.py` and cli.py", set()),
        ("see `bondtable.py` on EDGE_SHARE", {"bondtable.py"}),
        ("[limits](../limits.md), [state](state.md)", {"state.md"}),
        ('#include "atom.h"', set()),
        ("tests/unit/test_moved.py", {"tests/unit/test_moved.py"}),
    ],
)
def test_a_file_that_is_not_there_is_found(text: str, lost: set[str]):
    assert lost_files(text, "docs/theory/sea.md", {"floeflow/cli.py", "docs/limits.md"}) == lost
