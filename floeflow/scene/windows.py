# SPDX-License-Identifier: GPL-2.0-or-later
"""How the coupling windows of a run are named and cut into jobs."""

from __future__ import annotations

import math

# Recursive chains of jobs exhaust Python's stack near 400; a window is one job deep.
MAX_DEPTH = 140


def window_name(number: int) -> str:
    """Name of a window in file names: at least four digits."""
    return f"{number:04d}"


def window_groups(windows: int, per_job: int) -> dict[str, list[str]]:
    """Cut windows 1..n into groups, each under the name of its last window.

    Groups start at fixed windows, so that a longer run keeps all full groups of a shorter one.

    Parameters
    ----------
    windows : int
        Number of windows of the run.
    per_job : int
        Windows in one job; 0 chooses as few as keep the chain of jobs short.
    """
    size = per_job or math.ceil(windows / MAX_DEPTH)
    groups = {}
    for first in range(1, windows + 1, size):
        names = [window_name(w) for w in range(first, min(first + size, windows + 1))]
        groups[names[-1]] = names
    return groups
