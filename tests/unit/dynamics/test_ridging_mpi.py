# SPDX-License-Identifier: GPL-2.0-or-later
"""Ridging on one and on two ranks: the same ridges, counted once, and continued anywhere."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from floeflow.state.bonds import Arrays
from support.ranks import run_parts

pytestmark = pytest.mark.mpi

SCRIPT = "ridging_ranks.py"


@pytest.fixture(scope="module")
def ranks(tmp_path_factory: pytest.TempPathFactory) -> dict[int, tuple[Arrays, Arrays]]:
    folder = tmp_path_factory.mktemp("ranks")
    return {n: run_parts(SCRIPT, folder / str(n), n) for n in (1, 2)}


def assert_same_ice(one: Arrays, two: Arrays) -> None:
    for name in one:
        if "id" in name.split(".")[1].split("_"):
            np.testing.assert_array_equal(two[name], one[name], name)
    for name in ("element.x", "element.y"):
        np.testing.assert_allclose(two[name], one[name], rtol=0, atol=1e-9 * np.ptp(one[name]))
    for name in ("element.ridged_area", "contact.ridge_closing", "contact.ridge_thickness"):
        np.testing.assert_allclose(two[name], one[name], rtol=0, atol=1e-6 * one[name].max())


def test_one_and_two_ranks_build_the_same_ridges(
    ranks: dict[int, tuple[Arrays, Arrays]],
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
    ranks: dict[int, tuple[Arrays, Arrays]], tmp_path: Path
) -> None:
    state = tmp_path / "state.npz"
    np.savez(state, **ranks[1][0])
    assert_same_ice(ranks[1][1], run_parts(SCRIPT, tmp_path, 2, state)[0])
