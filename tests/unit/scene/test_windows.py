# SPDX-License-Identifier: GPL-2.0-or-later
"""Chunks of windows: short chains, and a longer run keeps the full chunks of a shorter one."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from floeflow.core.errors import FloeError
from floeflow.scene import parse_scene
from floeflow.scene.windows import MAX_DEPTH, window_chunks
from floeflow.workflow.scenes import Run


@given(windows=st.integers(1, 3000), per_job=st.integers(30, 90))
def test_chunks_cover_all_windows_once(windows: int, per_job: int):
    chunks = window_chunks(windows, per_job)
    flat = [name for chunk in chunks.values() for name in chunk]
    assert [int(name) for name in flat] == list(range(1, windows + 1))
    assert all(end == chunk[-1] for end, chunk in chunks.items())
    assert len(chunks) <= MAX_DEPTH


@given(short=st.integers(1, 60), more=st.integers(0, 60), per_job=st.integers(1, 9))
def test_a_longer_run_keeps_full_chunks(short: int, more: int, per_job: int):
    now, later = window_chunks(short, per_job), window_chunks(short + more, per_job)
    full = {end: chunk for end, chunk in now.items() if len(chunk) == per_job}
    assert full.items() <= later.items()


def test_a_chain_that_is_too_long_is_refused_with_what_would_do():
    with pytest.raises(FloeError, match="windows_per_job is 2: 281 windows need 3 or more"):
        window_chunks(281, 2)
    assert len(window_chunks(280, 2)) == MAX_DEPTH


def test_a_chunk_starts_where_the_one_before_ends():
    run = Run(parse_scene(b"", "a"), window_chunks(5, 2))
    assert list(run.chunks) == ["0002", "0004", "0005"] and run.last == "0005"
    assert [run.before(chunk) for chunk in run.chunks] == ["0000", "0002", "0004"]
    assert run.windows == ["0001", "0002", "0003", "0004", "0005"]
