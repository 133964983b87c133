# SPDX-License-Identifier: GPL-2.0-or-later
"""Ranks that do not start, and numbers of ranks that a machine does not have."""

from __future__ import annotations

import os
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import yaml

from floeflow.core.errors import FloeError
from floeflow.core.plugin import plugin_path
from floeflow.coupling.chunk import Chunk, run_chunk
from floeflow.coupling.initial import make_state
from floeflow.coupling.job import Job
from floeflow.coupling.launch import run_ranks
from floeflow.scene import parse_scene
from floeflow.state import read_state, write_state
from floeflow.workflow.ranks import check_ranks, ranks_sentence
from unit.coupling.test_walls import a_packing

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


FEW = b"""
effects: [wind, ocean_drag, coriolis, tilt, friction, ridging, thermodynamics, snow]
domain: {x_min: 0.0, x_max: 4.0e4, y_min: 0.0, y_max: 4.0e4, spacing: 1.0e4}
time: {windows: 2, window: 3600.0}
forcing: {step: 3600.0, cyclone: {x: -4.0e5, y: 2.0e4, u: 0.0, v: 0.0, wind_speed: 20.0}}
dynamics: {samples: 2, deterministic: true}
"""


@pytest.mark.mpi
def test_windows_of_three_elements_on_more_ranks_have_the_same_bits(tmp_path: Path):
    """Dynamics and columns: ranks without an element take part in all that ranks do together."""
    scene = parse_scene(FEW, "few")
    packing = a_packing(2).isel(element=slice(0, 3), element_bound=slice(0, 4))
    first = make_state(scene, packing, None)
    ends = []
    for ranks in (1, 5):
        folder = tmp_path / str(ranks)
        (folder / "state").mkdir(parents=True)
        write_state(first, folder / "state/0000.nc")
        windows = ("0001", "0002")
        start = folder / "state/0000.nc"
        assert run_chunk(Chunk(scene, folder, windows, start, plugin_path(), ranks)) == 2
        ends.append(read_state(folder / "state/0002.nc"))
    one, five = ends
    assert one.sizes["element"] == 3 and set(one.variables) == set(five.variables)
    assert (np.hypot(one["u"], one["v"]) > 0.01).all()
    for name in one.variables:
        np.testing.assert_array_equal(five[name].values, one[name].values, err_msg=str(name))


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
