# SPDX-License-Identifier: GPL-2.0-or-later
"""What all tests share: hypothesis, the project, reference data, figures on request."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import matplotlib
import pytest
from hypothesis import settings
from matplotlib.figure import Figure

PROJECT = Path(__file__).resolve().parents[1]

Show = Callable[..., None]

settings.register_profile("floeflow", deadline=None, derandomize=True, print_blob=True)
settings.load_profile("floeflow")


@pytest.fixture(scope="session")
def project() -> Path:
    """Folder of the project."""
    return PROJECT


@pytest.fixture(scope="session")
def shared() -> Path:
    """Folder with reference data; the test is skipped where there is none."""
    folder = Path(os.environ.get("FLOEFLOW_SHARED", PROJECT.parent / "shared"))
    if not folder.is_dir():
        pytest.skip(f"no reference data at {folder} (FLOEFLOW_SHARED names another folder)")
    return folder


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--figures", action="store_true", help="draw the figures in docs/images")
    parser.addoption("--part", metavar="K/N", help="of N parts of the modules run only the K-th")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Keep one part of the modules: dealt out in turn, so that all parts together are all."""
    part = config.getoption("--part")
    if not part:
        return
    number, of = map(int, part.split("/"))
    if not 1 <= number <= of:
        raise pytest.UsageError(f"--part {part}: there is no such part")
    modules = list(dict.fromkeys(item.path for item in items))
    kept = set(modules[number - 1 :: of])
    config.hook.pytest_deselected(items=[item for item in items if item.path not in kept])
    items[:] = [item for item in items if item.path in kept]


@pytest.fixture
def show(request: pytest.FixtureRequest) -> Show:
    """Draw and save a figure in docs/images, where the command line asks for figures.

    The folder there is that of the test below ``tests``: verification, stability.
    """
    folder = PROJECT / "docs/images" / request.path.relative_to(PROJECT / "tests").parts[0]

    def save(name: str, draw: Callable[..., Figure], *data: object) -> None:
        if not request.config.getoption("--figures"):
            return
        matplotlib.use("Agg")
        folder.mkdir(parents=True, exist_ok=True)
        # Without the version of Matplotlib in it, the same figure has the same bytes.
        draw(*data).savefig(folder / f"{name}.png", dpi=100, metadata={"Software": None})

    return save
