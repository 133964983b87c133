# SPDX-License-Identifier: GPL-2.0-or-later
"""Files of a clock that is ahead: that of another node, or this one's before it was set back."""

from __future__ import annotations

import os
import time

import pytest

from floeflow.state import read_state
from support.runner import Done, bits, digest

pytestmark = [pytest.mark.cluster, pytest.mark.workflow]

TARGET = "results/smoke/state/0003.nc"
DAY = 86400.0  # s


def test_windows_go_on_from_files_of_tomorrow(smoke: Done, undone):
    """What was made before the windows is a day newer than all that they make."""
    place = undone().place
    tomorrow = time.time() + DAY
    for path in place.results().rglob("*"):
        if path.is_file() and not path.is_symlink():
            os.utime(path, (tomorrow, tomorrow))
    first, again = (place.run(smoke.scene, TARGET) for _ in range(2))
    assert first.returncode == 0, first.stdout
    assert again.returncode == 0, again.stdout
    # Windows are trusted by their hash, not by their age: what was finished is not done again.
    assert "window 0003: step" in first.stdout and "window 0003: step" not in again.stdout
    ends = [read_state(results / "state/0003.nc") for results in (place.results(), smoke.results)]
    assert bits(place.results()) == bits(smoke.results) and digest(ends[0]) == digest(ends[1])
