# SPDX-License-Identifier: GPL-2.0-or-later
"""Ranks that do not start, and numbers of ranks that a machine does not have."""

from __future__ import annotations

import os
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import yaml

from floeflow.core.errors import FloeError
from floeflow.coupling.job import Job
from floeflow.coupling.launch import run_ranks
from floeflow.scene import parse_scene
from floeflow.workflow.ranks import check_ranks, ranks_sentence

TABLE = yaml.safe_load(Path(__file__).with_name("ranks.yaml").read_text())


@pytest.mark.mpi
@pytest.mark.parametrize("case", TABLE, ids=[case["says"] for case in TABLE])
def test_settings_of_mpi_that_start_no_rank_are_told(
    case: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    scene = parse_scene(b"", "a").model_dump(mode="json")
    job = Job(scene, str(tmp_path / "none.nc"), ["0001"], 0, ["hash"], str(tmp_path), {})
    for name in [name for name in os.environ if name.startswith("OMPI_MCA_")]:
        monkeypatch.delenv(name)
    for name, value in case["environment"].items():
        monkeypatch.setenv(name, value)
    with pytest.raises(FloeError) as fault:
        # Of two ranks that fail at once mpirun may lose what both say.
        run_ranks(job, 1, tmp_path / "ranks.log")
    said = str(fault.value)
    words = [case["says"].format(host=os.uname().nodename), *case.get("lost", [])]
    assert any(each in said for each in words) and "\n" not in said
    ((name, value),) = case["environment"].items()
    assert f"set in the environment: {name}={value} (see {tmp_path}/ranks.log)" in said


def test_ranks_beyond_cores_or_processors_are_told(capsys: pytest.CaptureFixture[str]):
    assert ranks_sentence(2, 2, 2) == ranks_sentence(1, 8, 2) == ""
    assert "windows run on 2, with the bits of 2" in ranks_sentence(4, 2, 8)
    assert "4 ranks share 2 processors" in ranks_sentence(4, 4, 2)
    threads = SimpleNamespace(raw=4000)  # as Snakemake wraps a number of the command line
    check_ranks(SimpleNamespace(overwrite_threads={"windows": threads}, cores=2))
    assert capsys.readouterr().err.startswith("floeflow: warning: 4000 ranks are asked for")
    threads = SimpleNamespace(raw="2 * attempt")
    check_ranks(SimpleNamespace(overwrite_threads={"windows": threads}, cores=2))
    check_ranks(SimpleNamespace(overwrite_threads={}, cores=None))
    assert capsys.readouterr().err == ""
    with pytest.raises(FloeError, match="windows=0: a window needs at least one rank"):
        check_ranks(SimpleNamespace(overwrite_threads={"windows": 0}, cores=2))
