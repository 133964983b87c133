# SPDX-License-Identifier: GPL-2.0-or-later
"""Results copied, swapped or old, files that change during a run: one sentence each."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import time
from pathlib import Path
from typing import Any

import pytest
import yaml

from floeflow.analysis import reading_process
from floeflow.core.errors import FloeError
from floeflow.coupling.chunk import Chunk, run_chunk
from floeflow.coupling.origin import provenance, window_keys
from floeflow.scene import Scene, parse_scene
from floeflow.state import write_dataset
from floeflow.workflow import input_guard
from floeflow.workflow.clock import check_clock
from floeflow.workflow.foreign_results import check_results
from floeflow.workflow.library import check_made_with, library_digest, made_with
from unit.state.test_state import a_state

HERE = Path(__file__).parent
TABLE = yaml.safe_load((HERE / "results.yaml").read_text())
STATE = Path("results/mine/state/0001.nc")


@pytest.fixture
def scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Scene:
    """A scene, in a folder where nothing has run."""
    monkeypatch.chdir(tmp_path)
    return parse_scene(b"name: mine\neffects: [wind]\n", "mine")


def leave_state(scene: Scene, case: dict[str, Any]) -> None:
    """The state of the scene's first window, with the changes of a case."""
    made = json.loads(provenance(scene)) | window_keys(scene)
    made |= {"library": library_digest("windows")} | case.get("provenance", {})
    state = a_state()
    state.attrs |= {"scene": scene.name, "window": 1, "provenance": json.dumps(made)}
    state.attrs |= case.get("state", {})
    write_dataset(state, STATE)


@pytest.mark.parametrize("case", TABLE, ids=[case["says"] for case in TABLE])
def test_results_of_another_scene_are_refused(scene: Scene, case: dict[str, Any]):
    leave_state(scene, case)
    with pytest.raises(FloeError) as refusal:
        check_results(scene, STATE.parents[1], ["0001"])
    assert str(STATE) in str(refusal.value) and case["says"] in str(refusal.value)


def test_own_results_are_taken_without_a_record(scene: Scene):
    leave_state(scene, {})
    check_results(scene, STATE.parents[1], ["0000", "0001"])


def test_a_window_starts_from_no_other_scene_s_state(scene: Scene):
    leave_state(scene, {"state": {"scene": "other"}})
    Path("plugin").touch()
    chunk = Chunk(scene, STATE.parents[1], ("0002",), STATE, Path("plugin"), 1)
    with pytest.raises(FloeError, match="is a state of the scene 'other'"):
        run_chunk(chunk)


def test_a_plugin_that_changes_during_a_run_is_told(tmp_path: Path):
    plugin = tmp_path / "libfloe.so"
    plugin.write_bytes(b"one")
    began = made_with(plugin)
    check_made_with(plugin, began)
    plugin.write_bytes(b"two")
    with pytest.raises(FloeError, match="libfloe.so has changed since this run began"):
        check_made_with(plugin, began)
    with pytest.raises(FloeError, match="the code of floeflow has changed"):
        check_made_with(plugin, f"{made_with(plugin).partition('-')[0]}-older")


def test_a_file_with_a_loop_in_it_is_read_for_a_while_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """`loop.nc` is a good file with some bytes changed; the HDF5 library reads it for ever."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(reading_process, "LEAST_SECONDS", 6)
    shutil.copy(HERE / "loop.nc", "loop.nc")
    mine = parse_scene(b"effects: [wind]\nmask: {file: loop.nc, land: none}\n", "a")
    with pytest.raises(FloeError, match=r"loop.nc or the forcing took more than 7 s"):
        input_guard.check_inputs(mine, set(), remember=False)


def test_a_pipe_is_no_mask(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe.nc")
    mine = parse_scene(b"effects: [wind]\nmask: {file: pipe.nc, land: none}\n", "a")
    with pytest.raises(FloeError, match="pipe.nc: is no file, but a pipe or a device"):
        input_guard.check_inputs(mine, set(), remember=False)


def test_results_of_tomorrow_are_refused_until_they_have_a_time_of_today(scene: Scene):
    """Snakemake would remove what windows made, as older than the state they began with."""
    leave_state(scene, {})
    folder = STATE.parents[1]
    check_clock(folder)
    tomorrow = time.time() + 86400.0
    os.utime(STATE, (tomorrow, tomorrow))
    with pytest.raises(FloeError, match="0001.nc: is newer than the clock") as refusal:
        check_clock(folder)
    subprocess.run(["bash", "-c", str(refusal.value).partition(" with ")[2]], check=True)
    check_clock(folder)
    check_results(scene, folder, ["0001"])
