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

from support.beside import pytest_runtestloop  # noqa: F401

PROJECT = Path(__file__).resolve().parents[1]
# Of this process when the tests began.
PROCESSORS = os.sched_getaffinity(0)

# How a test begins to say that it was skipped for want of reference data.
NO_DATA = "no reference data"

Show = Callable[..., None]

settings.register_profile("floeflow", deadline=None, derandomize=True, print_blob=True)
settings.load_profile("floeflow")


@pytest.fixture(scope="session")
def project() -> Path:
    """Folder of the project."""
    return PROJECT


@pytest.fixture(scope="session")
def shared(pytestconfig: pytest.Config) -> Path:
    """Folder with reference data; without it a test is skipped, or fails with ``--references``."""
    folder = Path(os.environ.get("FLOEFLOW_SHARED", PROJECT.parent / "shared"))
    if not folder.is_dir():
        said = f"{NO_DATA} at {folder} (FLOEFLOW_SHARED names another folder)"
        (pytest.fail if pytestconfig.getoption("--references") else pytest.skip)(said)
    return folder


def pytest_runtest_setup() -> None:
    """Let each test run on all processors: MPI in this process binds it where ranks are bound."""
    os.sched_setaffinity(0, PROCESSORS)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--figures", action="store_true", help="draw the figures in docs/images")
    parser.addoption(
        "--references", action="store_true", help="fail where reference data are absent"
    )
    parser.addoption(
        "--beside",
        metavar="FOLDER",
        type=Path,
        help="run the modules that no other process with this folder has taken",
    )
    parser.addoption(
        "--backwards", action="store_true", help="with --beside: begin with the last module"
    )


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
