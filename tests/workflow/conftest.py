# SPDX-License-Identifier: GPL-2.0-or-later
"""One undisturbed run of ``smoke``, shared by the tests that compare with it or start from it."""

from __future__ import annotations

import fcntl
from collections.abc import Callable
from pathlib import Path

import pytest

from support.runner import Done, Place, make_place


@pytest.fixture(scope="session")
def smoke(pytestconfig: pytest.Config, tmp_path_factory: pytest.TempPathFactory) -> Done:
    """``smoke`` as shipped, on two ranks; tests only look at it.

    Processes that run tests side by side share it: who needs it first makes it.
    """
    folder = pytestconfig.getoption("--beside") or tmp_path_factory.mktemp("smoke")
    place, said = Place(folder / "place"), folder / "smoke.txt"
    with open(folder / "smoke.lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not said.is_file():
            done = make_place(place.folder).run(place.scene(), ranks=2)
            assert done.returncode == 0, done.stdout
            said.write_text(done.stdout)
    return Done(place, place.folder / "smoke.yaml", said.read_text())


@pytest.fixture
def place(tmp_path: Path) -> Place:
    """An empty working folder."""
    return make_place(tmp_path / "place")


@pytest.fixture
def copy(smoke: Done, tmp_path: Path) -> Callable[[], Place]:
    """Make a copy of the finished run to change things in."""

    def make() -> Place:
        return make_place(tmp_path / "copy", like=smoke.place)

    return make
