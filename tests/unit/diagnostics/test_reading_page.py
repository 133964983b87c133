# SPDX-License-Identifier: GPL-2.0-or-later
"""The page on reading results does what it says: its code runs on a run's files."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
import xarray as xr

from floeflow.coupling.growth import as_variables, growth_places
from floeflow.diagnostics.analyses import Analyses
from floeflow.diagnostics.cf_output import join_times, write_grid
from floeflow.diagnostics.diagnostics import analyse, diagnose
from floeflow.diagnostics.gridded import make_grid
from floeflow.diagnostics.gridded_tendencies import make_tendencies
from floeflow.diagnostics.mesh_series import write_meshes
from floeflow.diagnostics.surface_forces import forcing_at
from floeflow.diagnostics.trajectory import drift_statistics, make_frames, write_dump
from floeflow.diagnostics.zarr_output import write_zarr
from floeflow.state import read_dataset, read_state, write_dataset
from support.runner import PROJECT
from support.synthetic import Run, make_run

PAGE = PROJECT / "docs/how-to/read_results.md"


def grown(state: xr.Dataset) -> xr.Dataset:
    """A state with what its columns made in the window before."""
    area = state["area"].values[state["type"].values == 1]
    each = {"growth_base": 0.01 * area, "ice_area_grown": 0.0 * area}
    return state.assign(as_variables(growth_places(state, (each,), (), None)))


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Results of a run with everything that the page reads."""
    run: Run = make_run(tmp_path_factory.mktemp("read"))
    scene, folder = run.scene, run.folder
    states = [read_state(run.state(k)) for k in range(len(run.windows) + 1)]
    mask, packing = (read_dataset(folder / f"preprocess/{n}.nc") for n in ("mask", "packing"))
    grids = [make_grid(scene, s, mask, forcing_at(scene, float(s.attrs["time"]))) for s in states]
    write_grid(join_times(grids), folder / "grid.nc")
    analyses = Analyses(scene)
    data, _ = diagnose(run.files, scene.effects, scene.domain, analyses)
    write_dataset(data, folder / "diagnostics.nc")
    write_dataset(analyse(run.files, analyses), folder / "analyses.nc")
    frames = make_frames(states)
    write_dump(frames, scene.domain, folder / "trajectory/elements.lammpsdump")
    write_dataset(drift_statistics(frames), folder / "trajectory/drift.nc")
    write_meshes(packing, states, folder / "mesh")
    write_zarr(folder / "grid.nc", folder / "grid.zarr")
    tendencies = make_tendencies(scene, folder / "grid.nc", mask, [grown(s) for s in states[1:]])
    write_grid(tendencies, folder / "tendencies.nc")
    return folder


def run_code(code: str, folder: Path) -> str:
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", code],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_page_runs_as_it_stands(results: Path):
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.S)
    assert len(blocks) == 9
    # GDAL stands alone, as the page says.
    *first, gdal = blocks
    said = run_code("\n".join(first), results)
    assert "sidmassdyn" in said and "million tonnes a day" in said
    assert "of ice," in said and "% of the wind" in said and "bonds hold" in said
    assert "cells, area, ice_fraction" in said.replace("id, ", "")
    said = run_code(gdal, results)
    assert "4 times, 8 x 8 cells" in said and "% at most" in said
    assert "PROJ" in said or "EPSG" in said
