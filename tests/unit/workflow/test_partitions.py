# SPDX-License-Identifier: GPL-2.0-or-later
"""Time limits of partitions, as sinfo says them, and a job that would ask for more."""

from __future__ import annotations

from pathlib import Path

import pytest

from floeflow.workflow.partitions import longest, minutes, partition_minutes, within

TABLE = "short* 1:00:00\nlong 7-00:00:00\ntest 30:00\nfree infinite\n"


@pytest.mark.parametrize(
    ("limit", "expected"),
    [("1:00:00", 60), ("7-00:00:00", 10080), ("30:00", 30), ("infinite", None), ("n/a", None)],
)
def test_limits_are_minutes(limit: str, expected: int | None):
    assert minutes(limit) == expected


@pytest.mark.parametrize(
    ("partition", "expected"),
    [("", 60), ("long", 10080), ("test", 30), ("free", None), ("none", None)],
)
def test_the_partition_that_jobs_go_to_sets_the_limit(partition: str, expected: int | None):
    assert longest(TABLE, partition) == expected


def test_a_partition_is_named_on_the_command_line_or_in_the_environment(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    sinfo = tmp_path / "sinfo"
    sinfo.write_text(f"#!/bin/sh\nprintf '{TABLE.replace(chr(10), chr(92) + 'n')}'\n")
    sinfo.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:/bin:/usr/bin")
    monkeypatch.delenv("SBATCH_PARTITION", raising=False)
    assert partition_minutes() == 60
    assert partition_minutes(["--default-resources", "slurm_partition=long"]) == 10080
    monkeypatch.setenv("SBATCH_PARTITION", "test")
    assert partition_minutes() == 30
    monkeypatch.setenv("PATH", str(tmp_path / "none"))
    assert partition_minutes() is None


def test_a_job_that_would_wait_for_ever_asks_for_less_and_says_so(capsys):
    assert within(50, 60, "windows") == 50 and within(50, None, "windows") == 50
    assert not capsys.readouterr().err
    assert within(240, 60, "windows") == 60
    said = capsys.readouterr().err
    assert "windows would ask for 240 minutes, and the partition allows 60" in said
