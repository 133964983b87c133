# SPDX-License-Identifier: GPL-2.0-or-later
"""One undisturbed run of ``smoke``, shared by the tests that compare with it or start from it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from support.runner import Done, Place, make_place


@pytest.fixture(scope="session")
def smoke(tmp_path_factory: pytest.TempPathFactory) -> Done:
    """``smoke`` as shipped, on two ranks."""
    place = make_place(tmp_path_factory.mktemp("smoke") / "place")
    scene = place.scene()
    done = place.run(scene)
    assert done.returncode == 0, done.stdout
    return Done(place, scene, done.stdout)


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
