# SPDX-License-Identifier: GPL-2.0-or-later
"""What the verification cases share: their marker and a log."""

from __future__ import annotations

from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if HERE in item.path.parents:
            item.add_marker("verification")


@pytest.fixture
def log(tmp_path: Path) -> Path:
    return tmp_path / "liggghts.log"
