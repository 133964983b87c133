# SPDX-License-Identifier: GPL-2.0-or-later
"""Ridging on one and on two ranks: the same ridges, counted once, and continued anywhere."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from floeflow.mpi import mpi_environment

pytestmark = pytest.mark.mpi

Result = dict[str, np.ndarray]


def run(folder: Path, ranks: int, start: Path | None = None) -> tuple[Result, Result]:
    folder.mkdir(parents=True, exist_ok=True)
    script = Path(__file__).with_name("ridging_ranks.py")
    command = ["mpirun", "-n", str(ranks), sys.executable, str(script), str(folder)]
    done = subprocess.run(
        command + ([str(start)] if start else []),
        env=mpi_environment(),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    parts = []
    for part in ("first", "second"):
        with np.load(folder / f"{part}.npz") as data:
            parts.append({name: data[name] for name in data.files})
    return parts[0], parts[1]


@pytest.fixture(scope="module")
def ranks(tmp_path_factory: pytest.TempPathFactory) -> dict[int, tuple[Result, Result]]:
    folder = tmp_path_factory.mktemp("ranks")
    return {n: run(folder / str(n), n) for n in (1, 2)}


def assert_same_ice(one: Result, two: Result) -> None:
    for name in one:
        if "id" in name.split(".")[1].split("_"):
            np.testing.assert_array_equal(two[name], one[name], name)
    for name in ("element.x", "element.y"):
        np.testing.assert_allclose(two[name], one[name], rtol=0, atol=1e-9 * np.ptp(one[name]))
    for name in ("element.ridged_area", "contact.ridge_closing", "contact.ridge_thickness"):
        np.testing.assert_allclose(two[name], one[name], rtol=0, atol=1e-6 * one[name].max())


def test_one_and_two_ranks_build_the_same_ridges(
    ranks: dict[int, tuple[Result, Result]],
) -> None:
    for one, two in zip(ranks[1], ranks[2], strict=True):
        assert (one["contact.ridge_closing"] > 0).sum() > 30
        assert_same_ice(one, two)
        # Each ridge across the ranks is counted once.
        for name in ("dissipation_ridging", "dissipation_friction", "elastic_contact"):
            assert two[f"sum.{name}"] == pytest.approx(one[f"sum.{name}"], rel=1e-6)
        closed = two["contact.ridge_closing"] @ two["contact.ridge_length"]
        assert two["element.ridged_area"].sum() == pytest.approx(closed, rel=1e-9)
    assert ranks[1][1]["sum.bonds_broken"] > 0


def test_a_state_in_the_midst_of_ridging_goes_on_with_another_number_of_ranks(
    ranks: dict[int, tuple[Result, Result]], tmp_path: Path
) -> None:
    state = tmp_path / "state.npz"
    np.savez(state, **ranks[1][0])
    assert_same_ice(ranks[1][1], run(tmp_path, 2, state)[0])
