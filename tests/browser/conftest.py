# SPDX-License-Identifier: GPL-2.0-or-later
"""A browser without a window, and a report for it to open.

`make test-browser` keeps its screenshots in ``results/browser``.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, sync_playwright

from support.pages import report_of
from support.synthetic import make_run


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """Chromium of the distribution."""
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    if program is None:
        pytest.fail("chromium is missing: `make test-browser` installs it (apt: chromium)")
    # Chromium's sandbox does not run as root; the page is our own.
    arguments = ["--no-sandbox"] if os.geteuid() == 0 else []
    with sync_playwright() as play:
        found = play.chromium.launch(executable_path=program, args=arguments)
        yield found
        found.close()


@pytest.fixture(scope="session")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The report of a small synthetic run."""
    run = make_run(tmp_path_factory.mktemp("browser"))
    report_of(run)
    return run.folder / "report.html"


@pytest.fixture(scope="session")
def screenshots(project: Path) -> Path:
    """Folder of the pictures that a person looks at."""
    folder = project / "results/browser"
    folder.mkdir(parents=True, exist_ok=True)
    return folder
