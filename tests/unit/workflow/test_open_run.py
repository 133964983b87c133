# SPDX-License-Identifier: GPL-2.0-or-later
"""Groups of windows: short chains, and a longer run keeps the full groups of a shorter one."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from floeflow.scene import parse_scene
from floeflow.scene.windows import MAX_DEPTH, window_groups
from floeflow.workflow.open_run import Run


@given(windows=st.integers(1, 3000), per_job=st.integers(0, 50))
def test_groups_cover_all_windows_once(windows: int, per_job: int):
    groups = window_groups(windows, per_job)
    flat = [name for group in groups.values() for name in group]
    assert [int(name) for name in flat] == list(range(1, windows + 1))
    assert all(end == group[-1] for end, group in groups.items())
    if per_job == 0:
        assert len(groups) <= MAX_DEPTH


@given(short=st.integers(1, 60), more=st.integers(0, 60), per_job=st.integers(1, 9))
def test_a_longer_run_keeps_full_groups(short: int, more: int, per_job: int):
    now, later = window_groups(short, per_job), window_groups(short + more, per_job)
    full = {end: group for end, group in now.items() if len(group) == per_job}
    assert full.items() <= later.items()


def test_a_group_starts_where_the_one_before_ends():
    scene = parse_scene(b"", "a")
    run = Run(scene, "a.yaml", "results/a", window_groups(5, 2))
    assert run.ends == ["0002", "0004", "0005"]
    assert [run.before(end) for end in run.ends] == ["0000", "0002", "0004"]
    assert run.windows == ["0001", "0002", "0003", "0004", "0005"]
