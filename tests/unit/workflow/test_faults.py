# SPDX-License-Identifier: GPL-2.0-or-later
"""What a job could not do is said once, last, and with its log."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

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
from floeflow.workflow.faults import say_last
say_last(["one", "two"])
print("what Snakemake says")
"""


def test_a_job_leaves_its_sentence_and_prints_none(tmp_path: Path):
    (tmp_path / "results/x").mkdir(parents=True)
    (tmp_path / "results/x/.run").write_text("")
    done = subprocess.run(
        [sys.executable, "-c", JOB], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (1, "", "")
    told = take_faults(tmp_path / "results", 0.0)
    assert told == ["mask.nc: there is no such file (log: x.log)"]
    assert not list(tmp_path.rglob(FAULT))
    assert "there is no such file" in (tmp_path / "x.log").read_text()


def test_faults_of_earlier_runs_are_not_told(tmp_path: Path):
    leave_fault(tmp_path / "a", "old", Path("a.log"))
    os.utime(tmp_path / "a" / FAULT, (1.0, 1.0))
    leave_fault(tmp_path / "b", "new", Path("b.log"))
    (tmp_path / "c").mkdir()
    (tmp_path / "c" / FAULT).write_text("no JSON")
    assert take_faults(tmp_path, 2.0) == ["new (log: b.log)"]


def test_what_cannot_be_left_is_known_to_be_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    def full(*_: object) -> None:
        raise OSError(28, "no room")

    monkeypatch.setattr("floeflow.workflow.faults.write_text", full)
    assert not leave_fault(tmp_path, "x", Path("x.log"))


def test_sentences_come_last_in_their_order():
    done = subprocess.run([sys.executable, "-c", END], capture_output=True, text=True, check=True)
    assert done.stdout == "what Snakemake says\n"
    assert done.stderr == "floeflow: one\nfloeflow: two\n"
