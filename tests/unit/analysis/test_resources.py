# SPDX-License-Identifier: GPL-2.0-or-later
"""What jobs ask of a cluster: from the scene's keys, more when they come again."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from floeflow.analysis.estimate.resources import MEMORY, job_memory, job_minutes, job_ranks
from floeflow.scene import Scene, parse_scene

PROJECT = Path(__file__).resolve().parents[3]


def scene(elements: int, windows: int = 60) -> Scene:
    text = f"packing: {{elements: {elements}}}\ntime: {{windows: {windows}}}\n"
    return parse_scene(text.encode(), "a")


@pytest.mark.parametrize(("elements", "ranks"), [(200, 2), (25_000, 10), (1_000_000, 64)])
def test_ranks_follow_the_elements(elements: int, ranks: int):
    assert job_ranks(scene(elements)) == ranks


@pytest.mark.parametrize("rule", MEMORY)
def test_a_job_that_comes_again_asks_for_twice_as_much(rule: str):
    small = scene(5000)
    first, second = (job_memory(small, rule, attempt=attempt) for attempt in (1, 2))
    assert second == 2 * first and first % 50 == 0
    times = [job_minutes(small, rule, 60, attempt=attempt) for attempt in (1, 2, 3)]
    assert times[0] >= 10 and times[2] > times[1] > times[0]
    assert times[1] == pytest.approx(2 * times[0], abs=2)


def test_every_rank_holds_the_state():
    large = scene(100_000)
    one, two, three = (job_memory(large, "windows", ranks) for ranks in (1, 2, 3))
    # 1.3 GB was measured on one rank.
    assert one > 1300
    assert three - two == pytest.approx(two - one, abs=100)


def test_time_follows_windows_and_ranks():
    large = scene(100_000)
    whole, half = (job_minutes(large, "windows", windows, 1) for windows in (60, 30))
    assert whole - 10 == pytest.approx(2 * (half - 10), rel=0.1)
    assert job_minutes(large, "windows", 60, 16) < 0.5 * whole


def test_every_rule_with_a_script_asks():
    text = "\n".join(path.read_text() for path in (PROJECT / "workflows/rules").glob("*.smk"))
    asked = re.findall(r'(memory|minutes)_asked\("(\w+)"\)', text)
    assert {rule for _, rule in asked} == set(MEMORY)
    rules = re.split(r"^rule ", text, flags=re.MULTILINE)[1:]
    silent = [rule.split(":")[0] for rule in rules if "script:" in rule and "mem_mb=" not in rule]
    assert not silent
