# SPDX-License-Identifier: GPL-2.0-or-later
"""A window's work is trusted only if it was made from the same."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from floeflow.core.errors import FloeError
from floeflow.coupling import resume
from floeflow.state import read_state, write_dataset, write_state
from unit.state.test_state import a_state

FIXED = {"dynamics": "a", "plugin": "b", "ranks": "2"}


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    """A scene's folder with state 0 and the forcing of three windows."""
    write_state(a_state(), tmp_path / "state/0000.nc")
    for window in (1, 2, 3):
        data = xr.Dataset({"wind_u": ("time", np.arange(3.0) + window)})
        write_dataset(data, tmp_path / f"forcing/{window:04d}.nc")
    return tmp_path


def finish(scene: Path, previous: xr.Dataset, window: str, fixed: dict[str, str]) -> xr.Dataset:
    """Leave what a finished window leaves."""
    work = resume.work_folder(scene, window)
    forcing = resume.read_dataset(scene / f"forcing/{window}.nc")
    state = previous.copy(deep=True)
    state["x"].values[0] += 1.0
    made_from = resume.window_hash(previous, forcing, fixed)
    state.attrs |= {"window": int(window), "provenance": json.dumps({"window": made_from})}
    write_dataset(xr.Dataset({"time": 0.0}), work / "series.nc")
    (work / "cost.json").write_text("[]")
    write_state(state, work / "state.nc")
    return read_state(work / "state.nc")


def ask(scene: Path, fixed: dict[str, str] = FIXED) -> list[str]:
    """Windows left to do."""
    windows = ["0001", "0002", "0003"]
    forcing = [str(scene / f"forcing/{w}.nc") for w in windows]
    start = read_state(scene / "state/0000.nc")
    _, todo, paths = resume.resume(start, windows, forcing, scene, fixed)
    assert len(todo) == len(paths)
    return todo


def test_a_job_goes_on_where_the_last_one_ended(scene: Path):
    assert ask(scene) == ["0001", "0002", "0003"]
    first = finish(scene, read_state(scene / "state/0000.nc"), "0001", FIXED)
    assert ask(scene) == ["0002", "0003"]
    second = finish(scene, first, "0002", FIXED)
    finish(scene, second, "0003", FIXED)
    assert ask(scene) == []


@pytest.mark.parametrize("what", ["key", "forcing", "state", "damage", "series"])
def test_what_was_made_from_something_else_is_made_again(scene: Path, what: str):
    finish(scene, read_state(scene / "state/0000.nc"), "0001", FIXED)
    fixed = FIXED
    work = resume.work_folder(scene, "0001")
    if what == "key":
        fixed = FIXED | {"dynamics": "c"}
    if what == "forcing":
        write_dataset(xr.Dataset({"wind_u": ("time", np.zeros(3))}), scene / "forcing/0001.nc")
    if what == "state":
        other = a_state()
        other["y"].values[0] = 0.25
        write_state(other, scene / "state/0000.nc")
    if what == "damage":
        raw = bytearray((work / "state.nc").read_bytes())
        raw[len(raw) // 2] ^= 255
        (work / "state.nc").write_bytes(raw)
    if what == "series":
        (work / "series.nc").unlink()
    assert ask(scene, fixed) == ["0001", "0002", "0003"]


def test_published_files_are_the_work_s_own(scene: Path):
    state = finish(scene, read_state(scene / "state/0000.nc"), "0001", FIXED)
    resume.publish(scene, ["0001"])
    assert read_state(scene / "state/0001.nc").attrs["checksum"] == state.attrs["checksum"]
    assert (scene / "series/0001.nc").is_file() and (scene / "cost/0001.json").is_file()
    # Snakemake may take the published file away; the work stays.
    (scene / "state/0001.nc").unlink()
    assert ask(scene) == ["0002", "0003"]
    with pytest.raises(FloeError, match=r"0002\.nc: cannot be written"):
        resume.publish(scene, ["0002"])


def test_a_missing_plugin_is_named(tmp_path: Path):
    with pytest.raises(FloeError, match=r"libfloe\.so: cannot be read: No such file"):
        resume.file_hash(tmp_path / "libfloe.so")
