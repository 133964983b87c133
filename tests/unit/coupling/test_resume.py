# SPDX-License-Identifier: GPL-2.0-or-later
"""A window's work is trusted only if it was made from the same."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from floeflow.core.errors import FloeError
from floeflow.core.file_hash import file_hash
from floeflow.coupling import resume
from floeflow.coupling.chunk import Chunk, publish
from floeflow.scene import Scene, parse_scene
from floeflow.state import read_dataset, read_state, write_dataset, write_state
from floeflow.state.snapshots import join_snapshots, read_snapshots
from unit.state.test_state import a_state

FIXED = {"dynamics": "a", "forcing": "b", "plugin": "c", "library": "d", "ranks": "2"}
WINDOWS = ("0001", "0002", "0003")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A scene's folder with state 0."""
    write_state(a_state(), tmp_path / "state/0000.nc")
    return tmp_path


def hashes(folder: Path, fixed: dict[str, str] = FIXED) -> list[str]:
    """What the windows of a chunk must have been made from."""
    start = read_state(folder / "state/0000.nc").attrs["checksum"]
    return resume.window_hashes(start, WINDOWS, fixed)


def finish(folder: Path, count: int) -> None:
    """Leave what so many finished windows leave."""
    for window, made_from in list(zip(WINDOWS, hashes(folder), strict=True))[:count]:
        work, number = resume.work_folder(folder, window), int(window)
        state = a_state()
        state["x"].values[0] += number
        state.attrs |= {"window": number, "provenance": json.dumps({"window": made_from})}
        write_state(state, work / resume.STATE)
        kept = join_snapshots([read_state(work / resume.STATE)])
        series = xr.Dataset({"time": ("sample", np.array([0.0, 1.0])), "ice_area_end": 1.0})
        for data, name in ((kept, resume.ELEMENTS), (series, resume.SERIES)):
            data.attrs |= {resume.MADE_FROM: made_from, "window": number}
            write_dataset(data, work / name)
        record = {"name": "dynamics", "n": 4, "ranks": 2, "seconds": [0.5]}
        (work / resume.COST).write_text(json.dumps([record]))


def done(folder: Path, fixed: dict[str, str] = FIXED) -> int:
    """Number of windows that need not be made again."""
    return resume.finished_windows(folder, WINDOWS, hashes(folder, fixed))


def test_a_job_goes_on_where_the_last_one_ended(folder: Path):
    for count in range(4):
        finish(folder, count)
        assert done(folder) == count


@pytest.mark.parametrize("key", list(FIXED))
def test_what_was_made_from_something_else_is_made_again(folder: Path, key: str):
    finish(folder, 1)
    assert done(folder) == 1
    assert done(folder, FIXED | {key: "other"}) == 0


@pytest.mark.parametrize("what", ["start", "state", "series", "elements", "cost"])
def test_what_is_damaged_or_gone_is_made_again(folder: Path, what: str):
    finish(folder, 1)
    work = resume.work_folder(folder, "0001")
    if what == "start":
        other = a_state()
        other["y"].values[0] = 0.25
        write_state(other, folder / "state/0000.nc")
    elif what == "state":
        raw = bytearray((work / resume.STATE).read_bytes())
        raw[len(raw) // 2] ^= 255
        (work / resume.STATE).write_bytes(raw)
    else:
        names = {"series": resume.SERIES, "elements": resume.ELEMENTS, "cost": resume.COST}
        (work / names[what]).unlink()
    assert done(folder) == 0


def test_a_window_in_the_middle_that_is_gone_ends_what_counts(folder: Path):
    finish(folder, 3)
    (resume.work_folder(folder, "0002") / resume.SERIES).unlink()
    assert done(folder) == 1


def test_states_that_were_dropped_do_not_keep_a_chunk_from_going_on(folder: Path):
    """With `state.keep: chunks` the last states are enough."""
    finish(folder, 3)
    resume.drop_old_states(folder, WINDOWS)
    there = [(resume.work_folder(folder, window) / resume.STATE).is_file() for window in WINDOWS]
    assert there == [False, True, True]
    assert done(folder) == 3
    # The last is damaged: the one before is gone on from.
    (resume.work_folder(folder, "0003") / resume.STATE).write_bytes(b"no NetCDF")
    assert done(folder) == 2
    (resume.work_folder(folder, "0002") / resume.STATE).unlink()
    assert done(folder) == 0


def test_where_all_states_are_wanted_those_dropped_are_made_again(folder: Path):
    finish(folder, 3)
    assert resume.finished_windows(folder, WINDOWS, hashes(folder), every_state=True) == 3
    (resume.work_folder(folder, "0002") / resume.STATE).unlink()
    assert resume.finished_windows(folder, WINDOWS, hashes(folder), every_state=True) == 1
    assert done(folder) == 3


def test_a_longer_chunk_wants_its_first_windows_made_from_the_same():
    """So that a run that is extended takes what a shorter last chunk made."""
    short = resume.window_hashes("start", WINDOWS[:2], FIXED)
    assert resume.window_hashes("start", WINDOWS, FIXED)[:2] == short
    assert len({*short, *resume.window_hashes("other", WINDOWS, FIXED)}) == 5


def chunk(folder: Path, keep: str) -> Chunk:
    scene: Scene = parse_scene(f"state: {{keep: {keep}}}".encode(), "a")
    return Chunk(scene, folder, WINDOWS, folder / "state/0000.nc", folder / "no plugin", 2)


@pytest.mark.parametrize("keep", ["chunks", "all"])
def test_what_a_chunk_made_is_published_under_its_last_window(folder: Path, keep: str):
    finish(folder, 3)
    publish(chunk(folder, keep))
    states = sorted(path.name for path in (folder / "state").glob("*.nc"))
    inner = ["0001.nc", "0002.nc"] if keep == "all" else []
    assert states == ["0000.nc", *inner, "0003.nc"]
    last = read_state(folder / "state/0003.nc").attrs["checksum"]
    snapshots = list(read_snapshots([folder / "elements/0003.nc"]))
    assert [part.attrs["window"] for part in snapshots] == [1, 2, 3]
    assert snapshots[-1].attrs["checksum"] == last
    series = read_dataset(folder / "series/0003.nc")
    assert series["window"].values.tolist() == [1, 2, 3]
    assert series["sample_window"].values.tolist() == [1, 1, 2, 2, 3, 3]
    costs = json.loads((folder / "cost/0003.json").read_text())
    assert [record["window"] for record in costs] == [1, 2, 3]
    # Snakemake may take the published file away; the work stays.
    (folder / "state/0003.nc").unlink()
    assert done(folder) == 3


def test_a_window_that_is_missing_is_not_published(folder: Path):
    finish(folder, 2)
    with pytest.raises(FloeError, match=r"0003/series\.nc: there is no such file"):
        publish(chunk(folder, "chunks"))
    assert not (folder / "state/0003.nc").exists()


def test_a_missing_plugin_is_named(tmp_path: Path):
    with pytest.raises(FloeError, match=r"libfloe\.so: cannot be read: No such file"):
        file_hash(tmp_path / "libfloe.so")
