# SPDX-License-Identifier: GPL-2.0-or-later
"""The scaling benchmark: what it counts over ranks, and the model that it draws."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest


@pytest.fixture
def scaling(project: Path, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(str(project / "benchmarks"))
    import scaling

    return scaling


@pytest.mark.mpi
def test_a_pack_in_half_its_box_is_shared_and_what_ranks_send_is_counted(
    scaling: ModuleType, tmp_path: Path
) -> None:
    case = scaling.Case("case", 30, 24, 2, 80, 1, corner=True, deterministic=True)
    found, state = scaling.launch(case, tmp_path / "cut")
    even = scaling.launch(replace(case, even=True, ranks=1), tmp_path / "even")
    assert found["n"] == even[0]["n"] == 30 * 24 + 1
    record = scaling.record(case, found, None)
    assert record.extra["imbalance"] < 1.1
    assert scaling.likeness(state, even[1]) == {"apart_m": 0.0, "same_bits": True}
    # Nine numbers for each ghost and step in one message to the one neighbour; beside that four
    # messages at the beginning.
    sent = scaling.volume(case, tmp_path)
    ghosts = record.extra["ghosts_a_rank"]
    assert sent["bytes_a_step"] == pytest.approx(72.0 * ghosts, rel=0.1)
    assert sent["messages_a_step"] == pytest.approx(1.0, abs=0.1)
    assert "half" not in scaling.table([record]) and "case" in scaling.table([record])


def test_cases_cover_one_rank_to_more_than_there_are_cores(scaling: ModuleType) -> None:
    named: dict[str, list[tuple[int, int]]] = {}
    for case in scaling.cases(scaling.QUICK):
        named.setdefault(case.name, []).append((case.ranks, case.columns * case.rows))
    assert [ranks for ranks, _ in named["strong_bonded"]] == [1, 2, 4, 8]
    assert {n for _, n in named["strong_bonded"]} == {30 * 24}
    assert [n // ranks for ranks, n in named["weak_contacts"]] == [300, 300, 300, 300]


def test_the_model_of_a_day_is_bounded_by_what_ranks_do_not_share(
    scaling: ModuleType, tmp_path: Path
) -> None:
    import scaling_model as model

    machine, day = model.Machine(), model.Day()
    one = model.day_seconds(day.elements, 1, machine, day)
    assert one["neighbours"] == 0.0
    assert one["steps"] == pytest.approx(day.steps * day.elements / machine.step_rate)
    for n in model.ELEMENTS:
        each = [model.day_seconds(n, cores, machine, day) for cores in model.CORES]
        shared = np.array([model.total(e, ("whole", "samples", "neighbours")) for e in each])
        assert (np.diff(shared) < 0).all()
        assert min(model.total(e) for e in each) > n * day.whole_seconds
        # Halves of halves have shorter rims but as many messages.
        assert each[-1]["neighbours"] < each[1]["neighbours"]
    model.draw(tmp_path / "model.png")
    assert (tmp_path / "model.png").stat().st_size > 10_000
