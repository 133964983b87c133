# SPDX-License-Identifier: GPL-2.0-or-later
"""What the verification cases share: their marker, a log, and figures on request."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import matplotlib
import pytest
from matplotlib.figure import Figure

HERE = Path(__file__).resolve().parent
IMAGES = HERE.parents[1] / "docs" / "images" / "verification"

Show = Callable[..., None]


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--figures", action="store_true", help="draw the figures in docs/images/verification"
    )


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if HERE in item.path.parents:
            item.add_marker("verification")


@pytest.fixture
def show(request: pytest.FixtureRequest) -> Show:
    """Draw and save a figure, where the command line asks for figures."""

    def save(name: str, draw: Callable[..., Figure], *data: object) -> None:
        if not request.config.getoption("--figures", default=False):
            return
        matplotlib.use("Agg")
        IMAGES.mkdir(parents=True, exist_ok=True)
        # Without the version of Matplotlib in it, the same figure has the same bytes.
        draw(*data).savefig(IMAGES / f"{name}.png", dpi=100, metadata={"Software": None})

    return save


@pytest.fixture
def log(tmp_path: Path) -> Path:
    return tmp_path / "liggghts.log"
