# SPDX-License-Identifier: GPL-2.0-or-later
"""A finished run that no stage made, for the tests of what is read from one."""

from __future__ import annotations

import pytest
import xarray as xr

from floeflow.state import read_state
from support.synthetic import Run, make_run


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    return make_run(tmp_path_factory.mktemp("run"))


@pytest.fixture(scope="module")
def states(run: Run) -> list[xr.Dataset]:
    """Its states, the first before all windows."""
    return [read_state(run.state(window)) for window in (0, *run.windows)]
