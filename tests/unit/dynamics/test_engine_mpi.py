# SPDX-License-Identifier: GPL-2.0-or-later
"""The engine on one and on two ranks: the same ice."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from floeflow.state.bonds import Arrays
from support.ranks import run_parts

pytestmark = pytest.mark.mpi


def run(
    folder: Path, ranks: int, *start: Path, steps: int = 500, kind: str = "raft"
) -> tuple[Arrays, Arrays]:
    return run_parts("engine_ranks.py", folder, ranks, steps, kind, *start)


@pytest.fixture(scope="module")
def ranks(tmp_path_factory: pytest.TempPathFactory) -> dict[int, tuple[Arrays, Arrays]]:
    folder = tmp_path_factory.mktemp("ranks")
    return {n: run(folder / str(n), n) for n in (1, 2, 4)}


@pytest.mark.parametrize("more", [2, 4])
def test_one_and_more_ranks_agree_over_the_first_1000_steps(
    ranks: dict[int, tuple[Arrays, Arrays]], more: int
) -> None:
    assert 0 < ranks[1][0]["sum.bonds_broken"]
    one, two = ranks[1][1], ranks[more][1]  # after the second part, loaded anew
    assert 0 < one["sum.bonds"]
    assert ((one["bond.crack_a"] > 0) | (one["bond.crack_b"] > 0)).any()
    for name in ("bond.id_lo", "bond.id_hi", "contact.id_lo", "contact.id_hi"):
        np.testing.assert_array_equal(one[name], two[name])
    for name in ("bond.crack_a", "bond.crack_b"):
        np.testing.assert_allclose(one[name], two[name], atol=1e-9)
    for name in ("element.x", "element.y"):
        scale = np.ptp(one[name])
        np.testing.assert_allclose(two[name], one[name], rtol=0, atol=1e-9 * scale)


def test_sums_agree_and_each_pair_is_counted_once(ranks: dict[int, tuple[Arrays, Arrays]]) -> None:
    one, two = ranks[1][0], ranks[2][0]
    for name in one:
        if name.startswith("sum."):
            scale = abs(float(one["sum.work_wind"])) if "work" in name else 1.0
            np.testing.assert_allclose(two[name], one[name], rtol=1e-6, atol=1e-6 * scale)
    for name in ("bonds", "contacts", "bonds_broken", "bonds_cracked", "elements"):
        assert two[f"sum.{name}"] == one[f"sum.{name}"]


def test_two_ranks_repeat_themselves_to_the_bit(
    ranks: dict[int, tuple[Arrays, Arrays]], tmp_path: Path
) -> None:
    again = run(tmp_path, 2)
    for a, b in zip(ranks[2], again, strict=True):
        for name in a:
            np.testing.assert_array_equal(a[name], b[name], err_msg=name)


def test_a_state_goes_on_with_another_number_of_ranks(
    ranks: dict[int, tuple[Arrays, Arrays]], tmp_path: Path
) -> None:
    state = tmp_path / "state.npz"
    np.savez(state, **ranks[1][0])
    moved = run(tmp_path, 2, state)[0]  # its first part continues from the state
    kept = ranks[1][1]
    np.testing.assert_array_equal(moved["bond.id_hi"], kept["bond.id_hi"])
    for name in ("element.x", "element.y"):
        scale = np.ptp(kept[name])
        np.testing.assert_allclose(moved[name], kept[name], rtol=0, atol=1e-9 * scale)


def test_elements_that_drift_from_rank_to_rank_keep_all_that_they_have(tmp_path: Path) -> None:
    """Runs go on without set-up, lists are made anew in their midst, elements change hands."""
    (one, _), (two, _) = (run(tmp_path / str(n), n, steps=2000, kind="adrift") for n in (1, 2))
    assert (one["element.x"] > 16_000.0).all()
    for name in ("element.id", "element.thickness", "element.mass"):
        np.testing.assert_array_equal(one[name], two[name])
    for name in ("element.x", "element.u", "element.theta"):
        scale = np.ptp(one[name])
        np.testing.assert_allclose(two[name], one[name], rtol=0, atol=1e-9 * scale)


def test_more_ranks_than_elements_give_what_one_gives(tmp_path: Path) -> None:
    """Three bonded elements at a wall: most ranks have none, and are asked for sums and tables."""
    (one, first), (seven, second) = (
        run(tmp_path / str(n), n, steps=200, kind="few") for n in (1, 7)
    )
    assert one["sum.elements"] == seven["sum.elements"] == 3
    assert one["sum.bonds"] == 2 and len(one["wall.id"]) > 0
    for a, b in ((one, seven), (first, second)):
        assert set(a) == set(b)
        for name in ("element.id", "bond.id_lo", "bond.id_hi", "wall.id", "sum.bonds"):
            np.testing.assert_array_equal(b[name], a[name], err_msg=name)
        for name in ("element.x", "element.u", "element.theta", "sum.work_wind", "bond.span"):
            scale = np.abs(a[name]).max()
            np.testing.assert_allclose(b[name], a[name], rtol=0, atol=1e-9 * scale, err_msg=name)


def test_a_pack_in_a_corner_of_its_box_is_cut_among_the_ranks(tmp_path: Path) -> None:
    (one, _), (four, _) = (run(tmp_path / str(n), n, steps=200, kind="lopsided") for n in (1, 4))
    assert 0 < one["sum.bonds"]
    for name in ("bond.id_lo", "bond.id_hi", "element.id"):
        np.testing.assert_array_equal(one[name], four[name])
    for name in ("element.x", "element.y"):
        np.testing.assert_allclose(four[name], one[name], rtol=0, atol=1e-9 * np.ptp(one[name]))
    log = (tmp_path / "4/log.4").read_text()
    assert "4 by 1 by 1 MPI processor grid" in log or "2 by 2 by 1 MPI processor grid" in log


def test_walls_and_ridges_on_other_numbers_of_ranks(tmp_path: Path) -> None:
    """Moving walls that crack and ridge the raft, cut in the midst and continued elsewhere."""
    runs = {n: run(tmp_path / str(n), n, steps=200, kind="walls") for n in (1, 2, 4)}
    first, second = runs[1]
    # All three walls are touched; the first line of the bent one speaks for its corner.
    assert set(first["wall.face"]) == {0, 1, 2}
    assert (first["wall.ridge_closing"] > 0).any() and (first["contact.ridge_closing"] > 0).any()
    assert first["sum.bonds_broken"] > 10 and first["sum.elastic_wall"] > 0
    state = tmp_path / "state.npz"
    np.savez(state, **first)
    moved = run(tmp_path / "moved", 4, state, steps=200, kind="walls")[0]
    for one, other in ((first, runs[2][0]), (first, runs[4][0]), (second, moved)):
        for name in ("bond.id_lo", "bond.id_hi", "contact.id_hi", "wall.id", "wall.face"):
            np.testing.assert_array_equal(other[name], one[name], err_msg=name)
        for name, size in (
            *((f"element.{k}", 4e4) for k in ("x", "y")),
            *((f"wall.{k}", 1e3) for k in ("slip", "rest_overlap", "ridge_closing")),
            *((f"contact.{k}", 1e3) for k in ("slip", "rest_overlap", "ridge_closing")),
            *((f"sum.{k}", 1e10) for k in ("elastic_wall", "work_wall", "impulse_wall_x")),
        ):
            np.testing.assert_allclose(
                other[name], one[name], rtol=1e-9, atol=1e-9 * size, err_msg=name
            )
