# SPDX-License-Identifier: GPL-2.0-or-later
"""What is said of a run before it begins and at its end."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from floeflow.analysis.estimate.expected import (
    as_size,
    as_time,
    expectation,
    expected,
    outcome,
    two_digits,
)
from floeflow.analysis.estimate.resources import outline
from floeflow.scene import Scene, load_scene
from floeflow.workflow.forecast import forecast, rank_count

ROOT = Path(__file__).parents[3]


@pytest.fixture
def scene() -> Scene:
    return load_scene(ROOT / "config/scenes/arctic_1981.yaml")


def changed(scene: Scene, block: str, **values: object) -> Scene:
    part = getattr(scene, block).model_copy(update=values)
    return scene.model_copy(update={block: part})


def test_more_elements_windows_and_categories_take_longer_and_more_room(scene: Scene):
    one = expected(scene, 1)
    assert outline(scene).elements <= one.elements < 1.3 * scene.packing.elements
    assert one.windows == scene.time.windows
    for more in (
        changed(scene, "packing", elements=4 * scene.packing.elements),
        changed(scene, "time", windows=4 * scene.time.windows),
        changed(scene, "column", categories=2 * scene.column.categories),
    ):
        other = expected(more, 1)
        assert other.seconds > one.seconds and other.size > one.size
    assert expected(scene, 2).seconds < one.seconds
    # A column that resolves layers costs more than one that does not.
    simple = expected(changed(scene, "column", scheme="zero_layer"), 1)
    assert simple.seconds < one.seconds


def test_all_states_take_more_room_than_those_of_chunks(scene: Scene):
    found = expected(scene, 1)
    kept = expected(changed(scene, "state", keep="all"), 1)
    assert kept.size > found.size


def test_the_sentences_name_sizes_times_and_room(scene: Scene):
    found = replace(expected(scene, 2), elements=5518, steps=10234, seconds=231.0, size=1.234e8)
    said = expectation(found, 2)
    assert said.startswith("Expected: 5,518 elements, 5 windows of 24 h in 10,000 steps; ")
    assert said.endswith("about 3.9 min on 2 ranks, 120 MB on disk")
    assert outcome(found, 250.0, 1.1e8) == (
        "Took 4.2 min (expected: 3.9 min) and 110 MB on disk (expected: 120 MB)"
    )


@pytest.mark.parametrize(
    ("value", "said"), [(0.5, "0.5"), (9.96, "10"), (12.4, "12"), (123.0, "120"), (98765, "99,000")]
)
def test_estimates_have_two_digits(value: float, said: str):
    assert two_digits(value) == said


def test_times_and_sizes_are_said_in_their_best_unit():
    assert [as_time(s) for s in (5.0, 600.0, 7200.0, 3e5)] == ["5 s", "10 min", "2 h", "3.5 d"]
    assert [as_size(b) for b in (2e6, 3.4e8, 1.2e9, 5e13)] == ["2 MB", "340 MB", "1.2 GB", "50 TB"]


def workflow(jobs: list[tuple[str, str, str]], local: bool = True, **settings: object):
    """What a forecast asks of Snakemake: jobs as rule, scene and chunk."""
    about = [
        SimpleNamespace(rule=SimpleNamespace(name=rule), wildcards={"scene": name, "chunk": chunk})
        for rule, name, chunk in jobs
    ]
    dag = SimpleNamespace(needrun_jobs=lambda: iter(about))
    return SimpleNamespace(dag=dag, local_exec=local, resource_settings=SimpleNamespace(**settings))


def test_only_a_run_of_all_windows_is_forecast(scene: Scene, tmp_path: Path):
    whole = [("windows", scene.name, "0003"), ("windows", scene.name, "0005")]
    other = [*whole, ("windows", "else", "0001"), ("mask", scene.name, "")]
    found = forecast(scene, ["0003", "0005"], workflow(other, cores=2))
    assert found is not None and found.first_line().startswith("Expected: ")
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub/file").write_bytes(bytes(3_000_000))
    assert "and 3 MB on disk" in found.last_line(tmp_path)
    # One that goes on, or another target such as a study, is none.
    assert forecast(scene, ["0003", "0005"], workflow(whole[1:], cores=2)) is None
    assert forecast(scene, ["0003"], workflow([], cores=2)) is None


def test_ranks_are_the_threads_that_there_are_cores_for(scene: Scene):
    assert rank_count(scene, workflow([], cores=8)) == 2
    assert rank_count(scene, workflow([], cores=1)) == 1
    assert rank_count(scene, workflow([], cores=8, overwrite_threads={"windows": 4})) == 4
    # On a cluster, what the scene's size asks for.
    large = changed(scene, "packing", elements=20_000)
    assert rank_count(large, workflow([], local=False, cores=None)) == 8
