# SPDX-License-Identifier: GPL-2.0-or-later
"""Tests in two processes side by side: each takes the next module that the other has not taken.

One goes through them from the first to the last, the other from the last to the first. So both end
at about the same time, whatever a module takes on the machine at hand, and what all runs of the
workflow need, a column compiled by Numba, is made by one while the other does without it.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from pathlib import Path

import pytest

TESTS = Path(__file__).resolve().parents[1]

# Long modules lie at the ends, so that what is left when the two meet is short.
FIRST, LAST = ("workflow",), ("faults", "stability", "verification")


def place(path: Path) -> tuple[int, Path]:
    """Key that sorts modules: those of the workflow first, those of the element model last."""
    folder = path.relative_to(TESTS).parts[0]
    return (folder in LAST) - (folder in FIRST), path


def ordered(items: list[pytest.Item], backwards: bool) -> list[pytest.Item]:
    """Tests with the modules in their order, or in its reverse; inside of a module as they are."""
    return sorted(items, key=lambda item: place(item.path), reverse=backwards)


def taken(folder: Path, items: list[pytest.Item]) -> Iterator[pytest.Item]:
    """Tests of those modules that no process beside this one has taken: a file tells each taken."""
    for path, module in itertools.groupby(items, key=lambda item: item.path):
        try:
            (folder / str(path.relative_to(TESTS)).replace("/", ".")).open("x").close()
        except FileExistsError:
            continue
        yield from module


@pytest.hookimpl(tryfirst=True)
def pytest_runtestloop(session: pytest.Session) -> bool | None:
    """Share modules with the processes beside this one, as each comes to them."""
    folder = session.config.getoption("--beside")
    if not folder or session.testsfailed or session.config.option.collectonly:
        return None
    mine = taken(folder, ordered(session.items, session.config.getoption("--backwards")))
    item = next(mine, None)
    while item:
        # The next one tells which fixtures stay.
        following = next(mine, None)
        item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)
        if session.shouldfail:
            raise session.Failed(session.shouldfail)
        if session.shouldstop:
            raise session.Interrupted(session.shouldstop)
        item = following
    return True
