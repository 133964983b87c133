# SPDX-License-Identifier: GPL-2.0-or-later
"""What a job could not do is said once, last, and with its log."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from floeflow.core.lock import RUN_VARIABLE
from floeflow.workflow.faults import FAULT, leave_fault, take_faults

JOB = """
import sys
from types import SimpleNamespace
from floeflow.core.errors import FloeError
from floeflow.workflow.job import run_script

def main(job):
    raise FloeError("mask.nc: there is no such file")

names = SimpleNamespace(scene="x")
job = SimpleNamespace(wildcards=names, log=["x.log"], output=["x.nc"], rule="r")
run_script(main, job)
"""
END = """
from floeflow.core.lock import RUN_VARIABLE
from floeflow.workflow.faults import say_last
say_last(["one", "two"])
print("what Snakemake says")
"""


def test_a_job_leaves_its_sentence_and_prints_none(tmp_path: Path):
    (tmp_path / "results/x").mkdir(parents=True)
    (tmp_path / "results/x/.run").write_text("")
    done = subprocess.run(
        [sys.executable, "-c", JOB],
        cwd=tmp_path,
        env=os.environ | {RUN_VARIABLE: "mine"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout, done.stderr) == (1, "", "")
    told = take_faults(tmp_path / "results", "mine")
    assert told == ["mask.nc: there is no such file (log: x.log)"]
    assert not list(tmp_path.rglob(FAULT))
    assert "there is no such file" in (tmp_path / "x.log").read_text()


def test_faults_of_earlier_runs_are_not_told_whatever_the_clock_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    now = time.time()
    for folder, run, age in (("a", "old", -1e5), ("b", "new", 1e5), ("d", "new", -1e5)):
        monkeypatch.setenv(RUN_VARIABLE, run)
        assert leave_fault(tmp_path / folder, f"of {folder}", Path(f"{folder}.log"))
        os.utime(tmp_path / folder / FAULT, (now - age, now - age))
    (tmp_path / "c").mkdir()
    (tmp_path / "c" / FAULT).write_text("no JSON")
    assert take_faults(tmp_path, "new") == ["of b (log: b.log)", "of d (log: d.log)"]
    # It may be that of a run of another scene that has not ended yet.
    assert (tmp_path / "a" / FAULT).exists() and not (tmp_path / "b" / FAULT).exists()


def test_what_cannot_be_left_is_known_to_be_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    def full(*_: object) -> None:
        raise OSError(28, "no room")

    monkeypatch.setattr("floeflow.workflow.faults.write_text", full)
    assert not leave_fault(tmp_path, "x", Path("x.log"))


def test_sentences_come_last_in_their_order():
    done = subprocess.run([sys.executable, "-c", END], capture_output=True, text=True, check=True)
    assert done.stdout == "what Snakemake says\n"
    assert done.stderr == "floeflow: one\nfloeflow: two\n"
