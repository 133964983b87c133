# SPDX-License-Identifier: GPL-2.0-or-later
"""Tests in processes side by side: each takes the next module that no other has taken.

So all of them end at about the same time, whatever a module takes on the machine at hand.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from pathlib import Path

import pytest

TESTS = Path(__file__).resolve().parents[1]


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
    # Modules of the workflow take longest: begun first, they leave no process alone at the end.
    workflow = TESTS / "workflow"
    mine = taken(folder, sorted(session.items, key=lambda item: workflow not in item.path.parents))
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
