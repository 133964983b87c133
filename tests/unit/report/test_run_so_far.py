# SPDX-License-Identifier: GPL-2.0-or-later
"""A report of a run that stopped: published chunks, and finished windows of the next one."""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path

import pytest
import yaml

from floeflow.core.errors import FloeError
from floeflow.report.run_so_far import find_so_far, report_so_far
from floeflow.state import read_dataset, write_dataset
from floeflow.state.snapshots import read_snapshots, write_snapshots
from support.synthetic import ALL, Run, make_run


def stopped(folder: Path, published: bool = True) -> Run:
    """A run of three windows in chunks of two that stopped inside of its second chunk."""
    run = make_run(folder, (*ALL, "grid_output"))
    (run.folder / "scene.yaml").write_text(yaml.safe_dump(run.scene.model_dump(mode="json")))
    if not published:
        for kind in ("elements", "series", "cost", "state"):
            for path in (run.folder / kind).glob("0002.*"):
                path.unlink()
    kinds = ("elements/0003.nc", "series/0003.nc", "cost/0003.json", "state/0003.nc")
    work = run.folder / ".windows/0003"
    work.mkdir(parents=True)
    elements, series, cost, state = (run.folder / kind for kind in kinds)
    write_snapshots(list(read_snapshots([elements])), work / "elements.nc")
    data = read_dataset(series)
    one = data.isel(window=0, drop=True).drop_vars("sample_window")
    one.attrs = {"window": 3}
    write_dataset(one, work / "series.nc")
    records = [{k: v for k, v in r.items() if k != "window"} for r in json.loads(cost.read_text())]
    (work / "cost.json").write_text(json.dumps(records))
    shutil.move(state, work / "state.nc")
    for path in (elements, series, cost):
        path.unlink()
    return run


def test_it_counts_published_chunks_and_finished_windows(tmp_path: Path):
    run = stopped(tmp_path)
    found = find_so_far(run.folder)
    assert (found.chunks, found.windows) == (("0002",), ("0003",))
    before = sorted(run.folder.rglob("*"))
    said = report_so_far(run.folder)
    assert said == f"All 3 windows are done. Report: {run.folder / 'report_so_far.html'}"
    new = {
        path.relative_to(run.folder).parts[0] for path in set(run.folder.rglob("*")) - set(before)
    }
    assert new == {"report_so_far.html", "figures_so_far"}


def test_a_window_without_a_state_is_left_out(tmp_path: Path):
    run = stopped(tmp_path)
    (run.folder / ".windows/0003/state.nc").unlink()
    said = report_so_far(run.folder)
    assert said.startswith("This run has not ended: 2 of 3 windows are done.")
    page = (run.folder / "report_so_far.html").read_text(encoding="utf-8")
    assert '<p class="partial" role="status">This run has not ended: 2 of 3 windows' in page
    assert '"times":["31 Dec 1981 00:00","31 Dec 1981 12:00","01 Jan 1982 00:00"]' in page


def test_windows_of_an_earlier_run_do_not_count(tmp_path: Path):
    run = stopped(tmp_path)
    old = (run.folder / "state/0002.nc").stat().st_mtime - 10
    for path in (run.folder / ".windows/0003").iterdir():
        os.utime(path, (old, old))
    assert find_so_far(run.folder).windows == ()


def test_a_run_with_nothing_done_is_refused(tmp_path: Path):
    run = stopped(tmp_path, published=False)
    with pytest.raises(FloeError, match="no window is finished yet"):
        find_so_far(run.folder)
    with pytest.raises(FloeError, match="holds no run"):
        find_so_far(tmp_path)
