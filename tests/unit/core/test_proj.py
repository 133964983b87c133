# SPDX-License-Identifier: GPL-2.0-or-later
"""Projections work in a process that opened a NetCDF file before it asked for any."""

from __future__ import annotations

import subprocess
import sys

SCRIPT = """
import floeflow
import xarray as xr
xr.backends.list_engines()
from floeflow.core.grids import scene_crs
from floeflow.scene.blocks import Domain
print(scene_crs(Domain()).to_epsg())
"""


def test_engines_of_xarray_leave_projections_alone() -> None:
    done = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "6931"
