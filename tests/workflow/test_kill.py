# SPDX-License-Identifier: GPL-2.0-or-later
"""``kill -9`` in the middle of a window, then the same command: the bits of an undisturbed run."""

from __future__ import annotations

from pathlib import Path

import pytest

from floeflow.state import read_state
from support.kills import kill_inside, wait_for_jobs
from support.kills import start_over as undo_windows
from support.runner import (
    Done,
    Place,
    bits,
    digest,
    drain,
    kill_all,
    kill_alone,
    paused,
    read_until,
)

pytestmark = pytest.mark.workflow

TARGET = "results/smoke/state/0003.nc"


def start_over(copy) -> tuple[Place, Path]:
    """A finished run whose windows are undone."""
    place = copy()
    undo_windows(place)
    return place, place.scene()


@pytest.mark.parametrize("mode", ["rank", "job", "power"])
def test_windows_that_die_in_any_way_come_again_with_the_same_bits(smoke: Done, copy, mode: str):
    place, scene = start_over(copy)
    rest = kill_inside(place, scene, TARGET, mode, "window 0002: step")
    done = rest.run(scene, TARGET)
    assert done.returncode == 0, done.stdout
    assert "window 0001: step" not in done.stdout
    assert bits(rest.results()) == bits(smoke.results)


@pytest.mark.parametrize("per_job", [1, 3])
def test_a_killed_run_continues_to_the_same_bits(smoke: Done, copy, per_job: int):
    place, _ = start_over(copy)
    scene = place.scene(workflow={"windows_per_job": per_job})
    run = place.start(scene, TARGET)
    read_until(run, "window 0002: step")
    kill_all(run)
    wait_for_jobs(place)
    assert (place.results() / ".windows/0001/state.nc").is_file()
    assert not (place.results() / "state/0002.nc").exists()
    done = place.run(scene, TARGET)
    assert done.returncode == 0, done.stdout
    assert "window 0001: step" not in done.stdout
    assert bits(place.results()) == bits(smoke.results)
    ends = [read_state(results / "state/0003.nc") for results in (place.results(), smoke.results)]
    assert digest(ends[0]) == digest(ends[1])


def test_a_killed_run_goes_on_from_the_last_state_that_was_kept(smoke: Done, copy):
    """Of a chunk only the last states stay; three windows of four are finished when it dies."""
    place, _ = start_over(copy)
    scene, target = place.scene(time={"windows": 4}), "results/smoke/state/0004.nc"
    run = place.start(scene, target)
    read_until(run, "window 0004: step")
    kill_all(run)
    wait_for_jobs(place)
    work = place.results() / ".windows"
    there = [(work / f"{window:04d}/state.nc").is_file() for window in (1, 2, 3)]
    assert there == [False, True, True]
    done = place.run(scene, target)
    assert done.returncode == 0, done.stdout
    assert "window 0004: step" in done.stdout
    assert not [line for line in done.stdout.splitlines() if "window 0003: step" in line]
    found = bits(place.results())
    assert list(found) == [1, 2, 3, 4] and bits(smoke.results).items() <= found.items()


def test_who_holds_a_scene_is_told(smoke: Done, copy):
    """To a second run, which is refused, and after the run's death to the next, which waits."""
    place, scene = start_over(copy)
    run = place.start(scene, TARGET)
    read_until(run, "window 0001: step")
    with paused(run):
        second = place.run(scene, TARGET)
        # Looking is allowed meanwhile.
        assert place.run(scene, "-n", TARGET).returncode == 0
    assert second.returncode == 1
    assert f"another run holds this scene (process {run.pid})" in second.stdout
    assert "Traceback" not in second.stdout
    read_until(run, "window 0002: step")
    with paused(run):
        kill_alone(run)
        again = place.start(scene, TARGET)
        line = read_until(again, "a job of an earlier run still writes this scene (process")
        assert line.endswith("waiting until it ends\n")
    rest = drain(again)
    assert again.returncode == 0, rest
    # What the job finished after its workflow's death is taken, not done again.
    assert "window 0002: step" not in rest
    assert bits(place.results()) == bits(smoke.results)
