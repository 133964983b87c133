# SPDX-License-Identifier: GPL-2.0-or-later
"""What all tests share: a derandomised hypothesis, the project's folder, the reference data."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import settings

PROJECT = Path(__file__).resolve().parents[1]

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
